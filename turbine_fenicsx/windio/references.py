"""Numbers of a windIO file that follow from others as well; no turbine is built from them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.curves import Curve, read_curve, read_grid
from turbine_fenicsx.windio.entry import Entry

SIZE = 6
"""Number of the coefficients ``mu``: two of shear, stretch, two of bending, torsion."""


@dataclass(frozen=True)
class References:
    """Numbers to compare with; None for those that are missing or wrong.

    Args:
        rotor_diameter: Of the rotor [m].
        gear_ratio: 1 for a direct drive [-].
        generator_mass: Beside the properties of the generator [kg].
        tower_mass: By the section properties of the tower [kg].
        foundation_top: Height of the upper end of a monopile [m].
        damping: Sentences about the structural damping that is not read.
    """

    rotor_diameter: float | None = None
    gear_ratio: float | None = None
    generator_mass: float | None = None
    tower_mass: float | None = None
    foundation_top: float | None = None
    damping: tuple[str, ...] = ()


def read_references(root: Entry) -> References:
    """The numbers of a file."""
    assembly, components = root["assembly"], root["components"]
    return References(
        _try(lambda: assembly["rotor_diameter"].positive()),
        _try(lambda: _read_gear_ratio(assembly)),
        _try(lambda: components["drivetrain"]["generator"]["mass"].positive()),
        _try(lambda: _read_tower_mass(components["tower"])),
        _try(lambda: float(_read_heights(components["monopile"])[-1])),
        tuple(x for name in ("blade", "tower") for x in _find_unread_damping(components, name)),
    )


def _find_unread_damping(components: Entry, name: str) -> Iterator[str]:
    """Sentences about what `structural_damping` holds besides coefficients of bending."""
    structure = components[name].get("structure") if name in components else None
    properties = structure.get("elastic_properties") if structure else None
    damping = properties.get("structural_damping") if properties else None
    if damping is None or not isinstance(damping.value, dict):
        return
    mu = damping.value.get("mu")
    if isinstance(mu, list) and len(mu) == SIZE and any(mu) and not any(mu[3:5]):
        shown = ", ".join(f"{x:g}" for x in damping["mu"].numbers())
        yield f"{damping.place}.mu = [{shown}], which has nothing for bending"
    for key in damping.value.keys() - {"mu"}:
        yield f"{damping.place}.{key}"


def _try(read: Callable[[], float | None]) -> float | None:
    """The number that a function reads; None where a value is missing or wrong."""
    with suppress(ModelError):
        return read()
    return None


def _read_gear_ratio(assembly: Entry) -> float | None:
    kind = assembly["drivetrain"].text().lower().replace("_", " ")
    return 1.0 if kind == "direct drive" else None


def _read_tower_mass(tower: Entry) -> float:
    table = tower["structure"]["elastic_properties"]["inertia_matrix"]
    grid = read_grid(table["grid"])
    mass = Curve(grid, table["mass"].numbers(len(grid)))
    return float(np.ptp(_read_heights(tower))) * mass.integral


def _read_heights(component: Entry) -> Array:
    return read_curve(component["reference_axis"]["z"], -1e4, 1e4).values

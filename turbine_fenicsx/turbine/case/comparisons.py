"""Numbers that a case and its windIO file give in more than one way, held against each other.

A new comparison is a row of `COMPARISONS`, a new derived quantity a row of `DERIVED`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from turbine_fenicsx.foundation.plausible import Plausible
from turbine_fenicsx.turbine.case.turbine_file import load_case_turbine
from turbine_fenicsx.turbine.tables.blade import find_mass_warning
from turbine_fenicsx.turbine.tables.tables import Tables

if TYPE_CHECKING:  # cases without a file do not wait for what reads one
    from turbine_fenicsx.windio import WindIOTurbine

MIN_PREBEND = -0.002
"""Smallest distance of a tip from the straight blade, away from the tower, over the length [-]."""


@dataclass(frozen=True)
class Source:
    """One way to a number.

    Args:
        place: Where it stands, or how it follows, as a subject of a sentence.
        find: The number in SI units; several where the format leaves open which is meant; None
            where it is not given.
    """

    place: str
    find: Callable[[Tables, WindIOTurbine], float | tuple[float, ...] | None]


@dataclass(frozen=True)
class Comparison:
    """Two ways to one number.

    Args:
        tolerance: Relative difference up to which they agree.
        at_least: Whether the first may be larger than the second.
    """

    one: Source
    other: Source
    tolerance: float
    unit: str
    scale: float = 1.0
    at_least: bool = False

    def describe(self, case: Tables, turbine: WindIOTurbine) -> str:
        """A sentence if the two disagree; else nothing."""
        first, second = (source.find(case, turbine) for source in (self.one, self.other))
        if first is None or second is None:
            return ""
        one, others = float(np.max(first)), np.ravel(second).astype(float)
        low, high = float(others.min()), float(others.max())
        allowed = self.tolerance * max(abs(one), abs(high))
        if low - allowed <= one and (self.at_least or one <= high + allowed):
            return ""
        unit = f" {self.unit}" if self.unit else ""
        but = "but at least " if self.at_least else "but "
        return (
            f"{self.one.place} is {one / self.scale:.4g}{unit}, {but}{self.other.place} is "
            f"{float(others[0]) / self.scale:.4g}{unit}"
        )


def _rotor_diameter(case: Tables, turbine: WindIOTurbine) -> tuple[float, ...]:
    """With the cone and without, which files mean by turns."""
    reach = turbine.blade.outer_shape.axis[2].values[-1]
    straight = 2.0 * (case.blade.hub_radius + float(reach))
    return straight * cos(case.turbine.precone), straight


def _hub_height(case: Tables, turbine: WindIOTurbine) -> float | None:
    if turbine.tower is None:
        return None
    height = case.tower.height if case.tower.flexible else turbine.tower.top - turbine.tower.base
    return turbine.tower.base + height + case.turbine.hub_rise


def _layup_mass(case: Tables, turbine: WindIOTurbine) -> float | None:
    blade = turbine.blade
    return blade.length * blade.line_mass.integral if blade.has_layup else None


def _section_mass(case: Tables, turbine: WindIOTurbine) -> float | None:
    sections = turbine.blade_sections
    return turbine.blade.length * sections.line_mass.integral if sections else None


def _torque_power(case: Tables, turbine: WindIOTurbine) -> float | None:
    """Power at rated speed with the largest torque."""
    c, gear = turbine.control, turbine.nacelle.gear_ratio if turbine.nacelle else 1.0
    if c is None or not c.largest_torque or not c.rated_speed:
        return None
    return c.largest_torque * c.rated_speed * gear


def _electrical_power(case: Tables, turbine: WindIOTurbine) -> float | None:
    if case.control.kind != "pi":
        return None
    return case.control.torque.rated_power * case.drivetrain.efficiency


def _generator_mass(case: Tables, turbine: WindIOTurbine) -> float | None:
    part = turbine.nacelle.generator if turbine.nacelle else None
    return part.mass if part else None


def _drivetrain_mass(case: Tables, turbine: WindIOTurbine) -> float | None:
    part = turbine.nacelle.body if turbine.nacelle else None
    return part.mass if part else None


def _wind_height(case: Tables, turbine: WindIOTurbine) -> float | None:
    """That of the case, if it is another one than that of the file."""
    height = case.wind.hub_height if case.wind.blows else None
    return None if height == turbine.hub_height else height


_CENTRE = Source("the rotor centre above the tower", _hub_height)
_RATED_POWER = Source("assembly.rated_power", lambda case, turbine: turbine.rated_power)
_LAYUP = Source("the mass of its layup", _layup_mass)
_WALLS = Source("the mass of its walls", lambda case, t: t.tower.mass if t.tower else None)

COMPARISONS = (
    Comparison(
        Source("assembly.rotor_diameter", lambda case, turbine: turbine.references.rotor_diameter),
        Source("2 (hub radius + height of the tip) cos(cone)", _rotor_diameter),
        0.005,
        "m",
    ),
    Comparison(
        Source("assembly.hub_height", lambda case, turbine: turbine.hub_height),
        _CENTRE,
        0.02,
        "m",
    ),
    Comparison(Source("wind.hub_height", _wind_height), _CENTRE, 0.02, "m"),
    Comparison(
        Source("blade.hub_radius", lambda case, turbine: case.blade.hub_radius),
        Source("hub.diameter / 2", lambda case, turbine: turbine.hub.radius),
        0.05,
        "m",
    ),
    Comparison(
        Source("the base of the tower", lambda case, t: t.tower.base if t.tower else None),
        Source("the top of the monopile", lambda case, turbine: turbine.references.foundation_top),
        0.05,
        "m",
    ),
    Comparison(
        Source("control.rated_power", lambda case, t: t.control.rated_power if t.control else None),
        _RATED_POWER,
        0.02,
        "MW",
        1e6,
    ),
    Comparison(
        Source("control.torque.rated_power x drivetrain.efficiency", _electrical_power),
        _RATED_POWER,
        0.08,
        "MW",
        1e6,
    ),
    Comparison(
        Source("control.max_gen_torque x rated speed", _torque_power),
        _RATED_POWER,
        0.02,
        "MW",
        1e6,
        at_least=True,
    ),
    Comparison(
        Source("gearbox.gear_ratio", lambda case, t: t.nacelle.gear_ratio if t.nacelle else None),
        Source("that of a direct drive", lambda case, turbine: turbine.references.gear_ratio),
        1e-6,
        "",
    ),
    Comparison(
        Source("the mass of blade.structure.elastic_properties", _section_mass),
        _LAYUP,
        0.1,
        "t",
        1e3,
    ),
    Comparison(
        Source(
            "the mass of tower.structure.elastic_properties",
            lambda case, turbine: turbine.references.tower_mass,
        ),
        _WALLS,
        0.1,
        "t",
        1e3,
    ),
    Comparison(
        Source("generator.mass", lambda case, turbine: turbine.references.generator_mass),
        Source("that of generator.elastic_properties", _generator_mass),
        0.05,
        "t",
        1e3,
    ),
    Comparison(
        Source("drivetrain.elastic_properties.mass", _drivetrain_mass),
        Source("that of its generator", _generator_mass),
        0.0,
        "t",
        1e3,
        at_least=True,
    ),
)
"""Comparisons of a file and its case."""


# --- quantities that follow from several numbers


def _tip_speed(case: Tables, turbine: WindIOTurbine) -> float:
    speed = turbine.control.rated_speed if turbine.control else None
    return (speed or 0.0) * (case.blade.hub_radius + case.blade.length)


def _specific_power(case: Tables, turbine: WindIOTurbine) -> float:
    return (turbine.rated_power or 0.0) / (pi * max(_rotor_diameter(case, turbine)) ** 2 / 4.0)


def _blade_sound(case: Tables, turbine: WindIOTurbine) -> float:
    """Of the section properties: axial stiffness over mass, in the middle of the blade."""
    sections = turbine.blade_sections
    if sections is None:
        return 0.0
    middle = len(sections.grid) // 2
    mass = max(float(sections.inertia[middle, 0, 0]), 1e-30)
    return sqrt(max(float(sections.stiffness[middle, 2, 2]), 0.0) / mass)


DERIVED: tuple[tuple[str, str, Plausible, Callable[[Tables, WindIOTurbine], float]], ...] = (
    ("the speed of the tips at control.rated_rotor_speed", "m/s", Plausible(20, 130), _tip_speed),
    ("the rated power per area of the rotor", "W/m^2", Plausible(80, 1200), _specific_power),
    (
        "the speed of sound along the blade, sqrt(K33 / mass) of its elastic_properties,",
        "m/s",
        Plausible(1e3, 2e4),
        _blade_sound,
    ),
)
"""Quantities of a file with their usual sizes."""


def compare_file(case: Tables) -> Iterator[str]:
    """A sentence for everything that a windIO file, with its case, says in two ways."""
    if case.turbine.file is None:
        return
    turbine, name = load_case_turbine(case), Path(case.turbine.file).name
    yield from turbine.warnings
    for comparison in COMPARISONS:
        sentence = comparison.describe(case, turbine)
        if sentence:
            yield f"{name}: {sentence}"
    for what, unit, usual, find in DERIVED:
        for value in usual.find_outliers([find(case, turbine)]):
            yield usual.describe(f"{name}: {what}", value, unit, "is a unit wrong?")
    mass = _layup_mass(case, turbine) or _section_mass(case, turbine)
    doubts = find_mass_warning(mass, turbine.blade.length) if mass else []
    yield from (f"{name}: {sentence}" for sentence in doubts)
    yield from _doubt_prebend(turbine, name)


def _doubt_prebend(turbine: WindIOTurbine, name: str) -> Iterator[str]:
    """Blades in front of a tower bend away from it, which is to negative x."""
    x, z = (turbine.blade.outer_shape.axis[k].values[-1] for k in (0, 2))
    if -x < MIN_PREBEND * z:
        yield (
            f"{name}: blade.reference_axis.x ends with {x:.4g} m, a prebend towards the tower; x "
            "points downwind, and a rotor in front of the tower has negative values"
        )

"""Polars of a blade's airfoils in a windIO file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.airfoils import SAME_THICKNESS
from turbine_fenicsx.windio.entry import Entry

QUARTER = 0.25
"""The aerodynamic centre of an airfoil for which the file has none [-]."""

_SUM = 1e-6
"""Weights of polar sets may add up to 1 with this error."""


@dataclass(frozen=True, eq=False)
class AirfoilPolar:
    """Coefficients of an airfoil as the file has them.

    Args:
        thickness: Its relative thickness [-].
        aerodynamic_centre: Where the moment is taken, a fraction of the chord from the leading
            edge [-].
        angle: Angles of attack, shape (n,) [deg].
        lift: C_l, shape (n,) [-].
        drag: C_d, shape (n,) [-].
        moment: C_m, positive nose up, shape (n,) [-].
        positions: Span fractions where the blade has the airfoil, which distinguish polars of one
            thickness; none where the file does not say [-].
    """

    name: str
    thickness: float
    aerodynamic_centre: float
    angle: Array
    lift: Array
    drag: Array
    moment: Array
    positions: tuple[float, ...] = ()


@dataclass(frozen=True)
class PolarSource:
    """Where the polars of a blade stand in a file.

    They are read when aerodynamics need them, so that a file without polars is still one of a
    structure.

    Args:
        used: The list of those that the blade uses.
    """

    airfoils: Entry
    used: Entry

    @property
    def file(self) -> str:
        """Name of the file."""
        return self.used.file

    def read(self, thicknesses: dict[str, float]) -> tuple[AirfoilPolar, ...]:
        """The polars of the airfoils that the blade uses.

        Args:
            thicknesses: Relative thicknesses of these airfoils by name.

        Returns:
            By rising thickness, those of one thickness by rising position.
        """
        known = {entry["name"].text(): entry for entry in self.airfoils.entries()}
        found: dict[str, AirfoilPolar] = {}
        places: dict[str, list[float]] = {}
        for k, value in enumerate(self.used.value):
            use = Entry(value, self.used.file, f"{self.used.place}[{k}]")
            name = use["name"].text()
            if name not in found:
                found[name] = _read_polar(known[name], use, name, thicknesses[name])
            if "spanwise_position" in use:
                place = use["spanwise_position"].number(0.0, 1.0)
                places.setdefault(name, []).append(place)
        polars = [replace(p, positions=tuple(places.get(p.name, ()))) for p in found.values()]
        rising = sorted(polars, key=lambda p: (p.thickness, p.positions))
        for one, other in pairwise(rising):
            same = other.thickness - one.thickness < SAME_THICKNESS
            if same and (not one.positions or set(one.positions) & set(other.positions)):
                self.used.fail(
                    f"uses {one.name!r} and {other.name!r}, which have the same relative thickness "
                    f"{one.thickness:g}: give each its own 'spanwise_position'"
                )
        return tuple(rising)


def _read_polar(airfoil: Entry, use: Entry, name: str, thickness: float) -> AirfoilPolar:
    """The polar of an airfoil: the mean of its configurations by their weights."""
    sets = {}
    for k, value in enumerate(_list(airfoil["polars"])):
        entry = Entry(value, airfoil.file, f"{airfoil.place}.polars[{k}]")
        sets[entry["configuration"].text() if "configuration" in entry else ""] = entry
    weights = _read_weights(use, list(sets))
    tables = [_read_set(sets[key], use) for key in weights]
    angle = np.unique(np.concatenate([grid for table in tables for grid, _ in table]))
    values = np.zeros((3, len(angle)))
    for weight, table in zip(weights.values(), tables, strict=True):
        values += weight * np.stack([np.interp(angle, *column) for column in table])
    given = airfoil.get("aerodynamic_center")
    centre = given.number(0.0, 1.0) if given else QUARTER
    return AirfoilPolar(name, thickness, centre, angle, *values)


def _read_weights(use: Entry, known: list[str]) -> dict[str, float]:
    """Weights of the configurations that a blade asks for; of the only one where it asks none."""
    if "configuration" not in use:
        if len(known) > 1:
            use.fail(
                f"has no 'configuration', but its airfoil has polars of several: {', '.join(known)}"
            )
        return {known[0]: 1.0}
    names = [
        Entry(value, use.file, f"{use.place}.configuration[{k}]").text()
        for k, value in enumerate(_list(use["configuration"]))
    ]
    for name in names:
        if name not in known:
            use["configuration"].fail(
                f"names {name!r}, but the polars of the airfoil are of {', '.join(known)}"
            )
    if len(set(names)) < len(names):
        use["configuration"].fail("names one set of polars twice")
    weights = use["weight"].numbers(len(names)) if "weight" in use else np.ones(1)
    if len(weights) != len(names) or weights.min() < 0.0 or abs(weights.sum() - 1.0) > _SUM:
        use.fail("must have a 'weight' for each configuration, none negative, with the sum 1")
    return dict(zip(names, weights.tolist(), strict=True))


def _read_set(entry: Entry, use: Entry) -> list[tuple[Array, Array]]:
    """Angles and values of C_l, C_d and C_m."""
    reynolds = _list(entry["re_sets"])
    if len(reynolds) > 1:
        entry["re_sets"].fail(
            f"holds polars of {len(reynolds)} Reynolds numbers, of which one can be used: leave "
            "that of rated operation"
        )
    table = Entry(reynolds[0], entry.file, f"{entry.place}.re_sets[0]")
    found = []
    for key in ("cl", "cd", "cm"):
        grid, values = table[key]["grid"].numbers(), table[key]["values"].numbers()
        if len(grid) != len(values):
            table[key].fail(f"has {len(grid)} angles, but {len(values)} values")
        if len(grid) < 2 or not np.all(np.diff(grid) > 0.0):
            table[key]["grid"].fail("must hold two or more angles that rise")
        found.append((grid, values))
    if len({(grid[0], grid[-1]) for grid, _ in found}) > 1:
        table.fail("must have cl, cd and cm over the same range of angles")
    return found


def _list(entry: Entry) -> list[object]:
    """The values of a list that is not empty."""
    if not isinstance(entry.value, list) or not entry.value:
        entry.fail("must be a list of one or more tables or names")
    return entry.value

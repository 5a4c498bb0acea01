"""Channels of ``history.out``: OpenFAST's names with units, axes, meaning and source.

The table is ``openfast_channels.txt``. Components give values in SI units under the first name of a
row; the unit of the file and the other names follow from there.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from itertools import product
from math import pi
from pathlib import Path

from turbine_fenicsx.foundation.text_files import suggest

AXES = {
    "t": "tower, fixed to the ground: x downwind, y to the left looking downwind, z up",
    "p": "top of the tower, turning with it: at rest those of the tower",
    "n": "nacelle: those of the top of the tower, turned by the yaw angle",
    "s": "shaft, fixed to the nacelle: x along the shaft downwind, y to the left, z up",
    "a": "hub: x along the shaft downwind, z across it towards blade 1, y = z cross x",
    "tl": "tower, turning with the section: at rest those of the tower",
    "c": "blade, fixed to the hub: x downwind, z along the span to the tip, y = z cross x",
    "b": "blade, pitching with it: those fixed to the hub at pitch 0",
    "bl": "blade, turning with the section but not with its twist at rest: there those that pitch",
    "plane": "x normal to the plane of the rotor, downwind; y against the way of the section",
    "chord": "n normal to the chord, to the suction side; t along it, to the leading edge",
    "i": "ground: X downwind, Y to the left looking downwind, Z up",
    "": "",
}
"""Axes of components; all are right-handed."""

DEFAULT = "default"
"""Stands for the channels that runs have unless others are chosen."""

_DEGREE, _RPM = 180.0 / pi, 30.0 / pi
_FACTORS = {"kN": 1e-3, "kN-m": 1e-3, "kW": 1e-3, "rpm": _RPM} | dict.fromkeys(
    ("deg", "deg/s", "deg/s^2"), _DEGREE
)
_FIELDS: dict[str, Iterable[object]] = {
    "axis": "xyz",
    "yz": "yz",
    "Axis": "XYZ",
    "blade": "123",
    "node": range(1, 100),
    "section": range(1, 100),
}
_FIELD = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class OpenFastRow:
    """A row of the table.

    Args:
        names: Names of equal channels, with fields for axis, blade, node or section.
        unit: Unit in the file.
        axes: Key of `AXES`.
        default: Whether runs have the channel unless others are chosen.
        meaning: What it is, and its sign.
        source: What it is made of.
    """

    names: tuple[str, ...]
    unit: str
    axes: str
    default: bool
    meaning: str
    source: str

    @property
    def factor(self) -> float:
        """Factor of a value in SI units."""
        return _FACTORS.get(self.unit, 1.0)

    def expand(self) -> Iterator[tuple[str, ...]]:
        """Equal names for all axes, blades and nodes."""
        fields = list(dict.fromkeys(_FIELD.findall(self.names[0])))
        for values in product(*(_FIELDS[field] for field in fields)):
            filled = dict(zip(fields, values, strict=True))
            yield tuple(name.format(**filled) for name in self.names)


@cache
def read_rows() -> tuple[OpenFastRow, ...]:
    """The rows of the table."""
    found = []
    text = Path(__file__).with_name("openfast_channels.txt").read_text("utf-8")
    for line in text.splitlines()[1:]:
        if line and not line.startswith("#"):
            names, unit, axes, default, meaning, source = (x.strip() for x in line.split("|"))
            found.append(
                OpenFastRow(tuple(names.split()), unit, axes, bool(default), meaning, source)
            )
    return tuple(found)


@cache
def _find_all() -> dict[str, tuple[OpenFastRow, tuple[str, ...]]]:
    """Row and equal names of every name."""
    return {name: (row, names) for row in read_rows() for names in row.expand() for name in names}


def find_row(name: str) -> OpenFastRow | None:
    """The row of a channel; None for one that the table does not have."""
    found = _find_all().get(name)
    return found and found[0]


def list_equal(name: str) -> tuple[str, ...]:
    """All names of a channel, for one that the table does not have its own."""
    found = _find_all().get(name)
    return found[1] if found else (name,)


def is_default(name: str) -> bool:
    """Whether runs have a channel unless others are chosen, under the first of its names."""
    row = find_row(name)
    return row is not None and row.default and name == list_equal(name)[0]


def matches(name: str, patterns: Iterable[str]) -> bool:
    """Whether a channel is chosen by patterns such as ``"RootM*"``; case does not count."""
    return any(
        is_default(name) if pattern == DEFAULT else fnmatchcase(name.lower(), pattern.lower())
        for pattern in patterns
    )


def find_unknown(patterns: Iterable[str]) -> str:
    """A sentence about a pattern that no name of the table fits; nothing if all are known."""
    for pattern in patterns:
        if pattern != DEFAULT and not any(matches(name, [pattern]) for name in _find_all()):
            return f"no channel is called {pattern!r}{suggest(pattern, _find_all())}"
    return ""

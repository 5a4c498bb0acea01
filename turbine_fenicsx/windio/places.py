"""Places along contours of a blade, and what they follow from."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.curves import Curve
from turbine_fenicsx.windio.entry import Entry

HANDLES = ("start_nd_arc", "end_nd_arc", "midpoint_nd_arc")
"""Handles of an anchor."""

WIDEST = 100.0
"""Maximum width of an anchor [m]."""

TOLERANCE = 1e-4
"""Places may lie outside of 0 to 1 by this much."""

FINE = np.linspace(0.0, 1.0, 101)
"""Stations between which places that follow from a width are straight."""


class Contours(Protocol):
    """Sections of an outer surface, which widths, offsets and planes refer to."""

    def girth(self, s: Array) -> Array:
        """Length of the contour at span fractions, (m,) [m]."""

    def reference_points(self, s: Array) -> Array:
        """Points of the reference axis, (m, 3) [m]."""

    def points(self, s: Array, a: Array) -> Array:
        """Points of the surface at span and contour fractions [m]."""

    def leading_edge(self, s: Array) -> Array:
        """Contour fraction of the foremost point, (m,) [-]."""


def is_whole(given: Curve) -> bool:
    """Whether places are one end of the contour everywhere, as a file that resolves nothing has."""
    return bool(np.all(given.values <= TOLERANCE) or np.all(given.values >= 1.0 - TOLERANCE))


def shift_places(given: Curve, distance: Curve, unit: Array, entry: Entry) -> Curve:
    """Places at distances, in units that are given at fine stations, from others."""
    grid = np.unique(np.concatenate([distance.grid, given.grid, FINE]))
    first, last = max(distance.start, given.start), min(distance.end, given.end)
    s = grid[(grid >= first) & (grid <= last)]
    if len(s) < 2:
        entry.fail("has no stations in common with the place that it starts from")
    place = given(s) + distance(s) * np.interp(s, FINE, unit)
    return Curve(s, np.clip(place, 0.0, 1.0))


def list_defined(entry: Entry) -> list[str]:
    """Handles that a width or a plane defines; a width both ends where it names none."""
    named = entry.get("defines")
    if named is None:
        return list(HANDLES[:2])
    handles = named.value if isinstance(named.value, list) else [named.value]
    for handle in handles:
        if handle not in HANDLES:
            named.fail(f"must name {' or '.join(HANDLES)}, got {quote(handle)}")
    return handles

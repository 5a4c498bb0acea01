"""Airfoils of a windIO file, and sections between them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.curves import make_spline
from turbine_fenicsx.windio.entry import Entry

if TYPE_CHECKING:
    pass

FACE = 20
"""Intervals on each half of the trailing edge's face."""

BODY = 800
"""Intervals from corner to corner around the leading edge, which is cut off by 3e-4 of the chord
where an airfoil of the two reference turbines is sharpest, and by 1e-4 elsewhere."""

_SHARPEST = np.radians(25.0)
"""A contour that turns by less has no corner."""

_NEAR = 0.15
"""Corners are sought in this fraction of the contour beside the trailing edge."""

MIN_EDGE_WIDTH = 1e-3
"""Trailing edges that are narrower are cut off where they are as wide [-]."""

_ROUND_FACE = 0.004
"""Least fraction of the contour from the middle of a round trailing edge to where its neighbour's
corners continue: narrow faces make thick walls of a root overlap [-]."""

_DEEPEST = 0.05
"""Largest fraction of the contour that is cut off on either side [-]."""

SAME_THICKNESS = 1e-6
"""Airfoils whose relative thicknesses differ by less must have one contour [-]."""

_SAME_SHAPE = 0.01
"""Largest distance of two contours that are one, in chords [-]."""

_OUTSIDE = 0.02
"""Relative thicknesses may exceed those of the airfoils by this much, which hold there."""


@dataclass(frozen=True, eq=False)
class Airfoil:
    """A contour that begins and ends in the middle of the trailing edge.

    Args:
        thickness: Relative thickness [-].
        points: x from leading to trailing edge and y to the suction side in units of chord, along
            the suction side first, shape (n, 2).
        arcs: Fraction of the contour of each point, shape (n,) [-].
        corners: Fractions of the trailing edge's two corners, which coincide with its ends where
            it is sharp; None if it is round.
    """

    name: str
    thickness: float
    points: Array
    arcs: Array
    corners: tuple[float, float] | None

    def resample(self, corners: tuple[float, float]) -> Array:
        """Points at given intervals of three pieces, (2 FACE + BODY + 1, 2)."""
        first, last = corners
        pieces = ((0.0, first, FACE), (first, last, BODY), (last, 1.0, FACE))
        resampled = []
        for begin, end, n in pieces:
            inside = (self.arcs > begin + 1e-9) & (self.arcs < end - 1e-9)
            at = np.unique(np.concatenate([[begin], self.arcs[inside], [end]]))
            known = np.column_stack([np.interp(at, self.arcs, column) for column in self.points.T])
            wanted = np.linspace(begin, end, n + 1)
            if len(at) < 2:  # a sharp edge has no face
                resampled.append(np.repeat(known, n + 1, axis=0))
            else:
                resampled.append(np.asarray(make_spline(at, known)(wanted)))
        return np.concatenate([resampled[0], resampled[1][1:], resampled[2][1:]])


class Sections:
    """Sections of any relative thickness between those of some airfoils.

    Points at equal fractions of the contour, corners apart, follow monotone splines (PCHIP) over
    the relative thickness, as the definition of windIO asks for. Corners are a separate piece so
    that they stay sharp between two airfoils; a round trailing edge has them where its neighbour
    does. A trailing edge narrower than a thousandth of the chord is cut off where it is as wide.
    """

    def __init__(self, airfoils: list[Airfoil]) -> None:
        self.airfoils = tuple(sorted(airfoils, key=lambda airfoil: airfoil.thickness))
        by_thickness = _leave_out_twins(self.airfoils)
        sharp = [airfoil for airfoil in by_thickness if airfoil.corners]
        contours = []
        for airfoil in by_thickness:
            near = min(sharp, key=lambda a: abs(a.thickness - airfoil.thickness), default=None)
            first, last = (near and near.corners) or (0.0, 1.0)
            if airfoil.corners is None and near is not None:
                first, last = max(first, _ROUND_FACE), min(last, 1.0 - _ROUND_FACE)
            contours.append(airfoil.resample((first, last)))
        self.thicknesses = np.array([airfoil.thickness for airfoil in by_thickness])
        self._contours, self._has_edge = np.array(contours), bool(sharp)
        self._at = make_spline(self.thicknesses, self._contours) if len(contours) > 1 else None

    def contour(self, thickness: float) -> tuple[Array, Array]:
        """Points of a section in units of chord, and their fractions of the contour.

        Args:
            thickness: Relative thickness [-].

        Returns:
            Shapes (2 FACE + BODY + 1, 2) and (2 FACE + BODY + 1,); points FACE and FACE + BODY are
            the corners of the trailing edge.
        """
        points = self._contours[0]
        if self._at is not None:
            inside = np.clip(thickness, self.thicknesses[0], self.thicknesses[-1])
            points = np.asarray(self._at(inside))
        if self._has_edge and np.hypot(*(points[FACE] - points[FACE + BODY])) < MIN_EDGE_WIDTH:
            points = _cut_edge(points)
        return points, _find_arcs(points)


def read_sections(airfoils: Entry, used: Entry, thicknesses: Array, stations: Array) -> Sections:
    """The sections of a blade.

    Args:
        used: The list of those that the blade uses.
        thicknesses: Relative thicknesses of the blade, (n,) [-].
        stations: Span fractions of these, (n,) [-].
    """
    known = {entry["name"].text(): entry for entry in airfoils.entries()}
    found: dict[str, Airfoil] = {}
    if not isinstance(used.value, list) or not used.value:
        used.fail("must be a list of one or more airfoils")
    for k, value in enumerate(used.value):
        name = Entry(value, used.file, f"{used.place}[{k}]")["name"].text()
        if name not in known:
            used.fail(f"names {name!r}, which is not among the airfoils of the file")
        if name not in found:
            found[name] = _read_airfoil(known[name], name)
    chosen = sorted(found.values(), key=lambda airfoil: airfoil.thickness)
    for one, other in pairwise(chosen):
        same = other.thickness - one.thickness < SAME_THICKNESS
        if same and not _is_same_shape(one, other):
            used.fail(
                f"uses {one.name!r} and {other.name!r}, which have the same relative thickness "
                f"{one.thickness:g} and different contours, so that nothing can be put between them"
            )
    least, most = chosen[0].thickness - _OUTSIDE, chosen[-1].thickness + _OUTSIDE
    for s, thickness in zip(stations, thicknesses, strict=True):
        if not least <= thickness <= most:
            used.fail(
                f"have relative thicknesses from {chosen[0].thickness:g} to "
                f"{chosen[-1].thickness:g}, but rthick is {thickness:g} at station {s:g}"
            )
    return Sections(chosen)


def _leave_out_twins(airfoils: tuple[Airfoil, ...]) -> list[Airfoil]:
    """The first airfoil of each relative thickness, by rising thickness."""
    chosen: list[Airfoil] = []
    for airfoil in airfoils:
        if not chosen or airfoil.thickness - chosen[-1].thickness >= SAME_THICKNESS:
            chosen.append(airfoil)
    return chosen


def _cut_edge(points: Array) -> Array:
    """A section with a flat trailing edge where it is as wide as `MIN_EDGE_WIDTH`."""
    body = points[FACE : FACE + BODY + 1]
    arcs = _find_arcs(body)

    def find_ends(depth: float) -> Array:
        at = depth, 1.0 - depth
        return np.column_stack([np.interp(at, arcs, column) for column in body.T])

    low, high = 0.0, _DEEPEST
    for _ in range(50):
        depth = 0.5 * (low + high)
        narrow = np.hypot(*np.diff(find_ends(depth), axis=0)[0]) < MIN_EDGE_WIDTH
        low, high = (depth, high) if narrow else (low, depth)
    at = high + (1.0 - 2.0 * high) * arcs
    first, last = find_ends(high)
    middle, part = 0.5 * (first + last), np.linspace(0.0, 1.0, FACE + 1)[:, None]
    return np.concatenate(
        [
            middle + part[:-1] * (first - middle),
            np.column_stack([np.interp(at, arcs, column) for column in body.T]),
            last + part[1:] * (middle - last),
        ]
    )


def _is_same_shape(one: Airfoil, other: Airfoil) -> bool:
    """Whether two contours are one, but for where their points are."""
    a = np.linspace(0.0, 1.0, BODY + 1)
    points = [np.column_stack([np.interp(a, x.arcs, c) for c in x.points.T]) for x in (one, other)]
    return bool(np.abs(points[1] - points[0]).max() < _SAME_SHAPE)


def _read_airfoil(entry: Entry, name: str) -> Airfoil:
    coordinates = entry["coordinates"]
    points = np.column_stack(_read_columns(coordinates))
    gaps = np.hypot(*np.diff(points, axis=0).T)
    points = np.concatenate([points[:1], points[1:][gaps > 1e-9]])
    if len(points) < 10:
        coordinates.fail(f"need ten points or more that differ, got {len(points)}")
    if abs(points).max() > 10.0 or np.ptp(points[:, 0]) < 0.5:
        coordinates.fail("must be in units of chord, from 0 to 1 along x")
    area = 0.5 * np.sum(points[:, 0] * np.roll(points[:, 1], -1))
    area -= 0.5 * np.sum(points[:, 1] * np.roll(points[:, 0], -1))
    if area < 0.0:  # along the pressure side first
        points, area = points[::-1], -area
    if area <= 1e-6 or points[:, 0].argmin() in (0, len(points) - 1):
        coordinates.fail(
            "must run from the trailing edge along one side to the leading edge and back along the "
            "other"
        )
    middle = 0.5 * (points[0] + points[-1])
    if np.hypot(*(points[0] - points[-1])) > 1e-9:
        points = np.concatenate([[middle], points, [middle]])
    given = entry.get("rthick")
    thickness = given.positive() if given else float(np.ptp(points[:, 1]))
    points = _begin_on_face(points)
    arcs = _find_arcs(points)
    corners = _find_corners(points, arcs)
    return Airfoil(name, thickness, points, arcs, corners)


def _find_arcs(points: Array) -> Array:
    """Fraction of the contour of each point, (n,) [-]."""
    arcs = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    return np.asarray(arcs / arcs[-1])


def _begin_on_face(points: Array) -> Array:
    """The contour from the middle of its flat trailing edge, where it began at a corner of it."""
    arcs, turns = _find_arcs(points), _find_turns(points)
    inner = arcs[1:-1]
    if _find_closing_turn(points) <= _SHARPEST:
        return points
    before = np.flatnonzero((inner > 1.0 - _NEAR) & (turns[1:-1] > _SHARPEST))
    after = np.flatnonzero((inner < _NEAR) & (turns[1:-1] > _SHARPEST))
    if len(before) == 1 and not len(after):  # the last corner; the face runs on to the first point
        points = points[: before[0] + 2]
    elif len(after) == 1 and not len(before):
        points = points[after[0] + 1 :]
    else:
        return points
    middle = 0.5 * (points[0] + points[-1])
    return np.concatenate([[middle], points, [middle]])


def _read_columns(coordinates: Entry) -> tuple[Array, Array]:
    x, y = coordinates["x"].numbers(), coordinates["y"].numbers()
    if len(x) != len(y):
        coordinates.fail(f"have {len(x)} values of x, but {len(y)} of y")
    return x, y


def _find_corners(points: Array, arcs: Array) -> tuple[float, float] | None:
    """Fractions of the corners of the trailing edge, one beside each end of the contour."""
    turns = _find_turns(points)[1:-1]
    inner = arcs[1:-1]
    first = np.where(inner < _NEAR, turns, 0.0)
    last = np.where(inner > 1.0 - _NEAR, turns, 0.0)
    if first.max() > _SHARPEST and last.max() > _SHARPEST:
        return float(inner[first.argmax()]), float(inner[last.argmax()])
    return (0.0, 1.0) if _find_closing_turn(points) > _SHARPEST else None


def _find_turns(points: Array) -> Array:
    """Angles by which a contour turns at its points, 0 at both ends, (n,) [rad]."""
    return np.pad(np.abs(np.diff(_find_directions(points))), 1)


def _find_closing_turn(points: Array) -> float:
    """Angle by which a contour turns where it ends and begins [rad]."""
    directions = _find_directions(points)
    closing = directions[0] + 2.0 * np.pi - directions[-1]
    return abs(float((closing + np.pi) % (2.0 * np.pi) - np.pi))


def _find_directions(points: Array) -> Array:
    """Angles of the sides of a contour without jumps, (n - 1,) [rad]."""
    sides = np.diff(points, axis=0)
    return np.asarray(np.unwrap(np.arctan2(sides[:, 1], sides[:, 0])))

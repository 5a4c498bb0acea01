"""Anchors: places along a contour that layers and webs refer to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.places import (
    FINE,
    HANDLES,
    TOLERANCE,
    WIDEST,
    Contours,
    is_whole,
    list_defined,
    shift_places,
)

MAX_REFERENCES = 20
"""References from anchor to anchor."""

MAX_WIDTH_ERROR = 0.05
"""Maximum mean difference between a width and the distance of given places, relative to the mean
width. Programs round off what they resolve: IEA-15's reinforcements differ by 4 %."""

_AROUND = 201
"""Number of points on one side of a contour between which a plane is looked for."""


class Anchors:
    """A list of anchors, of the shell or of a web.

    Args:
        others: Where anchors are sought that are not in the list.
        shape: The outer surface; None in a web, whose anchors need none.
    """

    def __init__(
        self,
        entry: Entry | None,
        others: Anchors | None = None,
        shape: Contours | None = None,
    ) -> None:
        self._anchors = {e["name"].text(): e for e in entry.entries()} if entry else {}
        self._others, self._shape = others, shape
        self._known: dict[tuple[str, str], Curve] = {}

    def resolve(self, place: Entry) -> Curve:
        """Where something lies along the span.

        Args:
            place: A curve, or a reference to an anchor.
        """
        return self._resolve(place, ())

    def _resolve(self, place: Entry, trail: tuple[str, ...]) -> Curve:
        if "anchor" not in place:
            curve = read_curve(place, -TOLERANCE, 1.0 + TOLERANCE)
            return Curve(curve.grid, np.clip(curve.values, 0.0, 1.0))
        reference = place["anchor"]
        name, handle = reference["name"].text(), reference["handle"].text()
        if handle not in HANDLES and name != "not_defined":
            reference.fail(f"has the handle {handle!r}, allowed are {', '.join(HANDLES)}")
        step = f"{name}.{handle}"
        if step in trail:
            reference.fail(f"refers to itself: {quote(' to '.join((*trail, step)))}")
        if len(trail) >= MAX_REFERENCES:
            reference.fail(
                f"is reached by more than {MAX_REFERENCES} references, one after the other"
            )
        anchors = self._find(name)
        if anchors is None and name == "not_defined":
            reference.fail(
                "names the anchor 'not_defined': windIO's converter found no place for it, give an "
                "anchor of the file, or grid and values"
            )
        if anchors is None:
            reference.fail(f"names the anchor {name!r}, which does not exist")
        if (name, handle) not in anchors._known:
            anchors._known[name, handle] = anchors._follow(name, handle, (*trail, step))
        return anchors._known[name, handle]

    def _follow(self, name: str, handle: str, trail: tuple[str, ...]) -> Curve:
        anchor = self._anchors[name]
        given = self._resolve(anchor[handle], trail) if handle in anchor else None
        if given is not None and not is_whole(given):
            return given
        if self._shape is not None:
            found = self._place_by_offset(anchor, handle, self._shape, trail)
            if found is None and "width" in anchor and handle in list_defined(anchor["width"]):
                found = self._place_by_width(anchor, handle, self._shape, trail)
            if found is None and "plane_intersection" in anchor:
                found = _place_by_plane(anchor["plane_intersection"], handle, self._shape)
            if found is not None:
                return found
        if given is not None:
            return given
        if handle == HANDLES[2] and HANDLES[0] in anchor and HANDLES[1] in anchor:
            start, end = (self._resolve(anchor[h], trail) for h in HANDLES[:2])
            grid = np.union1d(start.grid, end.grid)
            return Curve(grid, 0.5 * (start(grid) + end(grid)))
        anchor.fail(
            f"is not resolved: it has no {handle!r} with grid and values, nor an offset, "
            "a width beside another place, or a plane that defines it"
        )

    def _place_by_width(
        self, anchor: Entry, handle: str, shape: Contours, trail: tuple[str, ...]
    ) -> Curve | None:
        """A start or an end at the width from the other end, or at half of it from the middle."""
        width = read_curve(anchor["width"], 0.0, WIDEST)
        start, end, middle = HANDLES
        other, sign = (start, 1.0) if handle == end else (end, -1.0)
        unit = sign / shape.girth(FINE)
        if other in anchor and other not in list_defined(anchor["width"]):
            given = self._resolve(anchor[other], trail)
            return shift_places(given, width, unit, anchor["width"])
        plane, centre = anchor.get("plane_intersection"), None
        if middle in anchor:
            centre = self._resolve(anchor[middle], trail)
        elif plane is not None:
            centre = _place_by_plane(plane, middle, shape)
        return centre and shift_places(centre, width, 0.5 * unit, anchor["width"])

    def _place_by_offset(
        self, anchor: Entry, handle: str, shape: Contours, trail: tuple[str, ...]
    ) -> Curve | None:
        """A place at an offset from another anchor, a length or a fraction of the contour."""
        for key, most in (("offset_arc", WIDEST), ("offset_nd_arc", 1.0)):
            if key in anchor and anchor[key]["defines"].text() == handle:
                offset = read_curve(anchor[key], -most, most)
                unit = 1.0 / shape.girth(FINE) if key == "offset_arc" else np.ones(len(FINE))
                return shift_places(self._resolve(anchor[key], trail), offset, unit, anchor[key])
        return None

    def list_disagreements(self) -> Iterator[str]:
        """A sentence for each anchor whose width is not the distance of its given start and end."""
        for name, anchor in self._anchors.items():
            ends = HANDLES[:2]
            if self._shape is None or "width" not in anchor or not all(e in anchor for e in ends):
                continue
            width = read_curve(anchor["width"], 0.0, WIDEST)
            s = FINE[(FINE >= width.start) & (FINE <= width.end)]
            start, end = (self._resolve(anchor[handle], (f"{name}.{handle}",)) for handle in ends)
            distance = (end(s) - start(s)) * self._shape.girth(s)
            error = np.abs(distance - width(s))
            used = [self._follow(name, handle, (f"{name}.{handle}",)) for handle in ends]
            same = all(np.array_equal(a(s), b(s)) for a, b in zip(used, (start, end), strict=True))
            which = "start and end, which are used, are" if same else "given start and end are"
            if error.sum() > MAX_WIDTH_ERROR * max(width(s).sum(), distance.sum()):
                k = int(error.argmax())
                yield (
                    f"{anchor.file}: {anchor.place} has a width of {width(s)[k]:.3g} m"
                    f"{'' if same else ', which is used'}, but its {which} {distance[k]:.3g} m "
                    f"apart at station {s[k]:.3g}, where they differ most"
                )

    def _find(self, name: str) -> Anchors | None:
        if name in self._anchors:
            return self
        return self._others._find(name) if self._others else None


def _place_by_plane(plane: Entry, handle: str, shape: Contours) -> Curve | None:
    """Where a plane along the blade meets the contour, windIO's `plane_type1`.

    The plane holds two points of the reference axis. Its normal lies in the plane of y and z, to
    the trailing edge, and the offset shifts it along the normal. A rotation turns the blade before
    about z.

    Returns:
        The start on the suction side, the end on the pressure side, or the middle on the side that
        the plane is for. None where the plane does not define that, or not by two points of the
        axis.
    """
    first = plane.get("plane_type1")
    if first is None or handle not in list_defined(plane):
        return None
    if "anchor_curve" in first and first["anchor_curve"].text() != "reference_axis":
        return None
    side = plane["side"].text() if "side" in plane else "both"
    on_suction = handle == HANDLES[0] if side == "both" else side == "suction"
    angle = np.radians(first["rotation"].number(-360.0, 360.0) if "rotation" in first else 0.0)
    none = Curve(np.array([0.0, 1.0]), np.zeros(2))
    offset = read_curve(plane["offset"], -WIDEST, WIDEST) if "offset" in plane else none
    s = FINE[(FINE >= offset.start) & (FINE <= offset.end)]
    turn = np.array([np.sin(angle), np.cos(angle)])  # y of what was turned about z
    y0, y1 = shape.reference_points(first["anchors_nd_grid"].numbers(2))[:, :2] @ turn
    z0, z1 = shape.reference_points(first["anchors_nd_grid"].numbers(2))[:, 2]
    normal = np.array([z1 - z0, y0 - y1]) / np.hypot(z1 - z0, y1 - y0)
    edge = shape.leading_edge(s)
    part = np.linspace(0.0, 1.0, _AROUND)
    a = edge[:, None] * part if on_suction else 1.0 - (1.0 - edge[:, None]) * part
    points = shape.points(s[:, None], a)  # from the trailing to the leading edge
    y, z = points[..., :2] @ turn - y0, points[..., 2] - z0
    height = y * normal[0] + z * normal[1] - offset(s)[:, None]
    below = height <= 0.0
    k = np.clip(below.argmax(axis=1), 1, _AROUND - 1)
    rows = np.arange(len(s))
    before, after = height[rows, k - 1], height[rows, k]
    crossed = below.any(axis=1) & ~below[:, 0]
    if not crossed.all():
        plane.fail(f"does not meet the contour at station {s[~crossed][0]:g}")
    share = before / (before - after)
    return Curve(s, (1.0 - share) * a[rows, k - 1] + share * a[rows, k])

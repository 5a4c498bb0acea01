"""Planes along a blade that meet its contours, by which windIO's files place webs and caps."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.places import FINE, HANDLES, WIDEST, Contours, list_defined

_AROUND = 201
"""Number of points on one side of a contour between which a plane is looked for."""


def place_by_plane(plane: Entry, handle: str, shape: Contours) -> Curve | None:
    """Where a plane along the blade meets the contour, windIO's `plane_type1`.

    The plane holds two points of the reference axis. Its normal lies in the plane of y and z, to
    the trailing edge, and the offset shifts it along the normal. A rotation turns the blade before
    about z.

    Returns:
        The start on the suction side, the end on the pressure side, or the middle on the side that
        the plane is for; None where it does not define that, or not by two points of the axis.
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

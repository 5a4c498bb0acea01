"""Surfaces of the rigid parts, for pictures only."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.blade import RotorLayout


def tube(rings: Array, closed_ends: bool = True) -> tuple[Array, npt.NDArray[np.int64]]:
    """Surface through closed rings of points.

    Args:
        rings: Points, shape (rings, points per ring, 3) [m].
        closed_ends: Whether to close the two ends by shrinking the end rings to their centres.

    Returns:
        Points, shape (n, 3), and quadrilaterals, shape (m, 4).
    """
    if closed_ends:
        ends = [np.broadcast_to(r.mean(axis=0), r.shape) for r in (rings[0], rings[-1])]
        rings = np.concatenate([ends[:1], rings, ends[1:]])
    n_rings, n = rings.shape[:2]
    k, i = np.meshgrid(np.arange(n_rings - 1), np.arange(n), indexing="ij")
    j = (i + 1) % n
    corners = [k * n + i, k * n + j, (k + 1) * n + j, (k + 1) * n + i]
    return rings.reshape(-1, 3), np.stack(corners, axis=-1).reshape(-1, 4)


def nacelle_surface(body: RigidBody, layout: RotorLayout, size: float, part: int) -> RigidSurface:
    """A box along the shaft with rounded edges, from behind the hub over the tower axis.

    Args:
        size: Radius of the hub [m].
        part: Number of the part.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    radius = 0.85 * size * (np.abs(np.cos(angle)) ** 6 + np.abs(np.sin(angle)) ** 6) ** (-1.0 / 6.0)
    outline = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    over_tower = -layout.centre[2] / layout.axes[2, 2]  # from the hub along the shaft
    front, back = min(0.7 * size, 0.5 * over_tower), 2.3 * over_tower
    stations = ((front, 0.8), (front + 0.2 * size, 1.0), (back - 0.6 * size, 1.0), (back, 0.7))
    centre, shaft = np.asarray(layout.centre), layout.axes[2]
    rings = [centre + s * outline @ layout.axes + z * shaft for z, s in stations]
    return RigidSurface(body, *tube(np.array(rings)), part)


def hub_surface(body: RigidBody, layout: RotorLayout, radius: float, part: int) -> RigidSurface:
    """A spinner around the hub centre: a half sphere behind, a longer nose in front.

    Args:
        radius: Distance of the outermost points of the blade roots from the hub centre [m].
        part: Number of the part.
    """
    polar = np.linspace(0.02, np.pi - 0.02, 25)
    angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    centre, shaft = np.asarray(layout.centre), layout.axes[2]
    length = np.where(polar < 0.5 * np.pi, 0.8 * radius, 1.4 * radius)
    rings = [
        centre + radius * np.sin(p) * circle @ layout.axes + a * np.cos(p) * shaft
        for p, a in zip(polar, length, strict=True)
    ]
    return RigidSurface(body, *tube(np.array(rings)), part)

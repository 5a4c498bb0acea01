"""Surfaces of the rigid parts, for pictures only."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.meshing.blade import BladeGeometry
from turbine_fenicsx.rigid_body import RigidBody
from turbine_fenicsx.rigid_surface import RigidSurface
from turbine_fenicsx.rotations import E2, E3, Array


def tube(rings: Array, closed_ends: bool = True) -> tuple[Array, npt.NDArray[np.int64]]:
    """Surface through closed rings of points.

    Args:
        rings: Points, shape (rings, points a ring, 3) [m].
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


def nacelle_surface(body: RigidBody, hub_distance: float, part: int) -> RigidSurface:
    """A box of 6 m x 4 m x 4 m with rounded edges behind the hub, on the tower axis."""
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    radius = 2.0 * (np.abs(np.cos(angle)) ** 6 + np.abs(np.sin(angle)) ** 6) ** (-1.0 / 6.0)
    outline = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    rings = [s * outline + z * E3 for z, s in ((-3.0, 0.85), (-2.7, 1.0), (2.7, 1.0), (3.0, 0.85))]
    return RigidSurface(body, *tube(np.array(rings)), part)


def hub_surface(body: RigidBody, radius: float, part: int) -> RigidSurface:
    """A spinner: a sphere of the hub's radius around its centre."""
    polar = np.linspace(0.05, np.pi - 0.05, 12)
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    rings = [
        np.asarray(body.position)
        + radius
        * np.column_stack(
            [
                np.sin(p) * np.cos(angle),
                np.sin(p) * np.sin(angle),
                np.full(angle.shape, np.cos(p)),
            ]
        )
        for p in polar
    ]
    return RigidSurface(body, *tube(np.array(rings)), part)


def blade_surface(
    body: RigidBody, blade: BladeGeometry, centre: Array, span: Array, part: int
) -> RigidSurface:
    """Skin of a rigid blade with elliptic sections.

    Args:
        body: The rigid blade.
        blade: Its shape.
        centre: Hub centre [m], shape (3,).
        span: Direction of the span, shape (3,).
        part: Number of the part.
    """
    chord = np.cross(E3, span) if abs(span @ E3) < 0.9 else E2
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    rings = []
    for s in np.linspace(0.0, 1.0, 25):
        across = 0.5 * blade.chord_at(s) * np.cos(angle)
        through = 0.5 * blade.thickness_at(s) * np.sin(angle)
        offset = np.outer(across, chord) + np.outer(through, E3)
        rings.append(centre + (blade.hub_radius + s * blade.length) * span + offset)
    return RigidSurface(body, *tube(np.array(rings)), part)

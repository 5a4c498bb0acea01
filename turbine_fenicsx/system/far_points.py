"""Warn about points of forces far outside their body, often a vector given as a point."""

from __future__ import annotations

from typing import Any

import numpy as np

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.surface_frame import SurfaceFrame
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.parts import Parts

MAX_DISTANCE = 10.0
"""Distance from the centre of a body, over its size, above which a point is far."""

ENDS = (
    ("body", "point"),
    ("flexible", "point"),
    ("first", "first_point"),
    ("second", "second_point"),
)
"""Attributes of forces: a body, and a point of it."""


def find_far_points(parts: Parts) -> list[str]:
    """A warning for each point of a force that lies far outside its body. Collective."""
    found, bodies = [], (*parts.rigid_bodies, *parts.flexible_bodies)
    for force in (*parts.motion_forces, *parts.prescribed_forces, *parts.on_bodies):
        for name, place in ENDS:
            body: Any = getattr(force, name, None)
            point = getattr(force, place, None)
            if point is None or body not in bodies:
                continue
            centre, size = _measure(body, parts)
            distance = np.linalg.norm(np.asarray(point, dtype=float) - centre)
            if distance > MAX_DISTANCE * size:
                found.append(
                    f"{getattr(force, 'name', type(force).__name__)!r} acts on a point "
                    f"{distance:.3g} m from the centre of {body.name!r}, whose size is some "
                    f"{size:.2g} m: is it a point of the body?"
                )
    return found


def _measure(body: RigidBody | DeformableBody, parts: Parts) -> tuple[Array, float]:
    """Centre of a body, shape (3,), and its radius: of its mesh, or of gyration and joints [m]."""
    if isinstance(body, SurfaceFrame):
        return _measure(body.couplings[0].flexible, parts)
    if not isinstance(body, RigidBody):
        low, high = body.find_bounds()
        return 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    centre = np.asarray(body.position)
    points = [np.asarray(j.point) for j in parts.joints if body in j.bodies and hasattr(j, "point")]
    arms = [float(np.linalg.norm(point - centre)) for point in points]
    return centre, max([float(np.sqrt(np.sum(np.asarray(body.euler)) / body.mass)), *arms])

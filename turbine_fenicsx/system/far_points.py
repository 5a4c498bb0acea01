"""Points of forces that lie far outside of their bodies, as vectors that were mistaken do."""

from __future__ import annotations

from typing import Any

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.parts import Parts

FAR = 10.0
"""A point further from the centre of mass than so many sizes of a rigid body is far."""

OUTSIDE = 0.1
"""A point further out of the box around a mesh than this part of its diagonal is far."""


def tell_far_points(parts: Parts) -> list[str]:
    """Warnings of points that lie far outside of their bodies. Collective.

    The size of a rigid body is its largest radius of gyration, or the distance of the furthest
    point of a joint or of a flexible body that is attached to it.

    Args:
        parts: The parts of a system.
    """
    sizes = _measure_bodies(parts)
    told = []
    for name, body, point in _list_points(parts):
        if body not in sizes:
            continue  # the force itself says that it is not among the parts
        distance = np.linalg.norm(np.asarray(point, dtype=float) - np.asarray(body.position))
        if distance > FAR * sizes[body]:
            told.append(
                f"{name!r} acts on a point {distance:.3g} m from the centre of {body.name!r}, "
                f"whose size is some {sizes[body]:.2g} m: is it a point of the body?"
            )
    for force in parts.on_bodies:
        if isinstance(force, NodeForce):
            low, high = _box(force.flexible.mesh)
            point = np.asarray(force.point, dtype=float)
            distance = np.linalg.norm(point - np.clip(point, low, high))
            if distance > OUTSIDE * np.linalg.norm(high - low):
                told.append(
                    f"{force.name!r} acts on a point {distance:.3g} m outside of "
                    f"{force.flexible.name!r}, and so on the node nearest to it: is it a point of "
                    "the body?"
                )
    return told


def _list_points(parts: Parts) -> list[tuple[str, RigidBody, npt.ArrayLike]]:
    """Name, body and point of all forces on points of rigid bodies."""
    found: list[tuple[str, RigidBody, npt.ArrayLike]] = []
    for force in (*parts.motion_forces, *parts.prescribed_forces):
        given: Any = force
        for body, point in (
            ("body", "point"),
            ("first", "first_point"),
            ("second", "second_point"),
        ):
            at, where = getattr(given, body, None), getattr(given, point, None)
            if isinstance(at, RigidBody) and where is not None:
                found.append((getattr(given, "name", type(given).__name__), at, where))
    return found


def _measure_bodies(parts: Parts) -> dict[RigidBody, float]:
    """Size of each rigid body [m]."""
    sizes = {}
    for body in parts.rigid_bodies:
        points = [j.point for j in parts.joints if body in j.bodies and hasattr(j, "point")]
        arms = [np.linalg.norm(np.asarray(p, dtype=float) - body.position) for p in points]
        gyration = np.sqrt(np.sum(np.asarray(body.euler)) / body.mass)
        sizes[body] = max([float(gyration), *map(float, arms)])
    for coupling in parts.couplings:
        if coupling.rigid is not None:
            low, high = _box(coupling.flexible.mesh)
            centre = np.asarray(coupling.rigid.position)
            furthest = np.maximum(np.abs(low - centre), np.abs(high - centre))
            arm = float(np.linalg.norm(furthest))
            sizes[coupling.rigid] = max(sizes[coupling.rigid], arm)
    return sizes


def _box(mesh: Any) -> tuple[Array, Array]:
    """Corners of the box around a mesh, shape (3,) each [m]. Collective."""
    x = np.asarray(mesh.geometry.x)
    low = np.min(x, axis=0, initial=np.inf)
    high = np.max(x, axis=0, initial=-np.inf)
    mesh.comm.Allreduce(MPI.IN_PLACE, low, MPI.MIN)
    mesh.comm.Allreduce(MPI.IN_PLACE, high, MPI.MAX)
    return low, high

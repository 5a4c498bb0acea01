"""Interfaces of the forces that depend on time, and of those on flexible bodies.

A force that depends on time alone is a `PrescribedForce`; one on a flexible body is a
`SurfaceForce` or a `NodeForce`; one on rigid bodies or joint coordinates that depends on their
motion is a `turbine_fenicsx.forces.force.Force`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.foundation.types import Array


@dataclass
class ForceSum:
    """Generalised forces at one time, the sum of all prescribed forces.

    Args:
        coordinates: Forces on the coordinates of each rigid body, each of shape (12,) [N, N m].
        torques: Torque or force on each joint coordinate by name [N m, N].
        acceleration: Acceleration of gravity that acts on all masses, shape (3,) [m/s^2].
    """

    coordinates: Mapping[RigidBody, Array]
    torques: dict[str, float]
    acceleration: Array = field(default_factory=lambda: np.zeros(3))


@runtime_checkable
class PrescribedForce(Protocol):
    """Something that drives the system, whatever its motion.

    The step evaluates them at t_{n+1/2}; the work of forces and torques over a step is exactly
    force times increment of the coordinate. Gravity counts as potential energy instead. A force
    may have a ``name``, under which its work is reported.
    """

    def add_to(self, forces: ForceSum, time: float) -> None:
        """Add this force at the given time [s]; raises ModelError for an unknown joint or body."""


@runtime_checkable
class SurfaceForce(Protocol):
    """A force on a part of the surface of a flexible body."""

    @property
    def name(self) -> str:
        """Name under which its work is reported."""

    @property
    def flexible(self) -> FlexibleBody:
        """The body."""

    @property
    def facets(self) -> npt.NDArray[np.int32]:
        """Facets of the surface, indices local to this rank (ghosts allowed)."""

    @property
    def function(self) -> Callable[[float], float]:
        """Factor as a function of time [s]."""

    def traction(self, at: SurfacePoint) -> Any:
        """Force per reference area [N/m^2] at a point of the surface, as a UFL vector."""

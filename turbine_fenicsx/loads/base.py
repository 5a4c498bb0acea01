"""What every load is to the rest of the code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from turbine_fenicsx.rigid_body import RigidBody
from turbine_fenicsx.rotations import Array


@dataclass
class Forces:
    """Generalised forces at one time, collected from all loads.

    Args:
        coordinates: Forces on the coordinates of each rigid body, each of shape (12,) [N, N m].
        torques: Torque on each joint angle by the name of the joint [N m].
        acceleration: Acceleration of gravity that acts on all masses, shape (3,) [m/s^2].
    """

    coordinates: Mapping[RigidBody, Array]
    torques: dict[str, float]
    acceleration: Array = field(default_factory=lambda: np.zeros(3))


@runtime_checkable
class Load(Protocol):
    """Something that drives the system.

    The step evaluates loads at t_{n+1/2}; the work of forces and torques over a step is exactly
    force times increment of the coordinate. Gravity counts as potential energy instead.
    """

    def add_to(self, forces: Forces, time: float) -> None:
        """Add this load at the given time [s]; raises ValueError for an unknown joint."""

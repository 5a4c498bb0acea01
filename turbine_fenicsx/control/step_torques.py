"""Torques that a controller sets between two steps and that are constant over the step.

The work of such a torque is exactly torque times increment, and a step that is tried again with
half its length sees the same torque.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.force import BoundForce, Kind, Layout, StepTimes
from turbine_fenicsx.forces.prescribed_force import ForceSum
from turbine_fenicsx.foundation.argument_checks import check_not_negative, check_positive
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array


@dataclass(eq=False)
class HeldTorque:
    """A torque on the sum of joint coordinates, each with a factor.

    Args:
        name: Name under which its work is reported.
        factors: df/dTheta of the angle f on which it acts, by the names of the joint coordinates.
        torque: The torque on f that is held in the next step [N m].
        last: That of the step that has ended [N m].
    """

    name: str
    factors: Mapping[str, float]
    torque: float = 0.0
    last: float = 0.0

    def hold(self, torque: float) -> None:
        """Set the torque of the next step [N m]."""
        self.last, self.torque = self.torque, torque

    def add_to(self, forces: ForceSum, time: float) -> None:
        """Add the torque."""
        for coordinate, factor in self.factors.items():
            if coordinate not in forces.torques:
                known = sorted(forces.torques)
                raise ModelError(f"no joint coordinate {coordinate!r}; there are {known}")
            forces.torques[coordinate] += factor * self.torque


@dataclass(eq=False)
class HeldBrake:
    """Friction on the sum f of joint coordinates, with a strength that is set between steps.

    The torque on f is -strength f' / sqrt(f'^2 + speed^2) with the mean rate f' of the step:
    Coulomb's friction, rounded where it changes its sign. A brake that holds a torque M lets it
    creep at speed (M/strength)/sqrt(1 - (M/strength)^2). A step dissipates exactly torque times
    increment.

    Args:
        name: Unique name.
        coordinates: Names of the joint coordinates.
        speed: Below this speed friction is weaker [rad/s].
        strength: Torque of the brake, zero as long as it is open [N m].

    Raises:
        ModelError: for a speed that is not positive, or a negative strength.
    """

    name: str
    coordinates: Sequence[str]
    speed: float = 5e-3
    strength: float = 0.0
    kind: Kind = "dissipative"

    def __post_init__(self) -> None:
        check_positive(f"speed of {self.name!r}", self.speed)
        check_not_negative(f"strength of {self.name!r}", self.strength)

    def bind(self, layout: Layout) -> BoundForce:
        """The brake with its coordinates numbered."""
        index = np.array([layout.coordinate(name) for name in self.coordinates])
        return _Friction(index, self)


@dataclass(frozen=True)
class _Friction:
    """The friction of a brake on numbered coordinates."""

    index: npt.NDArray[np.int64]
    brake: HeldBrake

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """Friction -T w/sqrt(w^2 + w_0^2) on each coordinate, and its derivative by y1."""
        T, w_0, n = self.brake.strength, self.brake.speed, len(self.index)
        w = float(np.sum(y1 - y0)) / step.dt
        root = np.hypot(w, w_0)
        slope = T * w_0 * w_0 / root**3 / step.dt
        return np.full(n, -T * w / root), np.full((n, n), -slope)

    def energy(self, y: Array) -> float:
        """It stores none."""
        return 0.0

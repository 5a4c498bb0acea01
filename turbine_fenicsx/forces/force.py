"""Interface of the forces that depend on the motion of rigid bodies and joints.

A force acts on a few coordinates y of the system (of rigid bodies, or joint coordinates)
with a generalised force that depends on them: springs, dampers, follower forces, torques.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import name_errors
from turbine_fenicsx.foundation.quadratic import AffineVector, QuadraticMap
from turbine_fenicsx.foundation.types import Array

Kind = Literal["conservative", "dissipative", "external"]
"""Where the work of a force goes: its own energy, dissipation, or external work."""


@dataclass(frozen=True)
class StepTimes:
    """Length, middle and end of a step.

    Args:
        dt: Length of the step [s]; infinite for a system at rest.
        middle: t_{n+1/2} [s].
        end: t_{n+1} [s].
    """

    dt: float
    middle: float
    end: float

    @property
    def half_dt2(self) -> float:
        """dt^2/2 [s^2], the factor of all forces in a step."""
        return 0.5 * self.dt * self.dt

    @classmethod
    def from_start(cls, start: float, dt: float) -> StepTimes:
        """The step of the length dt [s] from a time on [s]."""
        return cls(dt, start + 0.5 * dt, start + dt)

    @classmethod
    def at_rest(cls, time: float) -> StepTimes:
        """A step in which nothing has a velocity, at one time [s]."""
        return cls(np.inf, time, time)


class BoundForce(Protocol):
    """A force of a system whose coordinates are numbered."""

    @property
    def index(self) -> npt.NDArray[np.int64]:
        """Numbers of its coordinates y in (q, Theta), shape (m,)."""

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """Generalised force of the step from y0 to y1, whose work is force . (y1 - y0).

        Returns:
            The force, shape (m,), and its derivative with respect to y1, shape (m, m).
        """

    def energy(self, y: Array) -> float:
        """Potential energy [J]; zero unless the force is conservative."""


def evaluate_force(force: BoundForce, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
    """The generalised force of a step and its derivative, see `BoundForce.force`."""
    with name_errors(f"force() of {describe(force)}"):
        F, K = force.force(y0, y1, step)
    m = y0.size
    if np.shape(F) != (m,) or np.shape(K) != (m, m):
        raise ModelError(
            f"force() of {describe(force)} must return a force of shape {(m,)} and its derivative "
            f"of shape {(m, m)}, got {np.shape(F)} and {np.shape(K)}"
        )
    return F, K


@dataclass(frozen=True)
class Layout:
    """Numbers of the coordinates of a system.

    Args:
        coordinates: Number of each joint coordinate in (q, Theta) by name.
    """

    bodies: Mapping[RigidBody, int]
    coordinates: Mapping[str, int]

    def coordinate(self, name: str) -> int:
        """Number of a joint coordinate."""
        if name not in self.coordinates:
            known = sorted(self.coordinates)
            raise ModelError(f"no joint coordinate {name!r}; there are {known}")
        return self.coordinates[name]

    def frames(
        self, *bodies: RigidBody | None
    ) -> tuple[tuple[BodyFrame, ...], npt.NDArray[np.int64]]:
        """Frames of some bodies in local coordinates, and the numbers of these.

        Args:
            bodies: Rigid bodies; None is the ground.

        Returns:
            A frame for each, and the coordinates that the frames count from zero, shape (m,).
        """
        frames, index = [], [np.zeros(0, np.int64)]
        for body in bodies:
            if body is None:
                frames.append(BodyFrame(None))
                continue
            if body not in self.bodies:
                raise ModelError(f"rigid body {body.name!r} is not among the parts")
            frames.append(BodyFrame(body, 4 * (len(index) - 1)))
            index.append(self.bodies[body] + np.arange(12))
        return tuple(frames), np.concatenate(index)


@runtime_checkable
class Force(Protocol):
    """A force that depends on the motion of rigid bodies or joint coordinates."""

    @property
    def name(self) -> str:
        """Name under which its work is reported."""

    @property
    def kind(self) -> Kind:
        """Where its work goes."""

    def bind(self, layout: Layout) -> BoundForce:
        """The force with numbered coordinates; raises ModelError for unknown partners."""


Law = Callable[[float, float, float], tuple[float, float]]
"""(f0, f1, dt) -> generalised force on f and its derivative with respect to f1."""


class DistanceForce:
    """A force on the square f = |v|^2 of the distance v of two points.

    Its force is h grad f at the midpoint, whose work is exactly h (f_1 - f_0). f is the square of
    v. A polynomial of the coordinates would lose a short distance far from the origin in round-off.

    Args:
        gap: v in the coordinates counted from zero.
        index: Their numbers in the system, shape (m,).
        energy: Potential energy as a function of f; zero if None.
    """

    def __init__(
        self,
        gap: AffineVector,
        index: npt.NDArray[np.int64],
        law: Law,
        energy: Callable[[float], float] | None = None,
    ) -> None:
        self.index, self._law, self._energy = index, law, energy
        components = QuadraticMap(gap.components(), index.size)
        self._c, self._A = components.constant, components.jacobian(np.zeros(index.size))

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """The force h grad f at the midpoint, and its derivative."""
        A, v0, v1 = self._A, self._gap(y0), self._gap(y1)
        h, h_f1 = self._law(float(v0 @ v0), float(v1 @ v1), step.dt)
        G = (v0 + v1) @ A
        return h * G, h * (A.T @ A) + 2.0 * h_f1 * np.outer(G, v1 @ A)

    def energy(self, y: Array) -> float:
        """Potential energy [J]."""
        v = self._gap(y)
        return 0.0 if self._energy is None else self._energy(float(v @ v))

    def _gap(self, y: Array) -> Array:
        """The distance v [m], shape (3,)."""
        v: Array = self._A @ y + self._c
        return v


@dataclass(frozen=True)
class LinearForce:
    """The force -stiffness (y_m - rest) - damping (y_1 - y_0)/dt on one coordinate.

    Args:
        index: Number of the coordinate, shape (1,).
        stiffness: k [N m/rad or N/m].
        rest: Where the spring is at rest [rad or m].
        damping: d [N m s/rad or N s/m].
    """

    index: npt.NDArray[np.int64]
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """The force of the step."""
        k, d = self.stiffness, self.damping / step.dt
        return -k * (0.5 * (y0 + y1) - self.rest) - d * (y1 - y0), np.array([[-0.5 * k - d]])

    def energy(self, y: Array) -> float:
        """Energy of the spring [J]."""
        return 0.5 * self.stiffness * float(y[0] - self.rest) ** 2

"""Torque on a rigid body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.body_checks import check_body
from turbine_fenicsx.forces.force import BoundForce, Kind, Layout, StepTimes
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_vectors
from turbine_fenicsx.foundation.rotations import skew
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class Torque:
    """A torque M with an axis fixed in space, or fixed to the body.

    The forces on the directors are M x d^i / 2, with the basis d^i reciprocal to the mean
    directors d_i of the step (which are not orthonormal). Their moment sum d_i x (M x d^i)/2 is M
    exactly, so that a free body gains the angular momentum M dt per step.

    Args:
        name: Name under which its work is reported.
        body: The rigid body.
        torque: Torque in the initial configuration [N m], shape (3,).
        function: Factor as a function of time [s].
        follower: Whether the torque turns with the body.

    Raises:
        ModelError: if the torque is not three numbers.
        TypeError: if the body is not rigid, or the function is not one of time.
    """

    name: str
    body: RigidBody
    torque: npt.ArrayLike
    function: Callable[[float], float] = ALWAYS
    follower: bool = False
    kind: Kind = "external"

    def __post_init__(self) -> None:
        check_body(self.name, self.body)
        check_vectors(self.name, torque=self.torque)
        check_function(self.name, self.function)

    def bind(self, layout: Layout) -> BoundForce:
        """The torque with its coordinates numbered."""
        _, index = layout.frames(self.body)
        M = np.asarray(self.torque, dtype=float)
        if self.follower:
            M = M @ np.asarray(self.body.directors, dtype=float)
        return _DirectorForces(index[3:], M, self.function, self.follower)


@dataclass(frozen=True)
class _DirectorForces:
    """The forces M x d^i / 2 on the directors; M in space or in the body frame."""

    index: npt.NDArray[np.int64]
    M: Array
    function: Callable[[float], float]
    follower: bool

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """Force and derivative."""
        D = (0.5 * (y0 + y1)).reshape(3, 3)  # rows d_i
        inverse = np.linalg.inv(D)  # columns d^i
        M = self.function(step.middle) * self.M
        m = M @ D if self.follower else M
        W = 0.5 * skew(m)
        f = W @ inverse
        # d(d^i) = -sum_k (d^i . dd_k) d^k, and dM = sum_k M_k dd_k for a follower
        K = -np.einsum("ak,bi->iakb", f, inverse)
        if self.follower:
            turned = np.array([-0.5 * skew(inverse[:, i]) for i in range(3)])
            K += np.einsum("iab,k->iakb", turned, M)
        return f.T.ravel(), 0.5 * K.reshape(9, 9)

    def energy(self, y: Array) -> float:
        return 0.0

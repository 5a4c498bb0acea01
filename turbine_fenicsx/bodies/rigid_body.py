"""Rigid bodies in the rotationless director formulation, eqs (1)-(8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.inertia import principal_inertia
from turbine_fenicsx.foundation.argument_checks import check_array, check_positive, check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.quadratic import AffineVector, Quadratic, dot
from turbine_fenicsx.foundation.types import Array

GROUND: Array = np.concatenate([np.zeros(3), np.eye(3).ravel()])
"""Coordinates of the ground, as if it were one more body, shape (12,)."""


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body with coordinates q = (phi, d1, d2, d3), eq. (1).

    phi is the centre of mass and d_i are the principal axes, so that the mass matrix is constant
    and diagonal: diag(m, E1, E2, E3), each times the 3x3 identity, eqs (5)-(7).

    Args:
        name: Unique name.
        mass: m [kg], positive.
        euler: Principal values E_i of the Euler tensor [kg m^2], shape (3,), not negative. The
            tensor of inertia is J = tr(E) I - E; `from_inertia` takes that.
        position: Initial centre of mass [m], shape (3,).
        directors: Initial directors as columns, a rotation matrix of shape (3, 3).
        velocity: Initial velocity of the centre of mass [m/s], shape (3,).
        angular_velocity: Initial angular velocity in space [rad/s], shape (3,).

    Raises:
        ModelError: if the mass is not positive, an Euler value is negative, the directors are not a
            rotation, or a vector is not three numbers.
    """

    name: str
    mass: float
    euler: Sequence[float]
    _: KW_ONLY
    position: npt.ArrayLike = (0.0, 0.0, 0.0)
    directors: npt.ArrayLike = field(default_factory=lambda: np.eye(3))
    velocity: npt.ArrayLike = (0.0, 0.0, 0.0)
    angular_velocity: npt.ArrayLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        check_positive(f"mass of rigid body {self.name!r}", self.mass)
        words = "three numbers >= 0, at most one of them zero"
        what = f"Euler values of rigid body {self.name!r}"
        euler = check_array(what, self.euler, (3,), words)
        if np.any(euler < 0.0) or np.count_nonzero(euler) < 2:
            raise ModelError(f"{what} must be {words}, got {self.euler!r}")
        check_vectors(
            self.name,
            position=self.position,
            velocity=self.velocity,
            angular_velocity=self.angular_velocity,
        )
        _check_rotation("directors", self.name, self.directors)

    @classmethod
    def from_inertia(
        cls,
        name: str,
        mass: float,
        inertia: npt.ArrayLike,
        *,
        position: npt.ArrayLike = (0.0, 0.0, 0.0),
        axes: npt.ArrayLike | None = None,
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
    ) -> RigidBody:
        """A rigid body by its tensor of inertia J; the directors become the principal axes.

        Args:
            name: Unique name.
            mass: m [kg], positive.
            inertia: J about the centre of mass [kg m^2]: moments about the axes, shape (3,), or the
                tensor with respect to the axes, shape (3, 3), symmetric.
            position: Initial centre of mass [m], shape (3,).
            axes: Axes of J as columns, a rotation matrix of shape (3, 3); the inertial ones if
                None.
            velocity: Initial velocity of the centre of mass [m/s], shape (3,).
            angular_velocity: Initial angular velocity in space [rad/s], shape (3,).

        Raises:
            ModelError: if the inertia tensor is not that of a body, the axes are not a rotation,
                and as above.
        """
        euler, principal = principal_inertia(name, inertia)
        R = np.eye(3) if axes is None else _check_rotation("axes", name, axes)
        return cls(
            name,
            mass,
            euler.tolist(),
            position=position,
            directors=R @ principal,
            velocity=velocity,
            angular_velocity=angular_velocity,
        )

    @property
    def coordinates(self) -> Array:
        """Initial coordinates (phi, d1, d2, d3), shape (12,) [m, -]."""
        R = np.asarray(self.directors, dtype=float)
        return np.concatenate([np.asarray(self.position, dtype=float), R.T.ravel()])

    @property
    def rates(self) -> Array:
        """Initial rates of the coordinates, shape (12,) [m/s, 1/s]."""
        w = np.asarray(self.angular_velocity, dtype=float)
        R_dot = np.cross(w, np.asarray(self.directors, dtype=float).T)
        return np.concatenate([np.asarray(self.velocity, dtype=float), R_dot.ravel()])

    @property
    def masses(self) -> Array:
        """Diagonal of the mass matrix, shape (12,) [kg, kg m^2], eq. (7)."""
        return np.repeat([self.mass, *self.euler], 3)

    def weights_of(self, positions: Array, is_point: Array) -> Array:
        """Weights (h, xi_1, xi_2, xi_3) of phi and the directors for nodes that move with the body.

        Args:
            positions: Initial values X of the nodes, shape (n, 3).
            is_point: h of each, 1 for a point x = phi + sum xi_i d_i, 0 for a vector sum xi_i d_i.

        Returns:
            Shape (n, 4).
        """
        h = is_point[:, None]
        arms = positions - h * np.asarray(self.position, dtype=float)
        return np.hstack([h, arms @ np.asarray(self.directors, dtype=float)])

    def body_coordinates(self, point: npt.ArrayLike) -> Array:
        """Constant coordinates xi_i of a point in the body frame, x = phi + sum xi_i d_i.

        Args:
            point: Position(s) in the initial configuration [m], shape (..., 3).

        Returns:
            xi, shape (..., 3) [m].
        """
        R = np.asarray(self.directors, dtype=float)
        arm = np.asarray(point, dtype=float) - np.asarray(self.position, dtype=float)
        xi: Array = arm @ R
        return xi


def _check_rotation(what: str, name: str, matrix: npt.ArrayLike) -> Array:
    """The matrix, or a ModelError if it is no rotation."""
    what = f"{what} of rigid body {name!r}"
    R = check_array(what, matrix, (3, 3), "a rotation matrix, shape (3, 3)")
    if not np.allclose(R.T @ R, np.eye(3), rtol=0.0, atol=1e-12) or np.linalg.det(R) < 0.0:
        raise ModelError(f"{what} must be a rotation matrix, got {matrix!r}")
    return R


@dataclass(frozen=True)
class BodyFrame:
    """Points and directions of one body (or of the ground) as functions of the coordinates.

    Joints see bodies only through this: ``point`` and ``direction`` take vectors of the initial
    configuration and return what they become when the body moves.

    Args:
        body: The rigid body, or None for the ground.
        first_slot: Slot of its centre of mass among the coordinate 3-vectors.
    """

    body: RigidBody | None
    first_slot: int = -1

    def point(self, position: npt.ArrayLike) -> AffineVector:
        """Material point that is at ``position`` initially [m]."""
        if self.body is None:
            return AffineVector.fixed(position)
        xi = self.body.body_coordinates(position)
        return AffineVector.slot(self.first_slot) + self._combine(xi)

    def direction(self, vector: npt.ArrayLike) -> AffineVector:
        """Body-fixed vector that is ``vector`` initially."""
        if self.body is None:
            return AffineVector.fixed(vector)
        return self._combine(
            np.asarray(vector, dtype=float) @ np.asarray(self.body.directors, dtype=float)
        )

    def internal_constraints(self) -> list[Quadratic]:
        """The six conditions of orthonormal directors d_i . d_j = delta_ij, eq. (9)."""
        d = [AffineVector.slot(self.first_slot + i) for i in (1, 2, 3)]
        squares = [(dot(d[i], d[i]) - 1.0) * 0.5 for i in range(3)]
        return [*squares, dot(d[0], d[1]), dot(d[0], d[2]), dot(d[1], d[2])]

    def _combine(self, xi: Array) -> AffineVector:
        """The vector sum xi_i d_i; entries that are zero to round-off are dropped."""
        vector = AffineVector.fixed(np.zeros(3))
        for i, a in enumerate(xi):
            if abs(a) > 1e-15 * max(1.0, float(np.max(np.abs(xi)))):
                vector = vector + float(a) * AffineVector.slot(self.first_slot + 1 + i)
        return vector

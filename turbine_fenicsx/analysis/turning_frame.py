"""The frame that turns with one side of a joint at a constant speed.

Everything on the second side of the joint turns about its axis, which has the direction n and the
point a, both fixed in the first partner. Nodes and centres of mass x, and directors d, then have
the velocities

    S (x - a),   S d,        S = Omega [n]_x,

and S^2 (x - a) are their accelerations. Every block of the mass matrix M of the coordinates
y = (u | q | Theta) is a number times the unit matrix 1_3, so that M and S commute.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.argument_checks import check_number
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.quadratic import QuadraticMap
from turbine_fenicsx.foundation.rotations import rotation_about, skew
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.coordinates import Angle
from turbine_fenicsx.joints.rheonomic import function_of
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

ROUND_OFF = 1e-9
"""Relative size below which a motion of the second partner does not count."""


@dataclass(frozen=True, eq=False)
class TurningFrame:
    """Which bodies turn about which axis; made by `turning_frame`.

    Args:
        system: The system.
        joint: Name of the joint.
        coordinate: Number of its angle among the joint coordinates.
        speed: Omega [rad/s].
        point: A point a of the axis, shape (3,) [m].
        axis: Its direction n, a unit vector of shape (3,), about which the angle counts.
        rigid_turns: Whether each rigid body turns, shape (bodies,).
        flexible_turns: Whether each flexible body turns.
    """

    system: MultibodySystem
    joint: str
    coordinate: int
    speed: float
    point: Array
    axis: Array
    rigid_turns: Array
    flexible_turns: tuple[bool, ...]

    @property
    def spin(self) -> Array:
        """S as a matrix of shape (3, 3) [rad/s]."""
        return self.speed * skew(self.axis)

    def body_arms(self, body: int, u: PETSc.Vec) -> Array:
        """Positions x - h a of the owned nodes of a flexible body, shape (n_owned, 3) [m].

        Args:
            body: Its number.
            u: Its displacement.
        """
        model = self.system.flexible_models[body]
        x = model.positions + u.array_r.reshape(-1, 3)
        return np.asarray(x - model.is_point[:, None] * self.point)

    def rigid_arms(self, q: Array) -> Array:
        """Centres of mass x - a, and directors, of all rigid bodies, shape (bodies, 4, 3)."""
        arms = q.reshape(-1, 4, 3).copy()
        arms[:, 0] -= self.point
        return arms

    def body_matrix(self, body: int, power: int) -> PETSc.Mat:
        """New matrix M S^power of a flexible body, zero if it does not turn. Collective."""
        tensor = self._power(self.flexible_turns[body], power)
        return self.system.flexible_models[body].mass_matrix(tensor)

    def rigid_matrix(self, power: int) -> Array:
        """M S^power of (q | Theta), shape (n_q + n_T, n_q + n_T)."""
        model = self.system.rigid_model
        matrix = np.zeros((model.n_q + model.n_T,) * 2)
        for k, turns in enumerate(self.rigid_turns):
            part = slice(12 * k, 12 * k + 12)
            masses = np.diag(model.masses[part][::3])
            matrix[part, part] = np.kron(masses, self._power(turns, power))
        return matrix

    def body_centrifugal_force(self, body: int, u: PETSc.Vec, out: PETSc.Vec) -> None:
        """M S^2 (x - a) of a flexible body [N], inertia that balances forces, into out.

        Args:
            body: Its number.
            u: Its displacement.
            out: Vector of nodal values, overwritten.
        """
        out.set(0.0)
        if self.flexible_turns[body]:
            field = out.duplicate()
            field.array[:] = (self.body_arms(body, u) @ (self.spin @ self.spin).T).ravel()
            self.system.flexible_models[body].momentum(field, out)
            field.destroy()

    def rigid_centrifugal_force(self, q: Array) -> Array:
        """M S^2 (x - a) of the rigid bodies, shape (n_q,) [N]."""
        accelerations = self.rigid_arms(q) @ (self.spin @ self.spin).T
        return self.system.rigid_model.masses * self.of_turning(accelerations)

    def set_velocities(self, state: State) -> None:
        """Set the velocities of a state to those of the steady rotation, zero on the other side."""
        S_T = self.spin.T
        state.q_dot = self.of_turning(self.rigid_arms(state.q) @ S_T)
        state.joint_rates = np.zeros_like(state.joint_rates)
        state.joint_rates[self.coordinate] = self.speed
        for body, (turns, u, v) in enumerate(
            zip(self.flexible_turns, state.u, state.v, strict=True)
        ):
            v.array[:] = (self.body_arms(body, u) @ S_T).ravel() if turns else 0.0

    def momentum_rates(self, p: Array, L: Array) -> tuple[Array, Array]:
        """Changes of the momenta of something that turns, shape (..., 3) [N, N m].

        With the moment L - a x p about the axis they are

            p' = S p,    L' = S (L - a x p) + a x S p.

        Args:
            p: Linear momenta, shape (..., 3) [kg m/s].
            L: Angular momenta about the origin, shape (..., 3) [kg m^2/s].
        """
        force = p @ self.spin.T
        moment = (L - np.cross(self.point, p)) @ self.spin.T + np.cross(self.point, force)
        return force, moment

    def turn(self, state: State, angle: float) -> None:
        """Turn the second side of a state by an angle [rad], as if rigid, with joint forces.

        Velocities stay as they are. Multipliers become those whose forces are nearest to the
        turned ones.
        """
        R_T, rigid = rotation_about(self.axis, angle).T, self.system.rigid_model
        D = rigid.constraint_jacobian(state.q, state.joint_coordinates)
        forces = np.split(state.multipliers @ D, [rigid.n_q])
        forces[0] = self._turned(forces[0], forces[0].reshape(-1, 4, 3) @ R_T)
        positions = self.rigid_arms(state.q) @ R_T
        positions[:, 0] += self.point
        state.q = self._turned(state.q, positions)
        state.joint_coordinates = state.joint_coordinates.copy()
        state.joint_coordinates[self.coordinate] += angle
        D = rigid.constraint_jacobian(state.q, state.joint_coordinates)
        state.multipliers = np.linalg.lstsq(D.T, np.concatenate(forces), rcond=None)[0]
        for body, turns in enumerate(self.flexible_turns):
            if turns:
                u, model = state.u[body], self.system.flexible_models[body]
                x = model.is_point[:, None] * self.point + self.body_arms(body, u) @ R_T
                u.array[:] = (x - model.positions).ravel()
                held = state.coupling[body]
                held.array[:] = (held.array_r.reshape(-1, 3) @ R_T).ravel()

    def _power(self, turns: bool, power: int) -> Array:
        """S^power of a body, shape (3, 3)."""
        S = self.spin if turns else np.zeros((3, 3))
        return np.asarray(np.linalg.matrix_power(S, power))

    def of_turning(self, values: Array) -> Array:
        """Values of bodies that turn, zero for the others, shape (12 bodies,).

        Args:
            values: For all rigid bodies, shape (bodies, 4, 3).
        """
        return self._turned(np.zeros(values.size), values)

    @property
    def is_driven(self) -> bool:
        """Whether the angle follows a prescribed motion."""
        name = self.system.joint_coordinate_names[self.coordinate]
        return any(name in relation.factors for relation in self.system.relations)

    def _turned(self, before: Array, after: Array) -> Array:
        """Values of shape (12 bodies,) that are the latter for bodies that turn."""
        turns = self.rigid_turns[:, None, None]
        return np.where(turns, after, before.reshape(-1, 4, 3)).ravel()


def turning_frame(
    system: MultibodySystem, joint: str, speed: float, state: State | None = None
) -> TurningFrame:
    """The frame that turns with the second side of a joint.

    Args:
        system: The system.
        joint: Name of a joint whose coordinates have one angle, such as a revolute joint.
        speed: Omega, the rate of that angle [rad/s].
        state: Where the axis is; the initial state if None.

    Raises:
        ModelError: if the joint is unknown, does not turn about one axis, has the ground as second
            partner or sides that are tied together, or if the speed is not a number.
    """
    speed = check_number(f"speed of {joint!r}", speed)
    found = next((j for j in system.joints if j.name == joint), None)
    if found is None:
        raise ModelError(f"no joint {joint!r}; there are {sorted(j.name for j in system.joints)}")
    if found.bodies[1] is None:
        raise ModelError(
            f"joint {joint!r} cannot turn its second partner, the ground; exchange the partners"
        )
    side = _second_side(system, found)
    q = np.concatenate([np.zeros(0), *(b.coordinates for b in system.rigid_bodies)])
    name, point, axis = _axis(system, found, q if state is None else state.q)
    coordinate = system.joint_coordinate_names.index(name)
    _check_relations(system, joint, name)
    return TurningFrame(
        system,
        joint,
        coordinate,
        speed,
        point,
        axis,
        np.array([id(b) in side for b in system.rigid_bodies], dtype=bool),
        tuple(id(b) in side for b in system.flexible_bodies),
    )


def _second_side(system: MultibodySystem, joint: Joint) -> set[int]:
    """Identities of all bodies that other joints and couplings hold to the second partner."""
    pairs: list[tuple[Any, Any]] = [j.bodies for j in system.joints if j is not joint]
    pairs += [(c.flexible, c.rigid) for c in system.couplings]
    side = _connected(joint.bodies[1], pairs)
    if id(joint.bodies[0]) in side or id(None) in side:
        raise ModelError(
            f"joint {joint.name!r} alone does not let anything turn: other joints or couplings tie "
            "its second side to its first or to the ground"
        )
    return side


def _connected(
    start: RigidBody | DeformableBody | None, pairs: Iterable[tuple[Any, Any]]
) -> set[int]:
    """Identities of what pairs of bodies connect with one of them; None is the ground."""
    neighbours: dict[int, list[Any]] = {}
    for a, b in pairs:
        neighbours.setdefault(id(a), []).append(b)
        neighbours.setdefault(id(b), []).append(a)
    found, ahead = {id(start)}, [start]
    while ahead:
        for body in neighbours.get(id(ahead.pop()), []):
            if id(body) not in found:
                found.add(id(body))
                ahead.append(body)
    return found


def _axis(system: MultibodySystem, joint: Joint, q: Array) -> tuple[str, Array, Array]:
    """Name of the joint's angle, and point and direction of its axis in a configuration.

    They follow from the only motion of the second partner, a velocity v + w x x, that changes this
    angle at 1 rad/s, no other coordinate of the joint, and breaks none of its constraints.
    """
    first, second = joint.bodies
    bodies = [b for b in (first, second) if b is not None]
    frames = {id(b): BodyFrame(b, 4 * k) for k, b in enumerate(bodies)} | {
        id(None): BodyFrame(None)
    }
    a, b = frames[id(first)], frames[id(second)]
    coordinates = joint.coordinates(a, b)
    angles = [name for name, c in coordinates.items() if isinstance(c, Angle)]
    refusal = ModelError(
        f"joint {joint.name!r} has no angle about one axis, as a revolute joint has"
    )
    if len(angles) != 1:
        raise refusal
    q = np.concatenate([system.coordinates_of(q)[body] for body in bodies])
    constraints = [function_of(c) for c in joint.constraints(a, b)]
    rows = [QuadraticMap(constraints, q.size).jacobian(q)]
    for c in coordinates.values():
        functions = QuadraticMap(list(c), q.size)
        J, values = functions.jacobian(q), functions.value(q)
        # d/dt of the angle by its cosine c and sine s: c s' - s c'
        rate = values[0] * J[1] - values[1] * J[0] if isinstance(c, Angle) else J[0]
        rows.append(rate[None])
    rigid_motion = np.zeros((12, 6))
    for k, x in enumerate(q[-12:].reshape(4, 3)):
        rigid_motion[3 * k : 3 * k + 3, 3:] = -skew(x)
    rigid_motion[:3, :3] = np.eye(3)
    A = np.concatenate(rows)[:, -12:] @ rigid_motion
    wanted = np.zeros(len(A))
    wanted[len(A) - len(coordinates) + list(coordinates).index(angles[0])] = 1.0
    motion, _, rank, _ = np.linalg.lstsq(A, wanted, rcond=ROUND_OFF)
    v, w = motion[:3], motion[3:]
    size = np.linalg.norm(w)
    if rank < 6 or np.max(np.abs(A @ motion - wanted)) > ROUND_OFF or not size > ROUND_OFF:
        raise refusal
    joint_point = np.cross(w, v) / size**2
    return angles[0], joint_point, w / size


def _check_relations(system: MultibodySystem, joint: str, name: str) -> None:
    """Raise a ModelError if a gear or the like makes other coordinates turn with the angle."""
    for relation in system.relations:
        if name in relation.factors and len(relation.factors) > 1:
            raise ModelError(
                f"{relation.name!r} ties the angle of joint {joint!r} to other joint coordinates, "
                "which would move as well"
            )

"""A system of rigid and flexible bodies, joints, couplings and loads."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.coupling import Coupling, CouplingBlock
from turbine_fenicsx.discrete_gradients import AlgorithmicStress
from turbine_fenicsx.flexible_block import FlexibleBlock
from turbine_fenicsx.flexible_body import FlexibleBody
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.loads.base import Forces, Load
from turbine_fenicsx.rigid_block import RigidBlock
from turbine_fenicsx.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.rotations import Array
from turbine_fenicsx.state import State


@dataclass(frozen=True)
class Balance:
    """Energies and momenta of a state.

    Args:
        kinetic: Kinetic energy [J].
        strain: Strain energy [J].
        potential: Potential energy of gravity, zero at the origin [J].
        linear: Linear momentum, shape (3,) [kg m/s].
        angular: Angular momentum about the origin, shape (3,) [N m s].
    """

    kinetic: float
    strain: float
    potential: float
    linear: Array
    angular: Array

    @property
    def total(self) -> float:
        """Total energy H [J]."""
        return self.kinetic + self.strain + self.potential


class MultibodySystem:
    """Collects and numbers the parts of a model; unchangeable once made.

    Args:
        comm: Communicator of the meshes.
        parts: Rigid and flexible bodies, joints, couplings and loads, in any order. Bodies must
            be among the parts themselves.
        angle_form: Form of the augmented joint angles, "regular" or "paper".
        stress: Algorithmic stress of all flexible bodies; their exact discrete gradients if None.

    Raises:
        TypeError: for a part of unknown kind, or a joint or coupling of the wrong kind of body.
        ValueError: for a duplicate name, a joint or coupling whose body is not among the parts, a
            load on an unknown joint, or an unknown angle form.

    Note:
        Collective over ``comm``.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        parts: Iterable[Any],
        angle_form: str = "regular",
        stress: AlgorithmicStress | None = None,
    ) -> None:
        """Sort the parts and compile the blocks."""
        self.comm = comm
        if angle_form not in FORMS:
            raise ValueError(f"angle_form must be one of {sorted(FORMS)}, got {angle_form!r}")
        groups: dict[type, list[Any]] = {
            kind: [] for kind in (RigidBody, FlexibleBody, Coupling, Joint, Load)
        }
        for part in parts:
            kind = next((k for k in groups if isinstance(part, k)), None)
            if kind is None:
                raise TypeError(f"{part!r} is no body, joint, coupling or load")
            groups[kind].append(part)
        self.rigid_bodies: tuple[RigidBody, ...] = tuple(groups[RigidBody])
        self.flexible_bodies: tuple[FlexibleBody, ...] = tuple(groups[FlexibleBody])
        self.couplings: tuple[Coupling, ...] = tuple(groups[Coupling])
        self.joints: tuple[Joint, ...] = tuple(groups[Joint])
        self.loads: tuple[Load, ...] = tuple(groups[Load])
        self._check_names_and_partners()

        self.first_coordinate = {b: 12 * k for k, b in enumerate(self.rigid_bodies)}
        frames = {b: BodyFrame(b, 4 * k) for k, b in enumerate(self.rigid_bodies)}
        frames_of = [
            [BodyFrame(None) if b is None else frames[b] for b in j.bodies] for j in self.joints
        ]
        constraints = [c for f in frames.values() for c in f.internal_constraints()]
        angles = {}
        for joint, (a, b) in zip(self.joints, frames_of, strict=True):
            constraints += joint.constraints(a, b)
            angle = joint.angle(a, b)
            if angle is not None:
                angles[joint.name] = angle
        self.angle_names = tuple(angles)
        masses = [b.masses for b in self.rigid_bodies]
        self.rigid_block = RigidBlock(
            np.concatenate([np.zeros(0), *masses]),
            constraints,
            [c for c, _ in angles.values()],
            [s for _, s in angles.values()],
            FORMS[angle_form],
        )
        self.flexible_blocks = tuple(FlexibleBlock(b, stress) for b in self.flexible_bodies)
        self.coupling_blocks = tuple(
            CouplingBlock(
                block,
                [c for c in self.couplings if c.flexible is block.body],
                self.first_coordinate,
                self.rigid_block.size,
            )
            for block in self.flexible_blocks
        )
        self.forces(0.0)  # loads on unknown joints are found here, not in the first step
        self._momenta = tuple(block.new_vector() for block in self.flexible_blocks)

    def initial_state(self) -> State:
        """State at t = 0: bodies as given, flexible bodies moving with their carrier.

        A flexible body that is coupled to rigid bodies starts with the rigid velocity field of
        the first of them; one without starts at rest.
        """
        block = self.rigid_block
        q = np.concatenate([np.zeros(0), *(b.coordinates for b in self.rigid_bodies)])
        q_dot = np.concatenate([np.zeros(0), *(b.rates for b in self.rigid_bodies)])
        u = tuple(b.new_vector() for b in self.flexible_blocks)
        v = tuple(b.new_vector() for b in self.flexible_blocks)
        for flexible, coupling, velocity in zip(
            self.flexible_blocks, self.coupling_blocks, v, strict=True
        ):
            if coupling.carriers:
                carrier = coupling.carriers[0]
                xi = carrier.body_coordinates(flexible.positions)
                rates = carrier.rates.reshape(4, 3)
                velocity.array[:] = (rates[0] + xi @ rates[1:]).ravel()
        return State(
            time=0.0,
            q=q,
            q_dot=q_dot,
            angles=np.zeros(block.n_angles),
            angle_rates=np.zeros(block.n_angles),
            multipliers=np.zeros(block.n_constraints + block.n_angles),
            u=u,
            v=v,
            coupling=tuple(c.C.createVecLeft() for c in self.coupling_blocks),
        )

    def forces(self, time: float) -> Forces:
        """All loads at one time [s]."""
        forces = Forces(
            coordinates={b: np.zeros(12) for b in self.rigid_bodies},
            torques=dict.fromkeys(self.angle_names, 0.0),
        )
        for load in self.loads:
            load.add_to(forces, time)
        return forces

    def gravity_force(self, acceleration: Array) -> Array:
        """Weight of the rigid bodies as generalised force on q, shape (12 bodies,) [N]."""
        force = np.zeros((len(self.rigid_bodies), 4, 3))
        for k, body in enumerate(self.rigid_bodies):
            force[k, 0] = body.mass * acceleration
        return force.ravel()

    def coordinates_of(self, q: Array) -> dict[RigidBody, Array]:
        """Coordinates of each rigid body, views of shape (12,)."""
        return {b: q[k : k + 12] for b, k in self.first_coordinate.items()}

    def balance(self, state: State) -> Balance:
        """Energies and momenta. Collective."""
        g = self.forces(state.time).acceleration
        partial = np.zeros(9)
        for block, u, v, p in zip(
            self.flexible_blocks, state.u, state.v, self._momenta, strict=True
        ):
            block.momentum(v, p)
            x = block.positions + u.array_r.reshape(-1, 3)
            momentum = p.array_r.reshape(-1, 3)
            partial[0] += 0.5 * np.dot(v.array_r, p.array_r)
            partial[1] += block.strain_energy(u)
            partial[2] -= block.nodal_mass @ (x @ g)
            partial[3:6] += momentum.sum(axis=0)
            partial[6:9] += np.cross(x, momentum).sum(axis=0)
        total = self.comm.allreduce(partial) if self.flexible_blocks else partial
        q, v_rigid = state.q.reshape(-1, 3), state.q_dot.reshape(-1, 3)
        momentum = (self.rigid_block.masses * state.q_dot).reshape(-1, 3)
        return Balance(
            kinetic=float(total[0] + 0.5 * np.sum(momentum * v_rigid)),
            strain=float(total[1]),
            potential=float(total[2] - self.gravity_force(g) @ state.q),
            linear=total[3:6] + momentum[::4].sum(axis=0),
            angular=total[6:9] + np.cross(q, momentum).sum(axis=0),
        )

    def constraint_error(self, state: State) -> float:
        """Largest violation of any constraint [m, -]. Collective."""
        rigid = self.rigid_block.constraint_values(state.q, state.angles)
        coordinates = self.coordinates_of(state.q)
        gaps = (c.gap(coordinates, u) for c, u in zip(self.coupling_blocks, state.u, strict=True))
        worst = max((float(np.max(np.abs(x), initial=0.0)) for x in (rigid, *gaps)), default=0.0)
        return float(self.comm.allreduce(worst, op=MPI.MAX))

    def _check_names_and_partners(self) -> None:
        """Raise a ValueError for duplicate names and missing partners."""
        parts: list[Any] = [*self.rigid_bodies, *self.flexible_bodies, *self.joints]
        names = [part.name for part in (*parts, *self.couplings)]
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice:
            raise ValueError(f"names must be unique, but {twice} occur more than once")
        for joint in self.joints:
            for body in joint.bodies:
                _require(joint.name, body, RigidBody, "a rigid body or the ground")
        for coupling in self.couplings:
            _require(coupling.name, coupling.rigid, RigidBody, "a rigid body or the ground")
            if not isinstance(coupling.flexible, FlexibleBody):
                _require(coupling.name, coupling.flexible, FlexibleBody, "a flexible body")
        known = {id(b) for b in (*self.rigid_bodies, *self.flexible_bodies)} | {id(None)}
        pairs: list[tuple[str, tuple[Any, ...]]] = [(j.name, j.bodies) for j in self.joints]
        pairs += [(c.name, (c.flexible, c.rigid)) for c in self.couplings]
        for name, partners in pairs:
            for partner in partners:
                if id(partner) not in known:
                    body = getattr(partner, "name", partner)
                    raise ValueError(
                        f"{name!r} refers to body {body!r}, which is not among the parts"
                    )


def _require(name: str, body: Any, kind: type, words: str) -> None:
    """Raise a TypeError unless a partner is None or of the right kind."""
    if body is not None and not isinstance(body, kind):
        partner = getattr(body, "name", body)
        raise TypeError(f"{name!r} needs {words}, but {partner!r} is none")

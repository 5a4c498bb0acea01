"""A system of rigid and flexible bodies, joints, couplings, force elements and loads."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.forces.element import Element, Layout
from turbine_fenicsx.forces.load import Forces, Load, SurfaceLoad
from turbine_fenicsx.forces.node_force import NodeForce
from turbine_fenicsx.foundation.quadratic import Quadratic, QuadraticMap
from turbine_fenicsx.foundation.redundancy import redundant_rows
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.augmented_angle import FORMS
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.coordinates import JointCoordinate
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.discrete_gradients import AlgorithmicStress
from turbine_fenicsx.system.flexible_block import FlexibleBlock
from turbine_fenicsx.system.initial_velocity import initial_velocity
from turbine_fenicsx.system.rigid_block import RigidBlock
from turbine_fenicsx.system.state import State

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Balance:
    """Energies and momenta of a state.

    Args:
        kinetic: Kinetic energy [J].
        strain: Strain energy [J].
        potential: Potential energy of gravity, zero at the origin [J].
        spring: Energy of springs on rigid bodies and joint coordinates [J].
        linear: Linear momentum, shape (3,) [kg m/s].
        angular: Angular momentum about the origin, shape (3,) [N m s].
    """

    kinetic: float
    strain: float
    potential: float
    spring: float
    linear: Array
    angular: Array

    @property
    def total(self) -> float:
        """Total energy H [J]."""
        return self.kinetic + self.strain + self.potential + self.spring


class MultibodySystem:
    """Collects and numbers the parts of a model; unchangeable once made.

    Args:
        comm: Communicator of the meshes.
        parts: Rigid and flexible bodies, joints, prescribed motions, couplings, force elements and
            loads, in any order. Bodies must be among the parts themselves.
        angle_form: Form of the augmented joint angles, "regular" or "paper".
        stress: Algorithmic stress of all flexible bodies; their exact discrete gradients if None.
        numerical_dissipation: chi >= 0 of the energy-decaying variant, see `FlexibleBlock`; 0
            conserves energy.

    Attributes:
        angle_names: Names of the joint coordinates.
        work_names: Names of what does external work, in the order of `StepReport.works`.
        dissipation_names: Names of what dissipates, in the order of `StepReport.dissipated`.
        gravity: Acceleration of gravity, shape (3,) [m/s^2].
        redundant: Number of redundant constraints of each joint that has some, by its name.
        joint_rows: Rows of `RigidBlock.forces_between` that belong to each joint, by its name.

    Raises:
        TypeError: for a part of unknown kind, or a joint or coupling of the wrong kind of body.
        ValueError: for a duplicate name, a joint, coupling or load whose body is not among the
            parts, an unknown joint coordinate, two motions or a dependent motion of one, or an
            unknown angle form.

    Note:
        Collective over ``comm``.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        parts: Iterable[Any],
        angle_form: str = "regular",
        stress: AlgorithmicStress | None = None,
        numerical_dissipation: float = 0.0,
    ) -> None:
        """Sort the parts and compile the blocks."""
        self.comm = comm
        if angle_form not in FORMS:
            raise ValueError(f"angle_form must be one of {sorted(FORMS)}, got {angle_form!r}")
        groups = _sorted(parts)
        self.rigid_bodies: tuple[RigidBody, ...] = tuple(groups[RigidBody])
        self.flexible_bodies: tuple[FlexibleBody, ...] = tuple(groups[FlexibleBody])
        self.couplings: tuple[Coupling, ...] = tuple(groups[Coupling])
        self.joints: tuple[Joint, ...] = tuple(groups[Joint])
        self.motions: tuple[PrescribedMotion, ...] = tuple(groups[PrescribedMotion])
        self.elements: tuple[Element, ...] = tuple(groups[Element])
        self.loads: tuple[Load, ...] = tuple(groups[Load])
        self._on_bodies: tuple[SurfaceLoad | NodeForce, ...] = (
            *groups[SurfaceLoad],
            *groups[NodeForce],
        )
        self._check_names_and_partners()

        self.first_coordinate = {b: 12 * k for k, b in enumerate(self.rigid_bodies)}
        self.rigid_block = self._make_rigid_block(angle_form)
        self.flexible_blocks = tuple(
            FlexibleBlock(
                b, stress, [x for x in self._on_bodies if x.flexible is b], numerical_dissipation
            )
            for b in self.flexible_bodies
        )
        self.coupling_blocks = tuple(
            CouplingBlock(
                block,
                [c for c in self.couplings if c.flexible is block.body],
                self.first_coordinate,
                self.rigid_block.size,
            )
            for block in self.flexible_blocks
        )
        # loads on unknown joints and bodies are found here, not in the first step
        self.gravity = self.forces(0.0).acceleration
        self._momenta = tuple(block.new_vector() for block in self.flexible_blocks)
        external = [e.name for e in self.elements if e.kind == "external"]
        on_bodies = [load.name for b in self.flexible_blocks for load in b.loads]
        motions = [m.name for m in self.motions]
        loads = [getattr(load, "name", type(load).__name__) for load in self.loads]
        self.work_names = _distinct([*loads, *external, *on_bodies, *motions])
        self.dissipation_names = (
            *(e.name for e in self.elements if e.kind == "dissipative"),
            *(f"{name} of {b.body.name}" for b in self.flexible_blocks for name in b.dissipations),
        )

    def _make_rigid_block(self, angle_form: str) -> RigidBlock:
        """Number joint coordinates, find redundant constraints, bind force elements."""
        frames = {b: BodyFrame(b, 4 * k) for k, b in enumerate(self.rigid_bodies)}
        constraints = [c for f in frames.values() for c in f.internal_constraints()]
        n_internal, owners = len(constraints), []
        coordinates: dict[str, JointCoordinate] = {}
        of_coordinates: dict[str, str] = {}
        for joint in self.joints:
            a, b = (BodyFrame(None) if body is None else frames[body] for body in joint.bodies)
            mine = joint.constraints(a, b)
            constraints += mine
            owners += [joint.name] * len(mine)
            for name, coordinate in joint.coordinates(a, b).items():
                if name in coordinates:
                    raise ValueError(f"two joint coordinates are called {name!r}")
                coordinates[name], of_coordinates[name] = coordinate, joint.name
        self.angle_names = tuple(coordinates)
        n_q = 12 * len(self.rigid_bodies)
        layout = Layout(
            self.first_coordinate, {name: n_q + k for k, name in enumerate(coordinates)}
        )
        prescribed = [layout.coordinate(m.coordinate) - n_q for m in self.motions]
        redundant = self._redundant(constraints, n_internal)
        kept = [c for k, c in enumerate(constraints) if k not in redundant]
        moved = [list(coordinates.values())[k][-1] for k in prescribed]  # sine or displacement
        for k in self._redundant([*kept, *moved], len(kept)) - len(kept):
            raise ValueError(
                f"the prescribed motion of {self.motions[k].coordinate!r} depends on the joints "
                "and the other prescribed motions"
            )
        of_rows = [*("" for _ in range(n_internal)), *owners]
        of_rows = [name for k, name in enumerate(of_rows) if k not in redundant]
        of_rows += 2 * [of_coordinates[name] for name in coordinates]
        self.joint_rows = {
            j.name: np.flatnonzero([name == j.name for name in of_rows]) for j in self.joints
        }
        self.redundant: dict[str, int] = {}
        for k in redundant:
            name = owners[k - n_internal]
            self.redundant[name] = self.redundant.get(name, 0) + 1
        if self.redundant and self.comm.rank == 0:
            log.warning(
                "%d of %d joint constraints are redundant (in joints %s): they hold without a "
                "multiplier, and the forces in these joints are one choice of many",
                len(redundant),
                len(owners),
                ", ".join(self.redundant),
            )
        masses = [b.masses for b in self.rigid_bodies]
        self._check_velocities(constraints[n_internal:], owners)
        return RigidBlock(
            np.concatenate([np.zeros(0), *masses]),
            constraints,
            list(coordinates.values()),
            FORMS[angle_form],
            prescribed,
            [e.bind(layout) for e in self.elements],
            redundant,
        )

    def _check_velocities(self, constraints: list[Quadratic], owners: list[str]) -> None:
        """Warn of initial velocities that joints do not allow; they would make others alternate."""
        q = np.concatenate([np.zeros(0), *(b.coordinates for b in self.rigid_bodies)])
        q_dot = np.concatenate([np.zeros(0), *(b.rates for b in self.rigid_bodies)])
        G = QuadraticMap(constraints, q.size).jacobian(q)
        terms = np.abs(G) @ np.abs(q_dot)
        wrong = np.abs(G @ q_dot) > 1e-9 * np.max(terms, initial=0.0)
        names = dict.fromkeys(owners[k] for k in np.flatnonzero(wrong))
        if names and self.comm.rank == 0:
            log.warning(
                "the initial velocities of the bodies do not agree with joints %s; velocities "
                "will alternate from step to step",
                ", ".join(map(repr, names)),
            )

    def _redundant(self, constraints: list[Quadratic], n_internal: int) -> Any:
        """Numbers of the constraints that depend on the others in the initial configuration."""
        q = np.concatenate([np.zeros(0), *(b.coordinates for b in self.rigid_bodies)])
        return redundant_rows(QuadraticMap(constraints, q.size).jacobian(q), n_internal)

    def initial_state(self) -> State:
        """State at t = 0: bodies as given, flexible bodies moving with their carrier.

        A flexible body starts with its own velocity field if it has one; else, coupled to rigid
        bodies, with the rigid velocity field of the first of them, and at rest without.
        """
        block = self.rigid_block
        q = np.concatenate([np.zeros(0), *(b.coordinates for b in self.rigid_bodies)])
        q_dot = np.concatenate([np.zeros(0), *(b.rates for b in self.rigid_bodies)])
        u = tuple(b.new_vector() for b in self.flexible_blocks)
        v = tuple(b.new_vector() for b in self.flexible_blocks)
        for flexible, coupling, velocity in zip(
            self.flexible_blocks, self.coupling_blocks, v, strict=True
        ):
            velocity.array[:] = initial_velocity(flexible, coupling, q_dot).ravel()
        return State(
            time=0.0,
            q=q,
            q_dot=q_dot,
            angles=np.zeros(block.n_angles),
            angle_rates=np.zeros(block.n_angles),
            multipliers=np.zeros(block.n_constraints + block.n_angles + block.n_prescribed),
            u=u,
            v=v,
            coupling=tuple(c.C.createVecLeft() for c in self.coupling_blocks),
        )

    def forces(self, time: float) -> Forces:
        """All loads at one time [s], but those on flexible bodies and force elements."""
        q = np.zeros(12 * len(self.rigid_bodies))
        forces = Forces(self.coordinates_of(q), dict.fromkeys(self.angle_names, 0.0))
        for load in self.loads:
            load.add_to(forces, time)
        return forces

    def forces_by_load(self, time: float) -> tuple[Array, Array]:
        """Each of the loads at one time [s], without gravity.

        Returns:
            Forces on the coordinates of rigid bodies and on the joint coordinates, shapes
            (loads, 12 bodies) and (loads, joint coordinates).
        """
        n = len(self.loads)
        q, T = np.zeros((n, 12 * len(self.rigid_bodies))), np.zeros((n, len(self.angle_names)))
        for k, load in enumerate(self.loads):
            forces = Forces(self.coordinates_of(q[k]), dict.fromkeys(self.angle_names, 0.0))
            load.add_to(forces, time)
            T[k] = list(forces.torques.values())
        return q, T

    def gravity_force(self, acceleration: Array) -> Array:
        """Weight of the rigid bodies as generalised force on q, shape (12 bodies,) [N]."""
        force = self.rigid_block.masses.reshape(-1, 4, 3) * acceleration
        force[:, 1:] = 0.0
        return force.ravel()

    def coordinates_of(self, q: Array) -> dict[RigidBody, Array]:
        """Coordinates of each rigid body, views of shape (12,)."""
        return {b: q[k : k + 12] for b, k in self.first_coordinate.items()}

    def balance(self, state: State) -> Balance:
        """Energies and momenta. Collective."""
        g = self.gravity
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
            partial[6:9] += _moment(x, momentum)
        total = self.comm.allreduce(partial) if self.flexible_blocks else partial
        p = self.rigid_block.masses * state.q_dot
        q, momentum = state.q.reshape(-1, 3), p.reshape(-1, 3)
        return Balance(
            kinetic=float(total[0] + 0.5 * np.dot(state.q_dot, p)),
            strain=float(total[1]),
            potential=float(total[2] - self.gravity_force(g) @ state.q),
            spring=self.rigid_block.element_energy(state.q, state.angles),
            linear=total[3:6] + momentum[::4].sum(axis=0),
            angular=total[6:9] + _moment(q, momentum),
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
        bodies: list[Any] = [*self.rigid_bodies, *self.flexible_bodies]
        _check_unique([*bodies, *self.joints, *self.couplings])
        _check_unique([*self.elements, *self._on_bodies, *self.motions])
        for joint in self.joints:
            for body in joint.bodies:
                _require(joint.name, body, RigidBody, "a rigid body or the ground")
            if joint.bodies[0] is joint.bodies[1]:
                where = getattr(joint.bodies[0], "name", "the ground")
                raise ValueError(f"both partners of {joint.name!r} are {where!r}")
        for coupling in self.couplings:
            _require(coupling.name, coupling.rigid, RigidBody, "a rigid body or the ground")
        attached: list[Any] = [*self.couplings, *self._on_bodies]
        for part in attached:
            _require(part.name, part.flexible, FlexibleBody, "a flexible body", or_none=False)
        known = {id(b) for b in bodies} | {id(None)}
        pairs: list[tuple[str, tuple[Any, ...]]] = [(j.name, j.bodies) for j in self.joints]
        pairs += [(c.name, (c.flexible, c.rigid)) for c in self.couplings]
        pairs += [(x.name, (x.flexible,)) for x in self._on_bodies]
        for name, partners in pairs:
            for partner in partners:
                if id(partner) not in known:
                    body = getattr(partner, "name", partner)
                    raise ValueError(
                        f"{name!r} refers to body {body!r}, which is not among the parts"
                    )


def _moment(x: Array, p: Array) -> Array:
    """Sum of the vector products of two lists of vectors, shape (n, 3) each."""
    A = x.T @ p
    return np.array([A[1, 2] - A[2, 1], A[2, 0] - A[0, 2], A[0, 1] - A[1, 0]])


def _sorted(parts: Iterable[Any]) -> dict[type, list[Any]]:
    """Parts by kind."""
    kinds = (RigidBody, FlexibleBody, Coupling, PrescribedMotion, NodeForce)
    protocols = (Joint, Element, SurfaceLoad, Load)
    groups: dict[type, list[Any]] = {kind: [] for kind in (*kinds, *protocols)}
    for part in parts:
        kind = next((k for k in groups if isinstance(part, k)), None)
        if kind is None:
            raise TypeError(f"{part!r} is no body, joint, coupling, force element or load")
        groups[kind].append(part)
    return groups


def _check_unique(parts: Iterable[Any]) -> None:
    """Raise a ValueError for names that occur more than once."""
    names = [part.name for part in parts]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ValueError(f"names must be unique, but {twice} occur more than once")


def _distinct(names: list[str]) -> tuple[str, ...]:
    """The names, numbered where they occur again."""
    found: list[str] = []
    for name in names:
        number, other = 1, name
        while other in found:
            number += 1
            other = f"{name} {number}"
        found.append(other)
    return tuple(found)


def _require(name: str, body: Any, kind: type, words: str, or_none: bool = True) -> None:
    """Raise a TypeError unless a partner is of the right kind, or None where that is allowed."""
    if not isinstance(body, kind) and not (or_none and body is None):
        partner = getattr(body, "name", body)
        raise TypeError(f"{name!r} needs {words}, but {partner!r} is none")

"""A system of rigid and flexible bodies, joints, couplings and forces."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakSet

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.line_source import LineSource
from turbine_fenicsx.forces.prescribed_force import ForceSum, check_force_sum, has_energy
from turbine_fenicsx.forces.rigid_section_loads import BoundRigidLoads
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelWarning
from turbine_fenicsx.foundation.own_code import evaluate_function, name_errors, on_rank0_if_own
from turbine_fenicsx.foundation.parallel import largest_of_ranks, raise_together, sum_over_ranks
from turbine_fenicsx.foundation.repr_text import list_names
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.law_check import check_material
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.initial_fields import initial_displacement, initial_velocity
from turbine_fenicsx.system.make_model import make_model
from turbine_fenicsx.system.numbering import number_parts
from turbine_fenicsx.system.parts import number_names, sort_parts
from turbine_fenicsx.system.state import State

log = logging.getLogger(__name__)


_CHECKED: WeakSet[DeformableBody] = WeakSet()
"""Bodies whose law was checked already."""


@dataclass(frozen=True)
class Balance:
    """Energies and momenta of a state.

    Args:
        kinetic: Kinetic energy [J].
        strain: Strain energy [J].
        potential: Potential energy of gravity, zero at the origin [J].
        spring: Energy of springs on rigid bodies and joint coordinates, and of forces on surfaces
            that have one, such as contact [J].
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
    """Collects and numbers the parts of a model; unchangeable once made, without a time step.

    Args:
        comm: Communicator of the meshes.
        parts: Rigid and flexible bodies, joints, relations of joint coordinates, couplings and
            forces, in any order. Bodies must be among the parts themselves.

    Attributes:
        paths: What constraints of joints follow in time.
        rigid_model: Rigid bodies, joints and forces as functions of a configuration.
        flexible_models: The flexible bodies, each with mass, forces and stiffness.
        coupling_blocks: The couplings of each flexible body as matrices C and B.
        joint_coordinate_names: Names of the joint coordinates.
        work_names: Names of what does external work, in the order of `StepReport.works`.
        gravity: Acceleration of gravity, shape (3,) [m/s^2].
        redundant: Number of redundant constraints of each joint that has some, by its name.
        constraint_owners: Name of what each of `RigidModel.constraint_values` belongs to.
        joint_rows: Rows of `RigidModel.constraint_forces` that belong to each joint, by its name.
        rigid_section_loads: Loads on sections of rigid bodies.

    Raises:
        TypeError: for a part of unknown kind, or a joint or coupling of the wrong kind of body.
        ModelError: for a law that `check_material` refuses, a duplicate name, a joint, coupling or
            force whose body is not among the parts, an unknown joint coordinate, or relations that
            depend on each other.

    Note:
        Collective over ``comm``.
    """

    def __init__(self, comm: MPI.Intracomm, parts: Iterable[Any]) -> None:
        self.comm = comm
        found = sort_parts(parts)
        self.rigid_bodies, self.flexible_bodies = found.rigid_bodies, found.flexible_bodies
        self.couplings, self.joints = found.couplings, found.joints
        self.relations = found.relations
        self.motion_forces = found.motion_forces
        self.prescribed_forces = found.prescribed_forces
        self.first_coordinate = {b: 12 * k for k, b in enumerate(self.rigid_bodies)}
        numbering = number_parts(comm, found)
        self.rigid_model, self.joint_coordinate_names = (
            numbering.model,
            numbering.joint_coordinate_names,
        )
        self.paths = numbering.paths
        self.joint_rows, self.redundant = numbering.joint_rows, numbering.redundant
        self.constraint_owners = numbering.constraint_owners
        if comm.rank == 0:
            for sentence in numbering.warnings:
                log.warning(sentence)
        for body in self.flexible_bodies:
            _check_law(body)
        self.flexible_models = tuple(
            make_model(
                b,
                [x for x in found.on_bodies if x.flexible is b],
                next((x for x in found.dampings if x.flexible is b), None),
                [c for c in self.couplings if c.flexible is b],
            )
            for b in self.flexible_bodies
        )
        self.coupling_blocks = tuple(
            CouplingBlock(
                model,
                [c for c in self.couplings if c.flexible is model.body],
                self.first_coordinate,
                self.rigid_model.size,
            )
            for model in self.flexible_models
        )
        self.rigid_section_loads = tuple(
            force for force in self.rigid_model.forces if isinstance(force, BoundRigidLoads)
        )
        # forces on unknown joints and bodies are found here, not in the first step
        self.gravity = self._find_gravity()
        coordinates = {b: b.coordinates for b in self.rigid_bodies}
        for model, block in zip(self.flexible_models, self.coupling_blocks, strict=True):
            initial_displacement(model, block, coordinates)  # open couplings are found here, too
        prescribed = [getattr(f, "name", type(f).__name__) for f in self.prescribed_forces]
        external = [e.name for e in self.motion_forces if e.kind == "external"]
        forces: list[Any] = [f for m in self.flexible_models for f in m.forces]
        on_bodies = [f.name for f in forces if not has_energy(f)]
        driven = [r.name for r in self.relations if r.motion is not None]
        self.work_names = number_names(
            [*prescribed, *external, *on_bodies, *driven, *self.paths.names]
        )

    def __repr__(self) -> str:
        """Its parts in a few lines."""
        sizes = [block.C.getSize() for block in self.coupling_blocks]
        unknowns = self.rigid_model.size + sum(map(sum, sizes))
        of_forces = [getattr(x, "name", type(x).__name__) for x in self.prescribed_forces]
        of_forces += [x.name for x in self.motion_forces]
        of_forces += [x.name for model in self.flexible_models for x in model.forces]
        parts: dict[str, Sequence[str]] = {
            "rigid bodies": [x.name for x in self.rigid_bodies],
            "flexible bodies": [x.name for x in self.flexible_bodies],
            "couplings": [x.name for x in self.couplings],
            "joints": [x.name for x in self.joints],
            "joint coordinates": self.joint_coordinate_names,
            "relations": [x.name for x in self.relations],
            "forces": of_forces,
            "loads on sections": list(self.section_loads),
        }
        lines = [f"  {what:17} {list_names(x)}" for what, x in parts.items() if x]
        return "\n".join([f"MultibodySystem with {unknowns} unknowns", *lines])

    @property
    def has_large_bodies(self) -> bool:
        """Whether a flexible body has a large, sparse tangent."""
        return not all(model.is_small for model in self.flexible_models)

    @property
    def section_loads(self) -> dict[str, LineSource]:
        """Loads on sections of all bodies by name."""
        flexible = [x for model in self.flexible_models for x in model.section_loads]
        return {x.name: x for x in (*flexible, *self.rigid_section_loads)}

    def initial_state(self) -> State:
        """State at t = 0: bodies as given, flexible bodies moving with their parent body.

        A flexible body starts with its own velocity field if it has one; else, coupled to rigid
        bodies, with the rigid velocity field of the first of them, and at rest without.
        """
        model = self.rigid_model
        q = np.concatenate([np.zeros(0), *(b.coordinates for b in self.rigid_bodies)])
        q_dot = np.concatenate([np.zeros(0), *(b.rates for b in self.rigid_bodies)])
        u = tuple(b.new_vector() for b in self.flexible_models)
        v = tuple(b.new_vector() for b in self.flexible_models)
        coordinates = self.coordinates_of(q)
        for flexible, coupling, displacement, velocity in zip(
            self.flexible_models, self.coupling_blocks, u, v, strict=True
        ):
            field = initial_displacement(flexible, coupling, coordinates)
            displacement.array[:] = field.ravel()
            velocity.array[:] = initial_velocity(flexible, coupling, q_dot, field).ravel()
        return State(
            time=0.0,
            q=q,
            q_dot=q_dot,
            joint_coordinates=np.zeros(model.n_T),
            joint_rates=np.zeros(model.n_T),
            multipliers=np.zeros(model.n_constraints + model.n_T + model.n_relations),
            u=u,
            v=v,
            coupling=tuple(c.C.createVecLeft() for c in self.coupling_blocks),
        )

    def sum_prescribed_forces(self, time: float) -> ForceSum:
        """All prescribed forces at one time [s], except those on flexible bodies."""
        q = np.zeros(12 * len(self.rigid_bodies))
        forces = ForceSum(self.coordinates_of(q), dict.fromkeys(self.joint_coordinate_names, 0.0))
        for force in self.prescribed_forces:
            with name_errors(f"add_to() of {describe(force)}"):
                force.add_to(forces, time)
            check_force_sum(force, forces)
        return forces

    def _find_gravity(self) -> Array:
        """Acceleration of gravity at t = 0, shape (3,) [m/s^2]. Collective."""
        error, forces = None, None
        try:
            forces = self.sum_prescribed_forces(0.0)
        except Exception as raised:
            error = raised
        raise_together(self.comm, error)
        assert forces is not None
        return forces.acceleration

    def evaluate_prescribed_forces(self, time: float) -> tuple[Array, Array]:
        """Each of the prescribed forces at one time [s], without gravity. Collective.

        Returns:
            Forces on the coordinates of rigid bodies and on the joint coordinates, shapes
            (forces, 12 bodies) and (forces, joint coordinates).
        """
        return on_rank0_if_own(
            self.comm, self.prescribed_forces, lambda: self._evaluate_prescribed(time)
        )

    def _evaluate_prescribed(self, time: float) -> tuple[Array, Array]:
        """The same on this rank."""
        n = len(self.prescribed_forces)
        q, T = (
            np.zeros((n, 12 * len(self.rigid_bodies))),
            np.zeros((n, len(self.joint_coordinate_names))),
        )
        for k, force in enumerate(self.prescribed_forces):
            forces = ForceSum(
                self.coordinates_of(q[k]), dict.fromkeys(self.joint_coordinate_names, 0.0)
            )
            with name_errors(f"add_to() of {describe(force)}"):
                force.add_to(forces, time)
                T[k] = list(forces.torques.values())
        return q, T

    def relation_values(self, time: float) -> Array:
        """P of the relations of joint coordinates at one time [s], (relations,). Collective."""
        values = [
            0.0 if r.motion is None else evaluate_function(self.comm, repr(r.name), r.motion, time)
            for r in self.relations
        ]
        return np.array(values, dtype=float)

    def gravity_force(self, acceleration: Array) -> Array:
        """Weight of the rigid bodies as generalised force on q, shape (12 bodies,) [N]."""
        force = self.rigid_model.masses.reshape(-1, 4, 3) * acceleration
        force[:, 1:] = 0.0
        return force.ravel()

    def coordinates_of(self, q: Array) -> dict[RigidBody, Array]:
        """Coordinates of each rigid body, views of shape (12,)."""
        return {b: q[k : k + 12] for b, k in self.first_coordinate.items()}

    def balance(self, state: State) -> Balance:
        """Energies and momenta. Collective."""
        g = self.gravity
        partial = np.zeros(10)  # kinetic energy, momenta, strain, potential and surface energy
        for block, u, v in zip(self.flexible_models, state.u, state.v, strict=True):
            x = block.positions + u.array_r.reshape(-1, 3)
            partial[:8] += block.integrals(u, v)
            partial[8] -= block.nodal_mass @ (x @ g)
            partial[9] += block.surface_energy(u, state.time)
        total = sum_over_ranks(self.comm, partial) if self.flexible_models else partial
        p = self.rigid_model.masses * state.q_dot
        q, momentum = state.q.reshape(-1, 3), p.reshape(-1, 3)
        spring = on_rank0_if_own(
            self.comm,
            self.rigid_model.forces,
            lambda: self.rigid_model.spring_energy(state.q, state.joint_coordinates),
        )
        return Balance(
            kinetic=float(total[0] + 0.5 * np.dot(state.q_dot, p)),
            strain=float(total[7]),
            potential=float(total[8] - self.gravity_force(g) @ state.q),
            spring=float(total[9] + spring),
            linear=total[1:4] + momentum[::4].sum(axis=0),
            angular=total[4:7] + _moment(q, momentum),
        )

    def rigid_gaps(self, state: State) -> Array:
        """Violation of each constraint, without those of couplings [m, -]."""
        gaps = self.rigid_model.constraint_values(state.q, state.joint_coordinates)
        p = self.paths.values(state.time)
        gaps[: p.size] -= p
        return gaps

    def constraint_error(self, state: State) -> float:
        """Largest violation of any constraint [m, -]. Collective."""
        rigid = self.rigid_gaps(state)
        coordinates = self.coordinates_of(state.q)
        gaps = (c.gap(coordinates, u) for c, u in zip(self.coupling_blocks, state.u, strict=True))
        worst = max((float(np.max(np.abs(x), initial=0.0)) for x in (rigid, *gaps)), default=0.0)
        return largest_of_ranks(self.comm, worst)


def _check_law(body: DeformableBody) -> None:
    """Check the law of a body on a mesh once, and warn on one rank. Collective."""
    if body is body.full and body not in _CHECKED:
        for warning in check_material(body.material, body.mesh, body.name):
            if body.mesh.comm.rank == 0:
                warnings.warn(warning, ModelWarning, stacklevel=3)
        _CHECKED.add(body)


def _moment(x: Array, p: Array) -> Array:
    """Sum of the vector products of two lists of vectors, shape (n, 3) each."""
    A = x.T @ p
    return np.array([A[1, 2] - A[2, 1], A[2, 0] - A[0, 2], A[0, 1] - A[1, 0]])

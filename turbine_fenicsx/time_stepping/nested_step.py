"""One implicit step as nested blocks, whatever the scheme.

Unknowns X = (du | mu_c | r), increments and multipliers. The residual for one flexible body,

    | R_u + C^T mu_c          |
    | Phi_c(u_{n+1}, q_{n+1}) |
    | R_r + B^T mu_c          |,

is made of R_u of the body and R_r of the rigid part, which the scheme knows. Everything is a
function of the state at t_n and of X: a rejected step changes nothing.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from math import sqrt
from typing import Any, Protocol

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import raise_together, sum_over_ranks
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.blocks import StepBlocks, StepStart
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.body_step_interface import BodyStep


class RigidPart(Protocol):
    """The rigid part in a step; ``data`` is what the scheme's `NestedStep.start_step` made."""

    def residual(self, data: Any, r: Array) -> tuple[Array, Array]:
        """R_r and the sum of the absolute values of its terms."""

    def tangent(self, data: Any, r: Array) -> Array:
        """Derivative of R_r with respect to r."""

    def is_acceptable(self, data: Any, r: Array) -> bool:
        """Whether the solution r lies on the right branch."""


class NestedStep(StepBlocks):
    """Nested residual and tangent of one step of a system; a scheme adds what is abstract.

    That is `start_step`, which ends with `set_start`, `assemble_at_rest`, `guess` and `finish`, and
    the `frames` of `StepBlocks`.

    Args:
        system: The system.
        bodies: The flexible bodies in a step.
        rigid: The rigid part in a step.

    Attributes:
        residual_vector: Nested vector for the residual.
        driven: Which of `State.multipliers` drive something: those of constraints of joints that
            follow time, then those of all relations.
        rigid_data: What the rigid part is given in the step, set by `start_step`.
        dissipation_names: Names of what dissipates, in the order of `StepReport.dissipated`.
    """

    rigid_data: Any

    def __init__(
        self, system: MultibodySystem, bodies: Sequence[BodyStep], rigid: RigidPart
    ) -> None:
        super().__init__(system, tuple(body.tangent for body in bodies))
        self._bodies, self._rigid, model = tuple(bodies), rigid, system.rigid_model
        self.x, self.residual_vector = self.new_nested_vector(), self.new_nested_vector()
        k, n = len(bodies), model.size
        lengths = [np.max(np.abs(m.positions), initial=1.0) for m in system.flexible_models]
        lever = float(system.comm.allreduce(max(lengths, default=1.0), op=MPI.MAX))
        masses = model.masses.reshape(-1, 4, 3)
        largest = np.broadcast_to(masses.max(axis=1, keepdims=True), masses.shape)
        largest = np.where(largest > 0.0, largest, masses.max(initial=0.0) or 1.0)  # of frames
        self._per_mass = np.ones(n)  # makes accelerations of forces on bodies
        self._per_mass[: masses.size] /= np.where(masses > 0.0, masses, largest).ravel()
        self._lever = lever  # size of positions in the coupling constraints
        self._arms = np.tile(np.repeat([1.0] + 3 * [lever], 3), len(system.rigid_bodies))
        *parts, relations = (part.size for part in model.split(np.zeros(n)))
        parts[-1] += relations
        sizes = np.array(parts)
        self._parts = np.flatnonzero(sizes)
        self._starts = (np.cumsum(sizes) - sizes)[self._parts]
        kinds = np.array([e.kind for e in system.motion_forces], dtype=object)
        self._external, self._dissipative = kinds == "external", kinds == "dissipative"
        self.driven = np.append(system.paths.rows, np.arange(model.n_relations) + system.paths.size)
        self._driven = np.array([r.motion is not None for r in system.relations], dtype=bool)
        self.dissipation_names = (
            *(e.name for e in system.motion_forces if e.kind == "dissipative"),
            *(
                f"{name} of {model.body.name}"
                for model, body in zip(system.flexible_models, bodies, strict=True)
                for name in body.midpoint.losses
            ),
        )
        self._gaps: tuple[Array, ...] = ()
        self._error: InputError | None = None
        self._terms = np.zeros(2 * k + n)

    @abstractmethod
    def guess(self, extrapolate: bool, r: Array | None = None) -> None:
        """Set X to the start of the iteration.

        Args:
            extrapolate: Whether the bodies move on, or X is that of the last state.
            r: The rigid part of X where it is known better, shape (n_r,).
        """

    @abstractmethod
    def finish(self, out: State) -> tuple[Array, Array]:
        """Write the state at t_{n+1} that belongs to X. Collective.

        Args:
            out: A state other than the one of `start_step`, overwritten.

        Returns:
            Work of each of `MultibodySystem.work_names` in the step [J], zero for gravity, and
            what each of `dissipation_names` dissipated [J].
        """

    def set_start(self, state: State, dt: float, rigid_data: Any) -> None:
        """Set the state at t_n, the step [s], and what the rigid part is given."""
        coordinates = self.system.coordinates_of(state.q)
        self._gaps = tuple(
            c.gap(coordinates, u) for c, u in zip(self.system.coupling_blocks, state.u, strict=True)
        )
        self.start, self.rigid_data = StepStart(state, dt), rigid_data
        for loads in self.system.rigid_section_loads:
            y = np.concatenate([state.q, state.joint_coordinates])
            loads.start_step_at(StepTimes.from_start(state.time, dt), y[loads.index])

    def residual(self, x: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble the residual of X into R, and the scales of its terms."""
        du, mu_c, r = self.split(x)
        R_u, R_c, R_r = self.split(R)
        k = len(du)
        # momenta, joint coordinates and constraints of rigid bodies, eqs (57)-(59), in `RigidStep`
        if self.n_r:
            try:
                R_r.array[:], terms = self._rigid.residual(self.rigid_data, r.array_r)
                self._terms[2 * k :] = terms
            except InputError as error:  # of a force of a user; the other ranks know nothing of it
                self._error, R_r.array[:] = error, np.nan
        for i, (body, c) in enumerate(zip(self._bodies, self.system.coupling_blocks, strict=True)):
            C_T, B_T = self.transposed[i]
            # momenta of the nodes of the body, eqs (55), (57), in `FlexibleStep`, `ReducedStep`
            body.residual(du[i], R_u[i])
            # coupling forces C^T mu_c on the nodes and B^T mu_c on rigid bodies, eq. (53)
            C_T.multAdd(mu_c[i], R_u[i], R_u[i])
            B_T.multAdd(mu_c[i], R_r, R_r)
            # Phi_c at t_{n+1}, eq. (54)
            c.C.mult(du[i], R_c[i])
            c.B.multAdd(r, R_c[i], R_c[i])
            R_c[i].array[:] += self._gaps[i]
            self._terms[i], self._terms[k + i] = body.term_scale(du[i]), _square(mu_c[i])

    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble the tangent at X into `tangent_matrix`."""
        du, _, _ = self.split(x)
        for body, increment in zip(self._bodies, du, strict=True):
            body.assemble_tangent(increment)
        self.update_rigid_tangent(x)

    def turn_tangents(self, x: PETSc.Vec) -> list[tuple[Array | None, Array]] | None:
        """As of `NestedBlocks`; none without bodies, or where one of them keeps no tangent."""
        if not self._bodies or not all(body.keeps_tangent for body in self._bodies):
            return None
        du, _, _ = self.split(x)
        found = [body.turn_tangent(part) for body, part in zip(self._bodies, du, strict=True)]
        if any(Q is not None for Q, _ in found):
            self.update_rigid_tangent(x)
        return found

    def forget_tangents(self) -> None:
        """The next tangents are new, as an iteration failed."""
        for body in self._bodies:
            body.forget_tangent()

    def raise_error(self) -> None:
        """Raise on all ranks what a force has raised in the last residual, if any. Collective."""
        error, self._error = self._error, None
        raise_together(self.system.comm, error)

    def start_iteration(self) -> None:
        """Newton's iteration begins from the guess in X."""
        for body in self._bodies:
            body.start_iteration()

    def save(self) -> RestartData:
        """Data that later steps of the bodies depend on, apart from the state. Collective."""
        data = RestartData()
        for k, body in enumerate(self._bodies):
            data.add(str(k), body.save())
        return data

    def restore(self, data: RestartData) -> None:
        """Restore what was saved."""
        for k, body in enumerate(self._bodies):
            body.restore(data.part(str(k)))

    def update_body_tangent(self, body: int, x: PETSc.Vec) -> None:
        """Assemble only A_uu of a body at X."""
        self._bodies[body].assemble_tangent(self.split(x)[0][body])

    def update_rigid_tangent(self, x: PETSc.Vec) -> None:
        """Assemble only the rigid block K_r of the tangent at X."""
        r = self.split(x)[2]
        K = self._rigid.tangent(self.rigid_data, r.array_r) if self.n_r else np.zeros((0, 0))
        self.set_rigid_tangent(K)

    def mass_weights(self) -> Array:
        """Masses that belong to this rank's entries of X, zero for multipliers and angles."""
        system = self.system
        weights = [np.repeat(m.weights, 3) for m in system.flexible_models]
        weights += [np.zeros(c.dofs.size) for c in system.coupling_blocks]
        rigid = np.zeros(self.n_r)
        if self.n_r:
            rigid[: system.rigid_model.n_q] = system.rigid_model.masses
        return np.concatenate([*weights, rigid])

    def relative_residuals(self, R: PETSc.Vec, beyond_round_off: bool = False) -> Array:
        """Norm of each block of the residual over the norm of its terms (backward error).

        Args:
            R: The last residual.
            beyond_round_off: Whether only what exceeds the round-off of the forces of flexible
                bodies counts.

        Returns:
            Shape (2 bodies + 4,): displacements and couplings of each flexible body, then rigid
            coordinates, angles, rigid and joint constraints, angle constraints. Equal on all
            ranks.
        """
        R_u, R_c, R_r = self.split(R)
        k, n = len(R_u), self._terms.size
        sums = np.zeros((2, n + k))  # of residuals, and of their terms and round-off
        sums[0, : 2 * k] = [_square(part) for part in (*R_u, *R_c)]
        if self.n_r:
            np.abs(R_r.array_r, out=sums[0, 2 * k : n])
        sums[1, :n] = self._terms
        if beyond_round_off:
            sums[1, n:] = [body.round_off for body in self._bodies]
        sums = sum_over_ranks(self.system.comm, sums)
        # few numbers: lists take a fraction of the time of arrays
        squares, terms = sums[:, : 2 * k].tolist()
        inertia, coupling, noise = terms[:k], terms[k:], sums[1, n:].tolist()
        rigid = sums[:, 2 * k : n]
        forces = rigid[1, : self._arms.size]
        if k:
            forces += sqrt(sum(coupling)) * self._arms
        largest, of_terms = self._largest(self._per_mass * rigid).tolist()
        of_terms[1] += float(forces.max(initial=0.0))
        scales = [sqrt(a + b) for a, b in zip(inertia, coupling, strict=True)]
        scales += [self._lever] * k + of_terms
        norms = [sqrt(square) for square in squares] + largest
        norms[:k] = [x - min(x, sqrt(y)) for x, y in zip(norms[:k], noise, strict=True)]
        return np.array(norms) / [x if x > 0.0 else 1.0 for x in scales]

    def is_accepted(self) -> bool:
        """Whether the angles of the solution X lie on the right branch. Collective."""
        return self._rigid.is_acceptable(self.rigid_data, self.rigid_unknowns())

    def rigid_unknowns(self) -> Array:
        """The part r of X, a copy on every rank. Collective."""
        return self.on_all_ranks(self.split(self.x)[2])

    def sum_works(
        self, of_prescribed: Array, of_forces: Array, du: list[PETSc.Vec], of_drives: Array
    ) -> tuple[Array, Array]:
        """Works and dissipated energies in the order of their names [J]. Collective.

        Args:
            of_prescribed: Work of each prescribed force on rigid bodies and joint coordinates.
            of_forces: Work of each force that depends on the motion.
            du: Increment of each flexible body.
            of_drives: Work of each relation, then of each joint that follows time.
        """
        self._finish_loads()
        parts = [body.midpoint.works(x) for body, x in zip(self._bodies, du, strict=True)]
        works = np.concatenate([np.zeros(0), *(w for w, _ in parts)])
        totals = np.concatenate([works, *(losses for _, losses in parts)])
        if totals.size:
            totals = sum_over_ranks(self.system.comm, totals)
        on_bodies, lost = totals[: works.size], totals[works.size :]
        n = self._driven.size
        done = [of_prescribed, of_forces[self._external], on_bodies]
        done += [of_drives[:n][self._driven], of_drives[n:]]
        return np.concatenate(done), np.concatenate([-of_forces[self._dissipative], lost])

    def sum_drives(self, forces: Array, dq: Array, dT: Array) -> Array:
        """Work of each relation, then of each joint that follows time [J].

        Args:
            forces: Multipliers of the rows `driven`.
            dq: Increment of the coordinates of rigid bodies.
            dT: Increment of the joint coordinates.
        """
        paths, model = self.system.paths, self.system.rigid_model
        n = paths.rows.size
        of_relations: Array = -forces[n:] * (model.S @ dT)
        if not n:
            return of_relations
        G = model.functions.jacobian(self.start.state.q + 0.5 * dq)
        return np.append(of_relations, paths.sum_works(forces[:n], G[paths.rows], dq))

    def _finish_loads(self) -> None:
        """Notify the loads on rigid sections that the step is done. Collective."""
        if not self.system.rigid_section_loads:
            return
        state, times = self.start.state, StepTimes.from_start(self.start.state.time, self.start.dt)
        y0 = np.concatenate([state.q, state.joint_coordinates])
        y1 = y0 + self.rigid_unknowns()[: y0.size]
        for loads in self.system.rigid_section_loads:
            loads.finish_step(times, y0[loads.index], y1[loads.index])

    def _largest(self, rigid: Array) -> Array:
        """Largest entry of each of the four parts of rigid vectors; zero for an empty part."""
        largest = np.zeros((len(rigid), 4))
        if self._parts.size:
            largest[:, self._parts] = np.maximum.reduceat(rigid, self._starts, axis=1)
        return largest


def _square(vector: PETSc.Vec) -> float:
    """Sum of the squares of this rank's entries."""
    values = vector.array_r
    return float(values @ values)

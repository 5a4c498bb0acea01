"""One energy-momentum step (BEM, BHEM) as nested blocks, eqs (21)-(24), (55)-(59).

Unknowns X = (du | mu_c | r) for every flexible body its displacement increments and coupling
multipliers, and one small block r of rigid bodies, joints and joint angles, which rank 0 owns. The
residual and its tangent, for one flexible body,

    | R_u + C^T mu_c          |        | A_uu  C^T  0   |
    | Phi_c(u_{n+1}, q_{n+1}) |        | C     0    B   |
    | R_r + B^T mu_c          |        | 0     B^T  K_r |

are multiplied by dt^2/2; so are the multipliers. Everything is a function of the state at t_n and
of X: a rejected step changes nothing.
"""

from __future__ import annotations

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.forces.element import Step
from turbine_fenicsx.foundation.dense import ScaledFactor
from turbine_fenicsx.foundation.parallel import from_rank0, sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.rigid_block import RigidStep
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class EnergyMomentumStep:
    """Nested residual and tangent of one step of a system.

    Args:
        system: The system.

    Attributes:
        x: Nested vector of the unknowns.
        residual_vector: Nested vector for the residual.
        tangent_matrix: Nested matrix of the tangent.
        rigid_tangent: K_r on rank 0, shape (n_r, n_r); empty on the others.
        state: State at t_n, set by `begin`.
        dt: Step [s], set by `begin`.
    """

    def __init__(self, system: MultibodySystem) -> None:
        """Allocate vectors and matrices."""
        self.system = system
        comm = system.comm
        n = system.rigid_block.size
        self._n_r = n if comm.rank == 0 else 0
        flexible, couplings = system.flexible_blocks, system.coupling_blocks
        self._K = PETSc.Mat().createDense(((self._n_r, n), (self._n_r, n)), comm=comm)
        self._K.setUp()
        self._K.assemble()
        k = len(flexible)
        blocks: list[list[PETSc.Mat | None]] = [[None] * (2 * k + 1) for _ in range(2 * k + 1)]
        self._transposed = []
        for i, (f, c) in enumerate(zip(flexible, couplings, strict=True)):
            C_T, B_T = c.C.transpose(PETSc.Mat()), c.B.transpose(PETSc.Mat())
            self._transposed.append((C_T, B_T))
            blocks[i][i], blocks[i][k + i], blocks[k + i][i] = f.tangent, C_T, c.C
            blocks[k + i][2 * k], blocks[2 * k][k + i] = c.B, B_T
        blocks[2 * k][2 * k] = self._K
        self.tangent_matrix = PETSc.Mat().createNest(blocks, comm=comm)
        self.tangent_matrix.setUp()
        self.x, self.residual_vector = self.new_nested_vector(), self.new_nested_vector()
        lengths = [np.max(np.abs(f.positions), initial=1.0) for f in flexible]
        lever = float(comm.allreduce(max(lengths, default=1.0), op=MPI.MAX))
        masses = system.rigid_block.masses.reshape(-1, 4, 3)
        largest = np.broadcast_to(masses.max(axis=1, keepdims=True), masses.shape)
        self._per_mass = np.ones(n)
        self._per_mass[: masses.size] /= np.where(masses > 0.0, masses, largest).ravel()
        self._levers = np.full(k, lever)
        self._arms = np.tile(np.repeat([1.0] + 3 * [lever], 3), len(system.rigid_bodies))
        self.rigid_tangent = np.zeros((self._n_r, self._n_r))
        *parts, prescribed = (part.size for part in system.rigid_block.split(np.zeros(n)))
        parts[-1] += prescribed
        sizes = np.array(parts)
        self._parts = np.flatnonzero(sizes)
        self._starts = (np.cumsum(sizes) - sizes)[self._parts]
        names = [system.angle_names.index(m.coordinate) for m in system.motions]
        self._prescribed = np.array(names, dtype=np.int64)
        kinds = np.array([e.kind for e in system.elements], dtype=object)
        self._external, self._dissipative = kinds == "external", kinds == "dissipative"
        self._gaps: tuple[Array, ...] = ()
        self._terms = np.zeros(2 * k + n)
        self._weight = system.gravity_force(system.gravity)

    def new_nested_vector(self) -> PETSc.Vec:
        """New nested vector with the layout of the unknowns, zero."""
        system = self.system
        parts = [f.new_vector() for f in system.flexible_blocks]
        parts += [c.C.createVecLeft() for c in system.coupling_blocks]
        parts.append(PETSc.Vec().createMPI((self._n_r, system.rigid_block.size), comm=system.comm))
        for part in parts:
            part.set(0.0)
        return PETSc.Vec().createNest(parts, comm=system.comm)

    def split(self, x: PETSc.Vec) -> tuple[list[PETSc.Vec], list[PETSc.Vec], PETSc.Vec]:
        """Parts (du of each body, mu_c of each body, r) of a nested vector."""
        parts = x.getNestSubVecs()
        k = len(self.system.flexible_blocks)
        return parts[:k], parts[k : 2 * k], parts[2 * k]

    def begin(self, state: State, dt: float, at: float | None = None) -> None:
        """Set the state at t_n and the step dt [s].

        Args:
            state: The state.
            dt: The step.
            at: Time of all loads and motions [s]; if None, that of the middle and of the end.
        """
        system = self.system
        half_dt2 = 0.5 * dt * dt
        middle, end = (state.time + 0.5 * dt, state.time + dt) if at is None else (at, at)
        self.load_q, self.load_T = system.forces_by_load(middle)
        self.rigid_step = RigidStep(
            q=state.q,
            angles=state.angles,
            dt_q_dot=dt * state.q_dot,
            impulse_q=half_dt2 * (self._weight + self.load_q.sum(axis=0)),
            impulse_T=half_dt2 * self.load_T.sum(axis=0),
            prescribed=np.array([m.motion(end) for m in system.motions]),
            elements=Step(dt, middle),
        )
        coordinates = system.coordinates_of(state.q)
        for f, u, v in zip(system.flexible_blocks, state.u, state.v, strict=True):
            f.begin(u, v, dt, system.gravity, middle)
        self._gaps = tuple(
            c.gap(coordinates, u) for c, u in zip(system.coupling_blocks, state.u, strict=True)
        )
        self.dt, self.state = dt, state

    def guess(self, extrapolate: bool, r: Array | None = None) -> None:
        """Set X to the start of the iteration: x_n + dt v_n, or x_n without extrapolation.

        Args:
            extrapolate: Whether the bodies move on.
            r: The rigid part of X where it is known better, shape (n_r,).
        """
        state, dt = self.state, self.dt
        factor = dt if extrapolate else 0.0
        du, mu_c, r_part = self.split(self.x)
        for increment, v in zip(du, state.v, strict=True):
            v.copy(increment)
            increment.scale(factor)
        for mu, force in zip(mu_c, state.coupling, strict=True):
            force.copy(mu)
            mu.scale(0.5 * dt * dt)
        if self._n_r and r is not None:
            r_part.array[:] = r
        elif self._n_r:
            forces = 0.5 * dt * dt * state.multipliers
            r_part.array[:] = np.concatenate(
                [factor * state.q_dot, factor * state.angle_rates, forces]
            )

    def residual(self, x: PETSc.Vec, R: PETSc.Vec) -> None:
        """Assemble the residual of X into R, and the scales of its terms."""
        du, mu_c, r = self.split(x)
        R_u, R_c, R_r = self.split(R)
        block = self.system.rigid_block
        k = len(du)
        if self._n_r:
            R_r.array[:], self._terms[2 * k :] = block.residual(self.rigid_step, r.array_r)
        for i, (f, c) in enumerate(
            zip(self.system.flexible_blocks, self.system.coupling_blocks, strict=True)
        ):
            C_T, B_T = self._transposed[i]
            f.residual(du[i], R_u[i])
            C_T.multAdd(mu_c[i], R_u[i], R_u[i])
            B_T.multAdd(mu_c[i], R_r, R_r)
            c.C.mult(du[i], R_c[i])
            c.B.multAdd(r, R_c[i], R_c[i])
            R_c[i].array[:] += self._gaps[i]
            self._terms[i], self._terms[k + i] = f.term_scale(du[i]), _square(mu_c[i])

    def tangent(self, x: PETSc.Vec) -> None:
        """Assemble the tangent at X into `tangent_matrix`."""
        du, _, _ = self.split(x)
        for f, increment in zip(self.system.flexible_blocks, du, strict=True):
            f.assemble_tangent(increment)
        self.update_rigid_tangent(x)

    def update_rigid_tangent(self, x: PETSc.Vec) -> None:
        """Assemble only the rigid block K_r of the tangent at X."""
        if self._n_r:
            r = self.split(x)[2].array_r
            self.rigid_tangent = self.system.rigid_block.tangent(self.rigid_step, r)
            self._K.getDenseArray()[:] = self.rigid_tangent
        self._K.assemble()
        self.tangent_matrix.assemble()

    def solve_rigid(self, reduced: ScaledFactor, r: PETSc.Vec) -> Array:
        """Solve the reduced equations on rank 0, overwriting r, and hand r to all ranks.

        Args:
            reduced: K_r with the Schur complements of the flexible bodies, on rank 0; empty on
                the others.
            r: Right-hand side, then solution.

        Returns:
            The solution, shape (n_r,), on every rank.
        """
        if self._n_r:
            r.array[:] = reduced.solve(r.array_r)
        return self.on_all_ranks(r)

    def mass_weights(self) -> Array:
        """Masses that belong to this rank's entries of X, zero for multipliers and angles."""
        system = self.system
        weights = [np.repeat(np.abs(f.nodal_mass), 3) for f in system.flexible_blocks]
        weights += [np.zeros(c.dofs.size) for c in system.coupling_blocks]
        rigid = np.zeros(self._n_r)
        if self._n_r:
            rigid[: system.rigid_block.n_q] = system.rigid_block.masses
        return np.concatenate([*weights, rigid])

    def relative_residuals(self, R: PETSc.Vec) -> Array:
        """Norm of each block of the residual over the norm of its terms (backward error).

        The second row counts only what exceeds the round-off of the forces of flexible bodies.

        Returns:
            Shape (2, 2 bodies + 4): displacements and couplings of each flexible body, then rigid
            coordinates, angles, rigid and joint constraints, angle constraints. Equal on all
            ranks.
        """
        R_u, R_c, R_r = self.split(R)
        k = len(R_u)
        n = self._terms.size
        sums = np.zeros((2, n + k))
        sums[0, : 2 * k] = [_square(part) for part in (*R_u, *R_c)]
        if self._n_r:
            np.abs(R_r.array_r, out=sums[0, 2 * k : n])
        sums[1, :n] = self._terms
        sums[1, n:] = [f.round_off for f in self.system.flexible_blocks]
        total_sums = sum_over_ranks(self.system.comm, sums)
        residual, terms, noise = total_sums[0, :n], total_sums[1, :n], total_sums[1, n:]
        rigid = self._largest(self._per_mass * residual[2 * k :])
        total = np.concatenate([np.sqrt(residual[: 2 * k]), rigid])
        beyond_round_off = total.copy()
        beyond_round_off[:k] = np.maximum(total[:k] - np.sqrt(noise), 0.0)
        return np.array([total, beyond_round_off]) / self._scales(terms)

    def accepted(self) -> bool:
        """Whether the angles of the solution X lie on the right branch. Collective."""
        return self.system.rigid_block.acceptable(self.rigid_step, self.rigid_unknowns())

    def finish(self, out: State) -> tuple[Array, Array]:
        """Write the state at t_{n+1} that belongs to X. Collective.

        Args:
            out: A state other than the one of `begin`, overwritten.

        Returns:
            Work of each of `MultibodySystem.work_names` in the step [J], exactly force times
            increment and zero for gravity, and what each of
            `MultibodySystem.dissipation_names` dissipated [J].
        """
        state, dt = self.state, self.dt
        du, mu_c, _ = self.split(self.x)
        r = self.rigid_unknowns()
        dq, dT, mu, nu, pi = self.system.rigid_block.split(r)
        out.time = state.time + dt
        out.q = state.q + dq
        out.q_dot = 2.0 / dt * dq - state.q_dot
        out.angles = state.angles + dT
        out.angle_rates = dT / dt
        out.multipliers = 2.0 / dt**2 * np.concatenate([mu, nu, pi])
        for i, increment in enumerate(du):
            out.u[i].waxpy(1.0, state.u[i], increment)
            state.v[i].copy(out.v[i])
            out.v[i].axpby(2.0 / dt, -1.0, increment)
            mu_c[i].copy(out.coupling[i])
            out.coupling[i].scale(2.0 / dt**2)
        system = self.system
        blocks = system.flexible_blocks
        flexible = [
            *(f.works(x) for f, x in zip(blocks, du, strict=True)),
            *(f.dissipated(x) for f, x in zip(blocks, du, strict=True)),
        ]
        totals = np.concatenate([np.zeros(0), *flexible])
        if totals.size:
            totals = sum_over_ranks(system.comm, totals)
        n_works = sum(len(f.loads) for f in blocks)
        elements = system.rigid_block.element_works(self.rigid_step, r)
        works = [
            self.load_q @ dq + self.load_T @ dT,
            elements[self._external],
            totals[:n_works],
            -2.0 / dt**2 * pi * dT[self._prescribed],
        ]
        damped = elements[self._dissipative]
        return np.concatenate(works), np.concatenate([-damped, totals[n_works:]])

    def _scales(self, terms: Array) -> Array:
        """Sizes of the terms of each block from those of all ranks, laid out like the residuals."""
        k = len(self.system.flexible_blocks)
        inertia, coupling, rigid = terms[:k], terms[k : 2 * k], terms[2 * k :]
        forces = rigid[: self._arms.size]
        forces += np.sqrt(coupling.sum()) * self._arms
        largest = self._largest(self._per_mass * rigid)
        largest[1] += forces.max(initial=0.0)
        scales = np.concatenate([np.sqrt(inertia + coupling), self._levers, largest])
        return np.where(scales > 0.0, scales, 1.0)

    def _largest(self, rigid: Array) -> Array:
        """Largest entry of each of the four parts of a rigid vector; zero for an empty part."""
        largest = np.zeros(4)
        if self._parts.size:
            largest[self._parts] = np.maximum.reduceat(rigid, self._starts)
        return largest

    def rigid_unknowns(self) -> Array:
        """The part r of X, a copy on every rank. Collective."""
        return self.on_all_ranks(self.split(self.x)[2])

    def on_all_ranks(self, r: PETSc.Vec) -> Array:
        """The rigid part of a vector, a copy on every rank."""
        values = np.array(r.array_r) if self._n_r else np.empty(self.system.rigid_block.size)
        return from_rank0(self.system.comm, values)


def _square(vector: PETSc.Vec) -> float:
    """Sum of the squares of this rank's entries."""
    return float(np.dot(vector.array_r, vector.array_r))

"""One factorisation for a whole run, applied in frames that turn with the material.

Almost only rotation changes the tangent of a stiff body from step to step. R_l and R_r are the
rotations around each node relative to the state where A was factorised. R_l belongs to the middle
of the step, where its forces act, and R_r to the end, to which the unknowns belong. Then

    A_uu  is nearly  R_l A R_r^T,

so that the factor of A serves for all later steps. Rotations of contact nodes are those of their
parent body, R_l for forces and R_r for motions of both: then P, Z and the Schur complement just
turn, and the coupling stays exact. `QuasiNewton` makes up for what the deformation changes beyond
that.

A body with a small dense tangent has no frames: its tangent is new in each update.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.blocks import StepBlocks
from turbine_fenicsx.linear_solvers.body_elimination import BodyElimination
from turbine_fenicsx.linear_solvers.dense_elimination import DenseElimination
from turbine_fenicsx.linear_solvers.elimination import EliminatedBody, ReducedEquations
from turbine_fenicsx.linear_solvers.factor import FreeSolver
from turbine_fenicsx.linear_solvers.frames import NodeFrames, turn
from turbine_fenicsx.linear_solvers.substructures import Substructures
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel

log = logging.getLogger(__name__)

SolverMaker = Callable[[FlexibleModel, CouplingBlock, PETSc.Mat, PETSc.IS], FreeSolver]


class FrozenElimination:
    """Elimination with a factor that is kept as long as it serves.

    The factor belongs to the first state and step size; a new step size or `refresh` replaces it.

    Args:
        step: The step whose tangent is solved with.
        make_solver: Makes the solver for A_II, which is symmetric, from the body, its couplings,
            the matrix and the free degrees of freedom.
    """

    def __init__(self, step: StepBlocks, make_solver: SolverMaker) -> None:
        """Nothing is factorised yet."""
        system = step.system
        self._step = step
        self._turning: dict[int, _TurningBody] = {}
        self._small: dict[int, DenseElimination] = {}
        for k, (m, A, c) in enumerate(
            zip(system.flexible_models, step.tangents, system.coupling_blocks, strict=True)
        ):
            if m.is_small:
                self._small[k] = DenseElimination(m, A, c)
            else:
                self._turning[k] = _TurningBody(m.full, A, c, make_solver)
        bodies: dict[int, EliminatedBody] = {**self._turning, **self._small}
        self._reduced = ReducedEquations(step, [bodies[k] for k in sorted(bodies)])
        self._dt = 0.0
        self._factorised_at = RestartData()

    @property
    def has_small_bodies(self) -> bool:
        """Whether some bodies have small tangents, which `update` makes exact."""
        return bool(self._small)

    @property
    def krylov_iterations(self) -> int:
        """Krylov iterations for the free nodes of all bodies so far."""
        return sum(body.solver.iterations for body in self._turning.values())

    @property
    def factors(self) -> tuple[int, int]:
        """Number of factors, and of the components of bodies that they serve."""
        factors, components = np.sum(
            [body.solver.factors for body in self._turning.values()], axis=0
        )
        return int(factors), int(components)

    def start_iteration(self) -> bool:
        """Turn the frames to the guess of the step; factorise for a new step size: whether so."""
        start, parts = self._step.start, self._step.frames
        new = start.dt != self._dt
        if new:
            self.refresh()
        increments = self._step.split(self._step.x)[0]
        for k, body in self._turning.items():
            carriers = self._carrier_rotations(body.coupling, parts)
            body.turn_to(start.state.u[k], increments[k], carriers, parts)
        return new

    def update(self, x: PETSc.Vec) -> None:
        """Form the reduced matrix on rank 0: exact rigid block, turned Schur complements."""
        for k, small in self._small.items():
            self._step.update_body_tangent(k, x)
            small.factorise()
        self._step.update_rigid_tangent(x)
        self._reduced.update()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one nested right-hand side with the turned factors."""
        self._reduced.solve(b, x)

    def refresh(self) -> None:
        """Factorise the tangent at the last state; at rest (du = 0) it is symmetric."""
        log.info(
            "new factor at t = %.6g s for steps of %.3g s",
            self._step.start.state.time,
            self._step.start.dt,
        )
        self._factorise()

    def _factorise(self) -> None:
        """Factorise, and note where."""
        state, self._dt = self._step.start.state, self._step.start.dt
        displacements = tuple(u.array_r.reshape(-1, 3).copy() for u in state.u)
        self._factorised_at = RestartData(
            {"dt": self._dt}, {"q": state.q.copy()}, {"u": displacements}
        )
        for k, body in self._turning.items():
            self._step.assemble_at_rest(k)
            body.factorise(state.u[k], self._carrier_rotations(body.coupling, (0.0,))[0])
        log.info("components of bodies: %d, factors: %d", *self.factors[::-1])

    def save(self) -> RestartData:
        """The state and step size that the factor belongs to."""
        return self._factorised_at

    def restore(self, data: RestartData) -> None:
        """Factorise where the factor was made."""
        if data:
            state = self._step.system.initial_state()
            state.q = data.arrays["q"]
            for u, values in zip(state.u, data.nodal.get("u", ()), strict=True):
                u.array[:] = values.ravel()
            self._step.start_step(state, data.numbers["dt"])
            self._factorise()
            state.destroy()

    def destroy(self) -> None:
        """Free all PETSc objects."""
        for body in self._turning.values():
            body.destroy()

    def _carrier_rotations(self, coupling: CouplingBlock, parts: tuple[float, ...]) -> Array:
        """Directors of the parents after parts of the step, shape (parts, parents, 3, 3)."""
        state, dt = self._step.start.state, self._step.start.dt
        first = self._step.system.first_coordinate
        carriers = [first[body] // 12 for body in coupling.carriers]
        q, q_dot = (x.reshape(-1, 4, 3)[carriers, 1:] for x in (state.q, state.q_dot))
        moved = np.array([q + part * dt * q_dot for part in parts])
        return nearest_rotation(moved.swapaxes(2, 3))


class _TurningBody:
    """The frozen elimination of one flexible body and its frames.

    Attributes:
        columns: Columns of r that belong to the parent bodies.
        schur: The Schur complement, turned with the parent bodies.
    """

    schur: Array

    def __init__(
        self,
        flexible: FlexibleModel,
        tangent: PETSc.Mat,
        coupling: CouplingBlock,
        make_solver: SolverMaker,
    ) -> None:
        """Set up frames and elimination."""
        self.coupling, self.columns = coupling, coupling.columns
        self._frames = NodeFrames(flexible)
        self._elimination = BodyElimination(
            flexible, tangent, coupling, lambda A, free: make_solver(flexible, coupling, A, free)
        )
        self.solver = self._elimination.solver
        self._free = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)

    def factorise(self, u: PETSc.Vec, carriers: Array) -> None:
        """Factorise the tangent assembled at rest in u; its frames are the reference."""
        (self._reference,) = self._frames.rotations(u)
        if isinstance(self.solver, Substructures):
            self.solver.rotations = self._reference[:, :, self._free]
        self._elimination.factorise()
        self._carriers_0 = carriers

    def turn_to(
        self, u: PETSc.Vec, du: PETSc.Vec, carriers: Array, parts: tuple[float, float]
    ) -> None:
        """Set the rotations between the factorised state and the present step.

        Args:
            u: Displacements at t_n [m].
            du: Increments of the step [m].
            carriers: Directors of the parent bodies where forces act and where motions belong to,
                shape (2, parents, 3, 3).
            parts: The parts of the step that lie before these.
        """
        self._left, self._right = (
            np.einsum("ikn,jkn->ijn", R, self._reference)
            for R in self._frames.rotations(u, du, parts)
        )
        self._carriers = carriers @ self._carriers_0.swapaxes(1, 2)
        for frames, of_carriers in zip((self._left, self._right), self._carriers, strict=True):
            for coupling, rows in zip(self.coupling.couplings, self.coupling.slices, strict=True):
                R = np.eye(3)
                if coupling.rigid is not None:
                    R = of_carriers[self.coupling.carriers.index(coupling.rigid)]
                frames[:, :, self.coupling.nodes[rows]] = R[:, :, None]
        self._contact = [R[:, :, self.coupling.nodes] for R in (self._left, self._right)]
        (left, right), n = self._carriers, len(self._carriers_0)
        S = self._elimination.schur.reshape(n, 4, 3, n, 4, 3)
        self.schur = np.einsum("aij,asjbtk,blk->asibtl", left, S, right).reshape(12 * n, 12 * n)

    def eliminate(self, b_u: Array, b_c: Array) -> Array:
        """Compute w in the frames, and the forces on the parent bodies in space."""
        b_u = turn(self._left, b_u, inverse=True)
        forces = self._elimination.eliminate(b_u, turn(self._contact[1], b_c, inverse=True))
        return self._turn_carriers(forces, self._carriers[0])

    def substitute(self, motion: Array) -> tuple[Array, Array]:
        """Displacements and multipliers in space for the motion of the parent bodies in space."""
        in_frames = self._turn_carriers(motion, self._carriers[1].swapaxes(1, 2))
        u, mu_c = self._elimination.substitute(in_frames)
        return turn(self._right, u), turn(self._contact[0], mu_c)

    def destroy(self) -> None:
        """Free all PETSc objects."""
        self._elimination.destroy()

    @staticmethod
    def _turn_carriers(vector: Array, R: Array) -> Array:
        """Turn the four 3-vectors of each parent body."""
        turned: Array = (vector.reshape(-1, 4, 3) @ R.swapaxes(1, 2)).ravel()
        return turned

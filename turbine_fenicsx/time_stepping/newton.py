"""Newton's method for one step: SNES over the nested blocks, converged block by block.

To follow a step, read in this order:

1. `NewtonStepper.advance`: attempts one after the other, until one converges (``attempts.py``).
2. `NestedStep.start_step` of the scheme: state at t_n, step, what is constant in it
   (``energy_momentum.py`` or ``generalised_alpha.py``; bodies in ``flexible_step.py``).
3. `NestedStep.guess` and `FirstGuess`: where X starts (``first_guess.py``).
4. `LinearSolver.start_iteration`: the old factor or a new one (``linear_solvers/quasi_newton.py``).
5. `NestedStep.residual`: R_u, Phi_c and R_r of X (``nested_step.py``, ``flexible_step.py``,
   ``rigid_step.py``).
6. `BlockwiseConvergence`: whether each block is small beside its terms (``convergence.py``).
7. `LinearSolver.turn` or `update`, and `solve`: the correction of X
   (``linear_solvers/elimination.py``); from here back to 5, until all blocks have converged.
8. `NestedStep.finish`: the state at t_{n+1}, works and what dissipated.
"""

from __future__ import annotations

import logging
import weakref
from collections.abc import Callable

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation import timing
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.foundation.petsc_options import default_options
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers import LINEAR_SOLVERS
from turbine_fenicsx.linear_solvers.base import LinearSolver
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.system.start import check_closed_state
from turbine_fenicsx.system.state import State
from turbine_fenicsx.time_stepping.attempts import Attempt, Attempts, Failure, tell
from turbine_fenicsx.time_stepping.convergence import BlockwiseConvergence
from turbine_fenicsx.time_stepping.first_guess import FirstGuess
from turbine_fenicsx.time_stepping.nested_step import NestedStep
from turbine_fenicsx.time_stepping.solver_options import SolverOptions
from turbine_fenicsx.time_stepping.stepper import StepReport


def describe_largest_residual(step: NestedStep, R: PETSc.Vec) -> str:
    """Name the equations whose residual is largest compared with their terms. Collective.

    Returns:
        For example ``"blade_1 near (0.1, 12.3, -4) m"``, equal on all ranks; empty if there is no
        finite residual.
    """
    relative = step.relative_residuals(R)
    if not np.all(np.isfinite(relative)):
        return ""
    bodies = step.system.flexible_models
    largest = int(np.argmax(relative))
    if largest < 2 * len(bodies):
        return _in_body(step, R, largest)
    return _in_rigid_block(step, R, largest - 2 * len(bodies))


def _in_body(step: NestedStep, R: PETSc.Vec, number: int) -> str:
    """The node of a flexible body, or of its couplings, with the largest residual."""
    k, coupled = number % len(step.system.flexible_models), number >= len(step.start.state.u)
    block, coupling = step.system.flexible_models[k], step.system.coupling_blocks[k]
    part = step.split(R)[1 if coupled else 0][k].array_r.reshape(-1, 3)
    nodes = coupling.nodes if coupled else np.arange(block.n_owned)
    sizes = np.linalg.norm(part, axis=1)
    worst = int(np.argmax(sizes)) if sizes.size else -1
    comm = step.system.comm
    mine = (float(sizes[worst]) if sizes.size else -1.0, comm.rank)
    owner = comm.allreduce(mine, op=MPI.MAXLOC)[1]
    name, place, is_point = block.body.name, np.zeros(3), True
    if comm.rank == owner:
        node = nodes[worst]
        place = block.positions[node] + step.start.state.u[k].array_r.reshape(-1, 3)[node]
        is_point = bool(block.is_point[node])
        if coupled:
            slices = zip(coupling.couplings, coupling.slices, strict=True)
            name = next(c.name for c, rows in slices if rows.start <= worst < rows.stop)
    name, place, is_point = comm.bcast((name, place, is_point), root=owner)
    return name if not is_point else f"{name} near ({', '.join(f'{x:.4g}' for x in place)}) m"


def _in_rigid_block(step: NestedStep, R: PETSc.Vec, part: int) -> str:
    """The rigid body or joint with the largest residual."""
    system = step.system
    residual: Array = np.abs(step.on_all_ranks(step.split(R)[2]))
    dq, dT, mu, nu, pi = system.rigid_model.split(residual)
    if part == 0:
        return system.rigid_bodies[int(np.argmax(dq)) // 12].name
    if part == 2:
        row = int(np.argmax(mu))
        owners = [body.name for body in system.rigid_bodies for _ in range(6)]  # directors first
        joints = (name for name, rows in system.joint_rows.items() if row in rows)
        return f"the constraints of {next(joints, None) or owners[row]}"
    of_angles = dT if part == 1 else nu
    if part == 3 and np.max(pi, initial=0.0) > np.max(nu, initial=0.0):
        return f"relation {system.relations[int(np.argmax(pi))].name!r}"
    return f"joint coordinate {system.joint_coordinate_names[int(np.argmax(of_angles))]}"


log = logging.getLogger(__name__)

FALLBACKS = {"frozen": "lu"}
"""Exact linear solvers that take over where a step fails with an approximate one."""


class NewtonStepper:
    """Advances a system by implicit steps.

    Args:
        step: The equations of a step.
        options: Tolerances and linear solver.

    Attributes:
        system: The system.
        step: The equations of the step.
        linear_solver: Name of the linear solver in use.
        fallbacks: How often another attempt had to take over for one that failed.
        factors: Number of factors of a frozen linear solver, and of the components of bodies that
            they serve; (0, 0) for others.
        snes: The PETSc solver; options with the prefix apply.
        destroy: Frees all PETSc objects; collective; at the latest when the program ends.
    """

    def __init__(self, step: NestedStep, options: SolverOptions | None = None) -> None:
        self.options = options = options or SolverOptions()
        self.step, self.system = step, step.system
        self.dissipation_names = step.dissipation_names
        self.linear_solver = options.linear_solver
        self._solvers = _LinearSolvers(step, options.prefix)
        # without large flexible bodies all but "monolithic" are the same
        self._is_exact = not self.system.has_large_bodies
        keeps = self._is_exact and bool(self.system.flexible_models)
        exact = self.linear_solver if self._is_exact else FALLBACKS.get(self.linear_solver)
        self._attempts = Attempts(self.linear_solver, exact or self.linear_solver)
        self.fallbacks, self.factors = 0, (0, 0)
        self._last: Callable[[], State | None] = lambda: None
        self._guess = FirstGuess(step)
        self._convergence = convergence = BlockwiseConvergence(step, options)
        self.snes = snes = PETSc.SNES().create(self.system.comm)
        snes.setOptionsPrefix(options.prefix)
        snes.setType("newtonls")
        snes.setFunction(evaluate_residual, step.residual_vector, kargs={"step": step})
        snes.setJacobian(
            evaluate_tangent,
            step.tangent_matrix,
            kargs={
                "linear_solvers": self._solvers,
                "convergence": convergence if keeps else None,
            },
        )
        snes.setConvergenceTest(self._convergence)
        snes.setTolerances(max_it=options.max_iterations)
        ksp = snes.getKSP()
        ksp.setType("preonly")
        pc = ksp.getPC()
        pc.setType("python")
        pc.setPythonContext(self._solvers)
        with default_options(options.prefix, {"snes_linesearch_type": "basic"}):
            snes.setFromOptions()
        # Factors must go before MPI does, also when a script just ends.
        self.destroy = weakref.finalize(self, _destroy, self._solvers, snes)

    def advance(self, state: State, dt: float, out: State) -> StepReport:
        """One step from ``state`` to t + dt.

        Newton starts from where the velocities lead; if that fails, again with a new factor in
        place of a frozen one, then with the exact tangent, and then from x_n. `FirstGuess` corrects
        the start by the last steps if there are enough; with flexible bodies only where tangents
        are not exact.

        Args:
            state: State at t_n, not changed.
            dt: Step [s].
            out: Another state, overwritten with the one at t_{n+1}.

        Returns:
            What the step took.

        Raises:
            ModelError: if the state opens a constraint.
            StepFailure: if Newton's method fails from both starts; ``out`` is then unchanged.
        """
        if state is not self._last():  # of a loop that begins here
            check_closed_state(self.system, state)
        newton = krylov = 0
        failures: list[Failure] = []
        self.step.start_step(state, dt)
        waiting = self._list_attempts(state.time, dt)
        while waiting:
            attempt, guess = waiting.pop(0)
            self._log_fallback(state.time, dt, failures, attempt)
            self._start_at(attempt, guess)
            self.step.start_iteration()
            linear_solver = self._solvers.use(attempt.solver)
            with timing.event("linear set-up"):
                linear_solver.start_iteration()
            self._convergence.start_iteration(approximate=attempt.solver in FALLBACKS)
            before = linear_solver.krylov_iterations
            with np.errstate(all="ignore"):  # what diverges overflows; the residual tells it
                self.snes.solve(None, self.step.x)
            iterations = self.snes.getIterationNumber()
            newton += iterations
            krylov += linear_solver.krylov_iterations - before
            reason = self.snes.getConvergedReason()
            accepted = reason > 0 and self.step.is_accepted()
            if linear_solver.end_iteration(accepted):
                waiting.insert(0, (attempt, None))
            if isinstance(linear_solver, QuasiNewton):
                self.factors = linear_solver.factors
            if accepted:
                self.fallbacks += len(failures)
                works, dissipated = self._finish(attempt, out)
                residual = self._convergence.history[-1] * self.options.tolerance
                return StepReport(newton, krylov, works, dissipated, residual)
            self._forget()
            failures.append(Failure(attempt, reason, iterations))
        place = describe_largest_residual(self.step, self.snes.getFunction()[0])
        raise StepFailure(
            f"the step from t = {state.time:.6g} s by {dt:.3g} s did not converge: {tell(failures)}"
            + (f"; the residual is largest in {place}" if place and reason <= 0 else "")
        )

    def _forget(self) -> None:
        """An attempt has failed: forget what it began with; raise what a force raised."""
        self._guess.forget()
        self.step.forget_tangents()
        self.step.raise_error()

    def _finish(self, attempt: Attempt, out: State) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Write the state at t_{n+1} and learn from the step; works and what dissipated [J]."""
        self._last = weakref.ref(out)
        self._attempts.learn(attempt)
        works, dissipated = self.step.finish(out)
        if not self.system.flexible_models or self._corrects(attempt):
            self._guess.learn(self.step.start.state.time, self.step.start.dt)
        return tuple(works.tolist()), tuple(dissipated.tolist())

    def _list_attempts(self, time: float, dt: float) -> list[tuple[Attempt, Array | None]]:
        """Attempts in order, and the rigid unknowns to start from, if known."""
        attempts: list[tuple[Attempt, Array | None]] = [(x, None) for x in self._attempts.order()]
        r = self._guess.extrapolate(time, dt)
        return attempts if r is None else [(attempts[0][0], r), *attempts]

    def _start_at(self, attempt: Attempt, r: Array | None) -> None:
        """Set X to the start of an attempt."""
        self.step.guess(attempt.moves_on, r)
        if self._corrects(attempt):
            self._guess.correct(self.step.start.state.time, self.step.start.dt)

    def _corrects(self, attempt: Attempt) -> bool:
        """Whether the guess of an attempt with flexible bodies is corrected.

        Exact tangents of bodies on meshes mostly end digits below the tolerance. From a better
        guess they would end near it, which their energy balance would show. Tangents of small
        bodies take the stress as it is expected, which the guess does not change.
        """
        models = self.system.flexible_models
        approximate = isinstance(self._solvers.use(attempt.solver), QuasiNewton)
        return attempt.moves_on and bool(models) and (approximate or self._is_exact)

    def _log_fallback(
        self, time: float, dt: float, failures: list[Failure], attempt: Attempt
    ) -> None:
        """Say which attempt takes over, if one has failed."""
        if failures:
            log.info(
                "the step from t = %.6g s by %.3g s: %s with %s; now %s",
                time,
                dt,
                failures[-1].cause,
                failures[-1].attempt,
                "with a new factor" if failures[-1].attempt == attempt else attempt,
            )

    def save(self) -> RestartData:
        """Data that later steps depend on, apart from the state."""
        data = RestartData({"name": self.linear_solver, "fallbacks": self.fallbacks})
        data.add("attempts", self._attempts.save())
        data.add("linear", self._solvers.use(self.linear_solver).save())
        data.add("guess", self._guess.save())
        data.add("bodies", self.step.save())
        for name, loads in self.system.section_loads.items():
            data.add(f"loads.{name}", loads.save())
        return data

    def restore(self, data: RestartData) -> None:
        """Restore a saved solver; with another linear solver, start from scratch."""
        self.fallbacks = data.numbers.get("fallbacks", 0)
        if data.numbers.get("name") == self.linear_solver:
            self._attempts.restore(data.part("attempts"))
            self._solvers.use(self.linear_solver).restore(data.part("linear"))
        self._guess.restore(data.part("guess"))
        self.step.restore(data.part("bodies"))  # last, as a new factor begins steps
        for name, loads in self.system.section_loads.items():
            loads.restore(data.part(f"loads.{name}"))


def _destroy(linear_solvers: _LinearSolvers, snes: PETSc.SNES) -> None:
    """Free the PETSc objects of a solver."""
    linear_solvers.destroy()
    snes.destroy()


def evaluate_residual(snes: PETSc.SNES, x: PETSc.Vec, F: PETSc.Vec, step: NestedStep) -> None:
    """SNES function: residual of the step."""
    with timing.event("residual"):
        step.residual(x, F)


def evaluate_tangent(
    snes: PETSc.SNES,
    x: PETSc.Vec,
    J: PETSc.Mat,
    P: PETSc.Mat,
    linear_solvers: _LinearSolvers,
    convergence: BlockwiseConvergence | None,
) -> None:
    """SNES Jacobian: the linear solver is prepared for the tangent at x.

    With the convergence of small bodies the last one, turned, serves as long as that is worth it.
    """
    with timing.event("linear set-up"):
        keeps = convergence is not None and convergence.keeps_tangent
        if not (keeps and linear_solvers.current.turn(x)):
            linear_solvers.current.update(x)


class _LinearSolvers:
    """The linear solvers of a step by name, made when first used; PETSc's python preconditioner."""

    def __init__(self, step: NestedStep, prefix: str) -> None:
        """Nothing is made yet: what comes before the first step may need the memory."""
        self._step, self._prefix = step, prefix
        self._made: dict[str, LinearSolver] = {}
        self.current: LinearSolver

    def use(self, name: str) -> LinearSolver:
        """Switch to a linear solver."""
        if name not in self._made:
            self._made[name] = LINEAR_SOLVERS[name](self._step, self._prefix)
        self.current = self._made[name]
        return self.current

    def apply(self, pc: PETSc.PC, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""
        with timing.event("linear solve"):
            self.current.solve(b, x)

    def destroy(self, pc: PETSc.PC | None = None) -> None:
        """Free all PETSc objects; PETSc calls this too."""
        for linear_solver in self._made.values():
            linear_solver.destroy()
        self._made.clear()

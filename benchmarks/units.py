"""A hybrid step in units of its two unavoidable operations: a residual and a triangular solve.

Usage: units.py PROBLEM RESULT (written by run.py); or units.py SIZE for one line on the screen.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import ours
from problem import Problem, parse_size, prepare

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.linear_solvers.symmetric import SymmetricFactor
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.time_stepping.solver_options import SolverOptions


def shortest(function, clock=time.perf_counter, repeat=15):
    """Seconds of the fastest of several calls, by a clock."""
    times = []
    for _ in range(repeat):
        start = clock()
        function()
        times.append(clock() - start)
    return min(times)


def measure_units(problem):
    """Seconds of a step, a residual assembly and a solve, and their ratio."""
    system = ours.build(problem, "hybrid", MPI.COMM_SELF)
    solver = EnergyMomentum(system, options=SolverOptions(tolerance=problem.tolerance))
    state = system.initial_state()
    spare, steps = state.copy(), []
    for _ in range(problem.steps):
        start = time.perf_counter()
        solver.advance(state, problem.dt, spare)
        steps.append(time.perf_counter() - start)
        state, spare = spare, state

    residual, solve = measure_operations(system, problem.dt)
    solver.destroy()
    step = float(np.mean(steps[problem.warm_up :]))
    unit = residual + solve
    return {"step": step, "residual": residual, "solve": solve, "ratio": step / unit}


def measure_operations(system, dt, clock=time.perf_counter):
    """Seconds of a residual of the flexible body and of a solve with the factor of its free nodes.

    Args:
        system: A system with one flexible body in its initial state.
        dt: Time step [s].
        clock: Returns the time [s].
    """
    (block,) = system.flexible_models
    state, du, R = system.initial_state(), block.new_vector(), block.new_vector()
    body = FlexibleStep(block)
    body.start_step(state.u[0], state.v[0], StepTimes.from_start(0.0, dt), np.zeros(3))
    residual = shortest(lambda: body.residual(du, R), clock)
    body.assemble_tangent(du)
    held = np.concatenate([coupling.dofs for coupling in system.coupling_blocks])
    body.tangent.zeroRowsColumns(np.unique(held).astype(PETSc.IntType), 1.0)
    factor = SymmetricFactor(body.tangent, "tfx_free_")
    factor.update()
    solve = shortest(lambda: factor.solve(R, du), clock)
    factor.destroy()
    return residual, solve


def main():
    if len(sys.argv) == 3:
        result = measure_units(Problem.load(sys.argv[1]))
        Path(sys.argv[2]).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        return
    with tempfile.TemporaryDirectory() as folder:
        path = prepare(Path(folder), parse_size(sys.argv[1]))
        result = measure_units(Problem.load(str(path)))
    print(
        f"step {result['step']:.3f} s = {result['ratio']:.1f} x (residual "
        f"{result['residual']:.4f} s + solve {result['solve']:.4f} s)"
    )


if __name__ == "__main__":
    main()

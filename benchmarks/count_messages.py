"""What each rank sends in a step, and what it holds; `ranks.py` starts it.

Usage: count_messages.py PROBLEM RESULT under mpirun, the counter preloaded. Whole steps are
counted after the warm-up, without the balance of energy.
"""

from __future__ import annotations

import ctypes
import json
from pathlib import Path

from mpi4py import MPI

import measure
import numpy as np
import ours

from turbine_fenicsx.linear_solvers.substructures import find_shared_nodes
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

KINDS = ("messages", "message_bytes", "collectives", "collective_bytes")


def find_counters():
    """The numbers of `count_messages.c`, shape (4,); they change with each call of MPI.

    Raises:
        RuntimeError: if it does not see what mpi4py calls.
    """
    counts = np.ctypeslib.as_array((ctypes.c_longlong * 4).in_dll(ctypes.CDLL(None), "tfx_counts"))
    before, comm = counts.copy(), MPI.COMM_WORLD
    total = np.zeros(2)
    comm.Allreduce(np.ones(2), total)
    request = comm.Isend(np.ones(3), (comm.rank + 1) % comm.size)
    comm.Recv(np.zeros(3))
    request.Wait()
    found = (counts - before).tolist()
    if found != [1, 24, 1, 16]:
        raise RuntimeError(f"the counter does not work with this MPI: 1, 24, 1, 16 became {found}")
    return counts


def main():
    problem, args = measure.arguments(linear_solver="frozen")
    comm, counts = MPI.COMM_WORLD, find_counters()
    system = ours.build(problem, "hybrid", comm)
    solver = EnergyMomentum(system, options=SolverOptions(args.linear_solver, problem.tolerance))
    state = system.initial_state()
    spare = state.copy()
    steps, reports = [], []
    for _ in range(problem.steps):
        before = counts.copy()
        reports.append(solver.advance(state, problem.dt, spare))
        steps.append(counts - before)
        state, spare = spare, state
    tips = ours.tip_displacements(system, state, problem.tip_points)
    (flexible,) = system.flexible_models
    ghosts = 3 * flexible.space.dofmap.index_map.num_ghosts
    interface = 3 * int(np.count_nonzero(find_shared_nodes(flexible)))
    holds = [3 * flexible.n_owned, ghosts, interface, measure.peak_memory()]
    rows = comm.gather([*np.mean(steps[problem.warm_up :], axis=0).tolist(), *holds])
    names = (*KINDS, "owned", "ghosts", "interface", "memory")
    if comm.rank == 0:
        result = {
            "unknowns": problem.unknowns,
            "ranks": comm.size,
            "solver": args.linear_solver,
            "iterations": [r.newton_iterations for r in reports],
            "krylov": [r.krylov_iterations for r in reports],
            "tips": tips.tolist(),
            "of_rank": dict(zip(names, zip(*rows, strict=True), strict=True)),
        }
        Path(args.result).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    solver.destroy()


if __name__ == "__main__":
    main()

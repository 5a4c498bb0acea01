"""Twelve modes of the turbine in units of one factorisation and of solves with the factor.

Usage: modes.py SIZE, for example 70k, for two lines on the screen. Times are of the processor, so
that they mean something beside other programs; the clock is not looked at. Both assembly of the
matrices and the check of the equilibrium count among the modes.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from mpi4py import MPI

import measure
import ours
from problem import Problem, parse_size, prepare

from turbine_fenicsx import modes
from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.squared_frequencies import soft_shift

COUNT = 12


def seconds(function, repeat=1):
    """Processor time of a call, the least of several."""
    times = []
    for _ in range(repeat):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return min(times)


def measure_modes(problem):
    """Seconds of one factorisation, of one solve, and of twelve modes of the rotor at rest."""
    system = ours.build(problem, "hybrid", MPI.COMM_SELF)
    state = system.initial_state()
    system.gravity[:] = 0.0  # where nothing is deformed is then an equilibrium
    found = []
    whole = seconds(lambda: found.append(modes(system, state, COUNT)))
    memory = measure.peak_memory()

    linear = LinearSystem(system, state)
    shift = soft_shift(linear)
    for K, M in zip(blocks_of(linear.stiffness), blocks_of(linear.mass), strict=True):
        K.axpy(shift, M)
    solver = linear.solver(linear.stiffness, "modes_")
    factorisation = seconds(solver.factorise)
    b, y = linear.vectors.new_vector(), linear.vectors.new_vector()
    b.set(1.0)
    solve = seconds(lambda: solver.solve(b, y), 15)
    solver.destroy()
    linear.destroy()
    frequencies = [m.frequency for m in found[0].modes]
    return whole, factorisation, solve, memory, frequencies


def main():
    with tempfile.TemporaryDirectory() as folder:
        problem = Problem.load(str(prepare(Path(folder), parse_size(sys.argv[1]))))
        whole, factorisation, solve, memory, frequencies = measure_modes(problem)
    units = (whole - factorisation) / solve
    print(
        f"{problem.unknowns} unknowns: {COUNT} modes {whole:.2f} s = factorisation "
        f"{factorisation:.2f} s + {units:.0f} x solve {solve:.4f} s, {memory:.0f} MB\n"
        f"frequencies {', '.join(f'{f:.4f}' for f in frequencies)} Hz"
    )


if __name__ == "__main__":
    main()

"""Hollow blades: the IEA 22 MW rotor in quadratic hexahedra of 27 nodes, one through the wall.

Usage: hollow.py [--span N] [--around N] [--steps N] [CODE ...]; prints a table.

``rotor`` is the whole rotor with its laminates, which turns at rated speed under gravity from its
turning start, ``rotor-wind`` the same in sheared wind of 10.5 m/s; ``rotor-lu`` makes a new factor
in each iteration. The others solve for the same mesh with clamped roots and isotropic walls,
gravity switched on at t = 0: ``clamped`` and ``clamped-lu`` are this package, ``fenicsx-...`` the
methods of `fenicsx_newton`, ``calculix`` has 20 of the 27 nodes and reduced integration (C3D20R).
Each is a child process of one thread. Seconds are those of the processor, so that other programs
hardly matter.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import process_time

from mpi4py import MPI

import fenicsx_newton
import measure
import numpy as np
import ours
import units
from competitors import HERE, run
from problem import Problem

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.meshing.rotor import write_msh
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.start import make_start

FILE, SPEED = "IEA-22-280-RWT.yaml", "7.061 rpm"
DT, TOLERANCE, DISSIPATION = 0.01, 1e-8, 0.1
WIND = {
    "wind": {"speed": "10.5 m/s", "shear": 0.12},
    "aero": {"stations": 12},
    "generator": {"keeps": "speed"},
}
"""Just below rated, so that blades need no pitch. Without a generator the rotor would be let go
with its whole torque at t = 0, and thin walls would shake."""
APART = {"calculix": 0.15}
"""How far tips may lie apart with other elements, over the largest deflection; else 1e-3. On coarse
meshes C3D20R is stiffer than cells of 27 nodes: by 12 % with 12 by 20 of them."""
WALL = {"material": "stiff", "density": 1800.0}
CODES = (
    *("rotor", "rotor-wind", "rotor-lu", "clamped", "clamped-lu"),
    *("fenicsx-lagged", "fenicsx-lu", "calculix"),
)
SERENDIPITY = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]
"""C3D20R's nodes among gmsh's 27: corners, edges of the first face, of the last, between them."""


def parse(span, around, **more):
    """The case, with other tables if there are any."""
    return Case.parse(
        {
            "time": {"step": DT, "start": "turning"},
            "turbine": {"file": FILE, "rotor_speed": SPEED, "numerical_dissipation": DISSIPATION},
            "tower": {"flexible": False},
            "mesh": {"span": span, "around": around},
            "blade": {"damping": 0},
            "yaw": {"drive": "free"},
            "solver": {"tolerance": TOLERANCE},
            **more,
        }
    )


def write_problem(span, around, steps, folder):
    """The mesh, and what the codes with clamped blades solve; returns the file of the problem."""
    plan = plan_rotor(parse(span, around))
    _, make = plan.mesh_source()
    mesh, msh = make(), folder / "hollow.msh"
    write_msh(mesh, msh)
    arrays = write_serendipity(mesh, plan.tips, folder / "hollow.npz")
    problem = Problem(
        (span, around, 1),
        steps=steps,
        dt=DT,
        tolerance=TOLERANCE,
        msh=str(msh),
        arrays=arrays,
        degree=2,
        nodes=len(mesh.points),
        tips=[[float(x) for x in tip] for tip in plan.tips],
        **WALL,
    )
    return problem.write(folder / "hollow.json")


def write_serendipity(mesh, tips, path):
    """The mesh without nodes in the middle of faces and cells, as `Problem.arrays`."""
    used, cells = np.unique(mesh.cells[:, SERENDIPITY], return_inverse=True)
    roots = np.isin(mesh.facet_groups, [mesh.surfaces[root] for root in ROOTS])
    points = mesh.points[used]
    np.savez(
        path,
        points=points,
        hexahedra=cells.reshape(-1, len(SERENDIPITY)),
        clamped=np.flatnonzero(np.isin(used, mesh.facets[roots])),
        tips=[np.argmin(np.linalg.norm(points - tip, axis=1)) for tip in tips],
    )
    return str(path)


def advance(system, solver, state, problem):
    """Take the steps with this package; returns the state after the last, and what was found."""
    spare, times, iterations = state.copy(), [], []
    for _ in range(problem.steps):
        start = process_time()
        iterations.append(solver.advance(state, problem.dt, spare).newton_iterations)
        times.append(process_time() - start)
        state, spare = spare, state
    found = summarise(problem, times, iterations) | {"fallbacks": solver.fallbacks}
    if solver.linear_solver == "frozen":  # its memory is known by now
        residual, solve = units.measure_operations(system, problem.dt, process_time)
        found["unit"] = residual + solve
    return state, found


def summarise(problem, times, iterations):
    """Means over the steps that count, and memory."""
    counted = slice(problem.warm_up, None)
    return {
        "step": float(np.mean(times[counted])),
        "iterations": float(np.mean(iterations[counted])),
        "memory": measure.peak_memory(),
    }


def solve_rotor(problem, method):
    """The laminated rotor that turns, without or with wind."""
    case = parse(*problem.elements[:2], **(WIND if method == "wind" else {}))
    system = build_turbine(case, MPI.COMM_SELF).system
    state = make_start(case, system)
    options = SolverOptions("lu" if method == "lu" else "frozen", problem.tolerance)
    solver = EnergyMomentum(system, numerical_dissipation=DISSIPATION, options=options)
    return advance(system, solver, state, problem)[1]


def solve_clamped(problem, linear_solver):
    """The clamped blades, with this package."""
    system = ours.build(problem, "clamped", MPI.COMM_SELF)
    options = SolverOptions(linear_solver or "frozen", problem.tolerance)
    solver = EnergyMomentum(system, options=options)
    state, found = advance(system, solver, system.initial_state(), problem)
    return found | {"tips": ours.tip_displacements(system, state, problem.tip_points).tolist()}


def solve_script(problem, method):
    """The clamped blades, with the FEniCSx script."""
    blades = fenicsx_newton.Blades(problem, MPI.COMM_SELF, fenicsx_newton.METHODS[method])
    times, iterations = [], []
    for _ in range(problem.steps):
        start = process_time()
        iterations.append(blades.step(problem.dt)[0])
        times.append(process_time() - start)
    found = summarise(problem, times, iterations)
    return found | {"tips": blades.tips(problem.tip_points).tolist()}


def solve_calculix(problem, _):
    """The clamped blades, with CalculiX."""
    folder = Path(problem.arrays).parent
    problem = replace(problem, tolerance=10.0 * problem.tolerance)  # its round-off is 1e-8
    path, result = problem.write(folder / "calculix.json"), folder / "calculix_found.json"
    options = [str(path), str(result), "--clock", "processor"]
    if error := run([sys.executable, str(HERE / "calculix.py"), *options], limit=1e6):
        raise RuntimeError(error)
    found = json.loads(result.read_text(encoding="utf-8"))
    summary = summarise(problem, found["steps"], found["iterations"])
    return summary | {name: found[name] for name in ("tips", "memory")}


SOLVERS = {
    "rotor": solve_rotor,
    "clamped": solve_clamped,
    "fenicsx": solve_script,
    "calculix": solve_calculix,
}


def solve(path, code, result):
    """What a child does."""
    kind, _, method = code.partition("-")
    found = SOLVERS[kind](Problem.load(path), method)
    Path(result).write_text(json.dumps(found), encoding="utf-8")


def line(code, record, problem):
    """A row of the table."""
    words = (
        code,
        f"{record['step']:.3g}",
        f"{record['step'] / problem.dt:.3g}",
        f"{record['iterations']:.1f}",
        str(record.get("fallbacks", "")),
        f"{record['step'] / record['unit']:.1f}" if "unit" in record else "",
        f"{record['memory'] / 1e3:.2f}",
    )
    return f"| {' | '.join(words)} |"


def agree(records):
    """Whether all clamped blades bend alike."""
    tips = {code: np.array(r["tips"]) for code, r in records.items() if "tips" in r}
    first = next(iter(tips.values()), np.zeros(3))
    return all(
        np.abs(t - first).max() <= APART.get(code, 1e-3) * np.abs(first).max()
        for code, t in tips.items()
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("codes", nargs="*", metavar="CODE", help=f"{', '.join(CODES)} (all)")
    parser.add_argument("--span", type=int, default=12, help="elements along the span (12)")
    parser.add_argument("--around", type=int, default=20, help="elements around a section (20)")
    parser.add_argument("--steps", type=int, default=12, help="the first 2 do not count (12)")
    parser.add_argument("--limit", type=float, default=7200.0, help="seconds a code may take")
    parser.add_argument("--child", nargs=2, metavar=("PROBLEM", "RESULT"), help=argparse.SUPPRESS)
    args = parser.parse_args()
    unknown = set(args.codes) - set(CODES)
    if unknown or args.steps < 3:
        parser.error(f"no such code: {min(unknown)}" if unknown else "--steps must be 3 or more")
    if args.child:
        solve(args.child[0], args.codes[0], args.child[1])
        return 0
    records = {}
    with tempfile.TemporaryDirectory() as folder:
        try:
            path = write_problem(args.span, args.around, args.steps, Path(folder))
        except (InputError, ModelError) as error:  # no file, or too few cells
            parser.error(str(error))
        problem, result = Problem.load(str(path)), Path(folder) / "child.json"
        print(f"{problem.unknowns} displacements, {args.span} x {args.around} cells in a shell\n")
        print("| code | s/step | s per simulated s | iterations | failed over | units | GB |")
        print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
        for code in args.codes or CODES:
            command = [sys.executable, __file__, code, "--child", str(path), str(result)]
            if error := run(command, args.limit):
                print(f"| {code} | failed: {error} | | | | | |", flush=True)
                continue
            records[code] = json.loads(result.read_text(encoding="utf-8"))
            print(line(code, records[code], problem), flush=True)
    if not agree(records):
        print("\ntips of the clamped blades disagree")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

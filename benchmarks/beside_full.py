"""Turbines with reduced blades beside the same ones with full blades, mesh by mesh.

``python benchmarks/beside_full.py turbulence [SPAN AROUND]`` runs 20 s of turbulence with a stop on
the IEA 15 MW turbine, by default with 12 by 16 cells. ``... steady`` starts the IEA 22 MW turbine
in equilibrium at 8, 10 and 15 m/s with 20 by 24 cells. Both print the largest differences. Full
blades take long: half an hour for the turbulence. Runs stay in ``benchmarks/out/beside_full``.
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import robust

FOLDER = robust.ROOT / "benchmarks" / "out" / "beside_full"
BOX = {**robust.BOX, "points": [256, 16, 16]}
OUTPUT = {"twists": [0.7, 0.9]}
FEATHER = {"kind": "shut_down", "time": "14 s", "pitch": "60 deg"}
TURBULENCE = {"wind.speed": "12 m/s", "wind.box": BOX, "time.end": "20 s", "time.step": "0.02 s"}
TURBULENCE |= {
    "pitch.initial": "0 deg",
    "event.stop": FEATHER,
    "output": OUTPUT,
    "solver.tolerance": 1e-8,
}
FULL = ["blade.model=full", "tower.model=full"]
COLUMNS = ("tip_deflection_1_[m]", "twist_1_at_0.7_[rad]", "twist_1_at_0.9_[rad]")
COLUMNS += ("root_moment_1_y_[Nm]", "root_moment_1_x_[Nm]", "aero_power_[W]")
SETTLED = 0.5
"""Time from which columns are compared [s]."""


def run(case, out, *changes):
    """Columns of a run, which is made if it is not there."""
    if not (out / "summary.json").is_file():
        command = [Path(sys.executable).with_name("turbine-fenicsx"), "run", case, "-o", out]
        command += ["--overwrite", "--set", *changes]
        with out.with_suffix(".log").open("w") as log:
            subprocess.run(command, check=True, stdout=log, stderr=log)
    with (out / "history.csv").open() as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


def compare(name, reduced, full, start):
    """Print the largest differences of columns after a time."""
    times = full["time_[s]"][full["time_[s]"] >= start]
    for column in COLUMNS:
        a, b = (np.interp(times, x["time_[s]"], x[column]) for x in (reduced, full))
        error, size = np.max(np.abs(a - b)), np.max(np.abs(b))
        print(f"| {name} | {column} | {size:.4g} | {error:.2g} | {100.0 * error / size:.2f} % |")


def turbulence(span="12", around="16"):
    """Twenty seconds of the IEA 15 MW turbine."""
    mesh = [f"mesh.span={span}", f"mesh.around={around}", f"aero.stations={int(span)}"]
    case = robust.write_case(f"turbulence-{span}", TURBULENCE)
    subprocess.run([sys.executable, robust.DEMO / "kaimal.py", case], check=True)
    found = [run(case, FOLDER / f"reduced-{span}", *mesh)]
    found.append(run(case, FOLDER / f"full-{span}", *mesh, *FULL))
    compare(f"{span} by {around}", *found, SETTLED)


def steady():
    """Equilibria of the IEA 22 MW turbine that turns in steady wind."""
    for speed, rpm, pitch in ((8, 5.6, 0), (10, 7.0, 0), (15, 7.0, 11)):
        changes = {"wind": {"speed": f"{speed} m/s", "shear": 0}, "output": OUTPUT}
        changes |= {"turbine.file": "IEA-22-280-RWT.yaml", "turbine.rotor_speed": f"{rpm} rpm"}
        changes |= {"pitch.initial": f"{pitch} deg", "time.end": "0.02 s", "time.step": "0.01 s"}
        case = robust.write_case(f"steady-{speed}", {**changes, "aero.stations": 26})
        found = [run(case, FOLDER / f"steady-{speed}-reduced", "blade.reduction.modes=6")]
        found.append(run(case, FOLDER / f"steady-{speed}-full", *FULL))
        compare(f"{speed} m/s", *found, 0.0)


def main():
    """One of both."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    robust.FOLDER = FOLDER
    print("| case | quantity | largest | difference | of it |\n" + 5 * "| --- " + "|")
    what, *more = sys.argv[1:]
    {"turbulence": turbulence, "steady": steady}[what](*more)


if __name__ == "__main__":
    main()

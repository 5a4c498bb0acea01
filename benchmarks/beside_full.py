"""Turbines with reduced blades beside the same ones with full blades, mesh by mesh.

``python benchmarks/beside_full.py turbulence [SPAN AROUND]`` runs 20 s of turbulence with a stop on
the IEA 15 MW turbine, by default with 12 by 16 cells. ``... steady`` starts the IEA 22 MW turbine
in equilibrium at 8, 10 and 15 m/s with 20 by 24 cells. Both print the largest differences. Full
blades take long: half an hour for the turbulence. ``... plies [SPAN AROUND [FUNCTIONS STRAINS]]``
sends a gust of two seconds through the IEA 15 MW turbine and compares the failure of its plies,
panel by panel, with that recovered of the reduced blades. Runs stay in
``benchmarks/out/beside_full``.
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import robust

FOLDER = robust.ROOT / "benchmarks" / "out" / "beside_full"
OUTPUT = {"twists": [0.7, 0.9]}
FEATHER = {"kind": "shut_down", "time": "14 s", "pitch": "60 deg"}
TURBULENCE = {"wind.speed": "12 m/s", "time.end": "20 s", "time.step": "0.02 s"}
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
    return read(out / "history.csv")


def read(path):
    """Columns of a file."""
    with path.open() as file:
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
    found = [run(case, FOLDER / f"reduced-{span}", *mesh)]
    found.append(run(case, FOLDER / f"full-{span}", *mesh, *FULL))
    compare(f"{span} by {around}", *found, SETTLED)


GUST = {"wind": {"file": "gust.csv", "shear": 0.14}, "time.end": "2 s", "time.step": "0.02 s"}
SPEEDS = "time [s],speed [m/s]\n0,10.6\n0.3,10.6\n1.3,15\n2,11\n"
GUST |= {"pitch.initial": "0 deg", "solver.tolerance": 1e-8, "output.motion_every": "0.02 s"}


def plies(span="12", around="16", functions="66", strains="25"):
    """Failure of plies in a gust of two seconds."""
    basis = [f"blade.reduction.functions={functions}", f"blade.reduction.strains={strains}"]
    mesh = [f"mesh.span={span}", f"mesh.around={around}", f"aero.stations={int(span)}"]
    (FOLDER / "gust.csv").write_text(SPEEDS)
    case = robust.write_case(f"plies-{span}", GUST)
    folder = FOLDER / f"plies-{span}-{functions}-{strains}"
    run(case, folder, *mesh, *basis)
    recover = [Path(sys.executable).with_name("turbine-fenicsx"), "recover", folder, "--overwrite"]
    subprocess.run([*recover, "--plies", "--quiet"], check=True)
    full = run(case, FOLDER / f"plies-{span}-full", *mesh, *FULL, "output.fields_every=0")
    reduced = read(folder / "plies.csv")
    times = reduced["time_[s]"]
    end = "_tsai_wu_[-]"
    for column in (name for name in reduced if name.endswith(end)):
        panel = column.removesuffix(end)
        found = []
        for columns in (reduced, full):
            index = np.interp(times, columns["time_[s]"], columns[column])
            k = int(np.argmax(index))
            at = np.argmin(np.abs(columns["time_[s]"] - times[k]))
            found.append((index, columns[f"{panel}_tsai_wu_at_[m]"][at]))
        (a, mine), (b, theirs) = found
        error, rms = np.max(np.abs(a - b)), np.sqrt(np.mean((a - b) ** 2))
        shares = [f"{100.0 * x / np.max(b):.2f} %" for x in (np.max(a) - np.max(b), error, rms)]
        print(f"| {panel} | {np.max(b):.4g} | {' | '.join(shares)} | {theirs:.4g} | {mine:.4g} |")


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
    """One of them."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    robust.FOLDER = FOLDER
    what, *more = sys.argv[1:]
    head = ["case", "quantity", "largest", "difference", "of it"]
    if what == "plies":
        head = ["panel", "largest", "its error", "largest error", "rms", "place [m]", "reduced [m]"]
    print("| " + " | ".join(head) + " |\n" + len(head) * "| --- " + "|", flush=True)
    {"turbulence": turbulence, "steady": steady, "plies": plies}[what](*more)


if __name__ == "__main__":
    main()

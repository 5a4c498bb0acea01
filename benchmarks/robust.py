"""Reduced blades where full ones are hard to step: seven cases of the IEA 15 MW turbine, 30 s each.

``python benchmarks/robust.py [NAME ...]`` runs turbulence of class A at cut-out, an extreme gust
with the loss of the grid and a stop, storms of 50 m/s from 0, 30 and 90 degrees, idling, and a
blade whose pitch seizes before a stop. It prints iterations, halved steps, loads, and the error of
the energy. The basis is made once, in ``benchmarks/out/robust``.
"""

import csv
import json
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "benchmarks" / "out" / "robust"
DEMO = ROOT / "demos" / "turbulence"
STOP = {"kind": "emergency_stop", "pitch": "88 deg", "rate": "6 deg/s"}
STILL = {"control.kind": "none", "pitch.bearings": True, "turbine.rotor_speed": 0}
STILL |= {"pitch.drive": "prescribed", "pitch.initial": "88 deg", "time.start": "equilibrium"}
CASES = {
    "turbulence": {"wind.speed": "25 m/s", "wind.turbine_class": "IA", "pitch.initial": "22 deg"},
    "gust": {
        "wind": {"speed": "11 m/s", "shear": 0.14, "gust": "EOG", "gust_start": "2 s"},
        "event.grid": {"kind": "grid_loss", "time": "7 s"},
        "event.stop": {**STOP, "time": "7.5 s"},
    },
    **{
        f"storm-{angle}": {**STILL, "wind": {"speed": "50 m/s", "direction": f"{angle} deg"}}
        for angle in (0, 30, 90)
    },
    "idling": {**STILL, "wind": {"speed": "18 m/s", "shear": 0.14}, "pitch.initial": "60 deg"},
    "seizure": {
        "wind": {"speed": "16 m/s", "shear": 0.14},
        "pitch.initial": "12 deg",
        "event.fault": {"kind": "pitch_fault", "blade": 1, "time": "5 s"},
        "event.stop": {**STOP, "time": "8 s"},
    },
}


def write_toml(table, name, lines):
    """Add a table to the lines of a file."""
    lines.append(f"[{name}]" if name else "")
    lines += [f"{k} = {json.dumps(v)}" for k, v in table.items() if not isinstance(v, dict)]
    for key, value in table.items():
        if isinstance(value, dict):
            write_toml(value, f"{name}.{key}" if name else key, lines)


def write_case(name, changes):
    """The demo with other values, in the folder that has the basis."""
    case = tomllib.loads((DEMO / "turbulence.toml").read_text())
    case["time"]["end"] = "30 s"
    for key, value in changes.items():
        *tables, last = key.split(".")
        table = case
        for part in tables:
            table = table.setdefault(part, {})
        table[last] = value
    lines = []
    write_toml(case, "", lines)
    path = FOLDER / f"{name}.toml"
    path.write_text("\n".join(lines))
    return path


def run(name):
    """Run a case, and print a line of a table."""
    case, out = write_case(name, CASES[name]), FOLDER / name
    command = [Path(sys.executable).with_name("turbine-fenicsx"), "run", case, "-o", out]
    with (FOLDER / f"{name}.log").open("w") as log:
        subprocess.run([*command, "--overwrite"], check=True, stdout=log, stderr=log)
    with (out / "history.csv").open() as file:
        head, *rows = csv.reader(file)
    columns = dict(zip(head, np.array(rows, dtype=float).T, strict=True))
    summary = json.loads((out / "summary.json").read_text())
    n = columns["newton_iterations"][1:]
    flap = np.max(np.abs([columns[f"root_moment_{k}_y_[Nm]"] for k in (1, 2, 3)]))
    energy = summary["worst_energy_error_[J]"] / summary["largest_energy_[J]"]
    halved = summary["halved_steps"]
    print(
        f"| {name} | {np.mean(n):.2f} | {np.max(n):.0f} | {halved} | {1e-6 * flap:.1f} | "
        f"{np.max(columns['rotor_speed_[rpm]']):.2f} | {energy:.0e} |",
        flush=True,
    )


def main():
    """Run the cases that are named, or all."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    print(
        "| case | iterations | most | halved | flap [MN m] | rpm | energy |\n" + 7 * "| --- " + "|"
    )
    for name in sys.argv[1:] or CASES:
        run(name)


if __name__ == "__main__":
    main()

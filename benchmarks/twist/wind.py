"""The rotor of the IEA 22 MW turbine in steady wind, with beams and solids, beside other codes.

Usage: wind.py [--wind WINDS] [--only NAME ...]

Without tilt and weight, at the speed and pitch of HAWC2. Steady states stay in out/wind; those of
a folder that is there are not found again. Names are

- "beams": matrices of the file; "beams with the term": the same and what inclined walls add;
- "prisms" and "inclined": beams of sections of the layup, by `turbine-fenicsx sections`;
- "reduced solids" and "solids": the layup as hollow solids.
"""

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from blades import HERE, OUT

WINDS = "4:24:2"
SLOW = "8,14,20"
"""Winds of full solids, which take minutes each."""

FOLDER = OUT / "wind"
CASE = FOLDER / "iea22_wind.toml"
SECTIONS = FOLDER / "sections"
LAMINATE = "blade.layup=laminate"
KINDS = {
    "beams": (),
    "beams with the term": ("blade.beam.taper=true",),
    "prisms": (f"blade.beam.file={SECTIONS}/prisms/beamdyn.dat",),
    "inclined": (f"blade.beam.file={SECTIONS}/inclined/beamdyn.dat",),
    "reduced solids": ("blade.model=reduced", LAMINATE, "mesh.around=24"),
    "solids": ("blade.model=full", LAMINATE),
}
COLUMNS = {
    "power [MW]": ("aero_power_[W]", "mechanical_power_W", 1e6),
    "thrust [MN]": ("aero_thrust_[N]", "thrust_N", 1e6),
    "root moment [MN m]": ("root_moment_y_[Nm]", "root_My_Nm", 1e6),
}
SHOWN = (0.5, 0.7, 0.9)


def run(*arguments):
    """Call the command, which shows its progress."""
    command = Path(sys.executable).with_name("turbine-fenicsx")
    subprocess.run([command, *map(str, arguments)], check=True)


def write_schedule(published):
    """Speed and pitch of HAWC2 as a table."""
    path = FOLDER / "schedule.csv"
    rows = [["wind_speed_[m/s]", "rotor_speed_[rpm]", "pitch_[deg]"]]
    for wind, codes in published["cases"].items():
        rows.append([wind, codes["HAWC2"]["rotor_speed_rpm"], codes["HAWC2"]["pitch_deg"]])
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    return path


def find(name, winds, schedule):
    """Columns of the steady states of a kind of blade, and its twist at the stations shown [deg].

    Returns:
        Wind speeds, columns by name, and twist of shape (winds, stations).
    """
    folder = FOLDER / name.replace(" ", "_")
    if not (folder / "steady.csv").is_file():
        changes = ("--set", *KINDS[name]) if KINDS[name] else ()
        winds = SLOW if name == "solids" else winds
        run("steady", CASE, "--wind", winds, "--schedule", schedule, "-o", folder, *changes)
    return read(folder)


def read(folder):
    """The same of a folder with steady states."""
    whole, blade = (_columns(folder / f"{name}.csv") for name in ("steady", "steady_blade"))
    winds = whole["wind_speed_[m/s]"]
    twist = []
    for wind in winds:
        at = blade["wind_speed_[m/s]"] == wind
        twist.append(np.interp(SHOWN, blade["span_[-]"][at], blade["rotation_z_[deg]"][at]))
    return winds, whole, np.array(twist)


def _columns(path):
    with path.open() as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


def published_by(code, published):
    """The same of a code: winds, columns by the same names, twist."""
    cases = published["cases"]
    rows = [case[code] for case in cases.values()]
    whole = {own: np.array([row[key] for row in rows]) for own, key, _ in COLUMNS.values()}
    whole["tip_deflection_x_[m]"] = np.array(
        [row["blade_translation_deflection_x_pitching"][-1] for row in rows]
    )
    span = published["span_fractions"]
    twist = [np.interp(SHOWN, span, row["blade_rotation_deflection_z_pitching"]) for row in rows]
    return np.array(list(cases), dtype=float), whole, np.array(twist)


def gather(winds=WINDS, only=tuple(KINDS)):
    """All kinds and codes by name."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    shutil.copy(HERE / CASE.name, CASE)  # its folder gets the basis of reduced blades
    published = json.loads((HERE / "iea22_published.json").read_text())
    if not SECTIONS.is_dir():
        run("sections", CASE, "-o", SECTIONS, "--stations", 70, "--set", LAMINATE)
    schedule = write_schedule(published)
    found = {code: published_by(code, published) for code in ("HAWC2", "OpenFAST")}
    return found | {name: find(name, winds, schedule) for name in only}


def main():
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--wind", default=WINDS, metavar="WINDS")
    parser.add_argument("--only", nargs="+", default=tuple(KINDS), metavar="NAME")
    options = parser.parse_args()
    found = gather(options.wind, options.only)
    head = ["wind [m/s]", "", *COLUMNS, "tip [m]", f"twist at {SHOWN} [deg]"]
    print("| " + " | ".join(head) + " |\n" + "| --- " * len(head) + "|")
    for wind in sorted({w for winds, *_ in found.values() for w in winds}):
        for name, (winds, whole, twist) in found.items():
            for k in np.flatnonzero(winds == wind):
                values = [f"{whole[key][k] / size:.3f}" for key, _, size in COLUMNS.values()]
                values.append(f"{whole['tip_deflection_x_[m]'][k]:.2f}")
                values.append(", ".join(f"{v:.2f}" for v in twist[k]))
                print(f"| {wind:g} | {name} | " + " | ".join(values) + " |")


if __name__ == "__main__":
    main()

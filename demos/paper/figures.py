"""Figures 7 to 21 of the paper, drawn from our runs.

    python demos/paper/figures.py -o docs/images/paper

runs the three cases beside this file, which takes a minute, and draws one PNG a figure: diagrams
from the time series, pictures at 0, 5, 9 and 12 s from the fields.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from diagrams import HAMILTONIAN, MOMENTA, ROTOR, STRAIN, YAW, changes, curves, torque

from turbine_fenicsx import Hat
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.pictures import Look, find_nearest_step, render_times
from turbine_fenicsx.postprocessing.plots import draw
from turbine_fenicsx.records.output_folder import (
    make_target_folder,
    read_field_times,
    read_history,
    read_tables,
)

HERE = Path(__file__).parent
CASES = ("rigid", "hybrid_stiff", "hybrid_soft")
SIZE, HEIGHT = (1080, 1200), 800
"""Width and height of a picture as drawn, and the height it is made smaller to, in pixels."""

ENERGY_STEPS = changes("Change per step", r"$|\Delta H|$ [kJ]", HAMILTONIAN)
MOMENTUM = curves("Angular momentum", "about the origin [kNms]", *MOMENTA.values())
ANGLES = (curves("Nacelle", r"$\Theta_1$ [rad]", YAW), curves("Hub", r"$\Theta_2$ [rad]", ROTOR))


def energies(*quantities):
    """Panels of energies and of the changes of the Hamiltonian."""
    return curves("Energy", "energy [kJ]", *quantities), ENERGY_STEPS


def momenta(*components):
    """Panels of the angular momentum and of the changes of some components."""
    steps = changes("Change per step", r"$|\Delta L_i|$ [kNms]", *(MOMENTA[i] for i in components))
    return MOMENTUM, steps


DIAGRAMS = {
    "rigid": {8: energies(HAMILTONIAN), 9: momenta(1, 2, 3)},
    "hybrid_stiff": {12: energies(HAMILTONIAN, STRAIN), 13: momenta(2), 14: ANGLES},
    "hybrid_soft": {17: energies(HAMILTONIAN, STRAIN), 18: momenta(2, 3), 19: ANGLES},
}
PICTURES = {"rigid": (10, 11), "hybrid_stiff": (15, 16), "hybrid_soft": (20, 21)}
"""Two figures of two times each."""


def run(case, folder, changed):
    """Run a case of this folder; where it fails, end with its exit code."""
    command = [sys.executable, "-m", "turbine_fenicsx", "run", str(HERE / f"{case}.toml")]
    command += ["-o", str(folder)]
    if changed:
        command += ["--set", *changed]
    code = subprocess.run(command).returncode
    if code:
        sys.exit(code)


def draw_diagrams(case, folder, out):
    """Diagrams of a run.

    Args:
        case: Name of the case.
        folder: Its output folder.
        out: Where to write.

    Returns:
        The files.
    """
    history = read_history(folder / "history.csv")
    panels = dict(DIAGRAMS[case])
    if case == "rigid":
        loads = (read_tables(folder / "case.json") or {})["loads"]
        panels[7] = (torque(Hat(loads["rotor_torque"], loads["duration"])),)
    files = []
    for number, shown in sorted(panels.items()):
        files += draw([history], shown, [out / f"fig{number:02d}.png"])
    return files


def draw_pictures(case, folder, out, times):
    """Pictures of a run, all on one scale of colours, two times in each.

    Args:
        case: Name of the case.
        folder: Its output folder.
        out: Where to write.
        times: Four times [s].

    Returns:
        The files.

    Raises:
        InputError: if a time is outside of the run or the fields were written too rarely.
    """
    look = Look(scalar=None if case == "rigid" else "cauchy_stress_norm", size=SIZE)
    files = []
    fields = folder / "fields.xdmf"
    written = read_field_times(fields)
    if len({find_nearest_step(written, time) for time in times}) < len(times):
        shown = ", ".join(f"{time:g}" for time in times)
        raise InputError(f"two of the times {shown} s are nearest to the same output of {fields}")
    with tempfile.TemporaryDirectory() as drawn:
        singles = render_times(fields, drawn, times, look)
        for number, pair in zip(PICTURES[case], (singles[:2], singles[2:]), strict=True):
            files.append(out / f"fig{number:02d}.png")
            beside(pair).save(files[-1], optimize=True)
    return files


def beside(paths):
    """Pictures side by side in `HEIGHT`."""
    from PIL import Image

    images = [Image.open(path).convert("RGB") for path in paths]
    images = [i.resize((round(i.width * HEIGHT / i.height), HEIGHT), Image.LANCZOS) for i in images]
    whole = Image.new("RGB", (sum(i.width for i in images), HEIGHT), "white")
    x = 0
    for image in images:
        whole.paste(image, (x, 0))
        x += image.width
    return whole


def arguments():
    """The parser of the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "-o", "--out", default="out/paper", help="folder of the figures; default: out/paper"
    )
    parser.add_argument(
        "--runs",
        metavar="FOLDER",
        help=f"output folders {', '.join(CASES)}: those that are there are taken as they are, "
        "the others are made; default: run all and keep nothing",
    )
    parser.add_argument(
        "--set", nargs="+", default=[], metavar="KEY=VALUE", help="change keys of the cases run"
    )
    parser.add_argument(
        "--times",
        nargs=4,
        type=float,
        default=(0.0, 5.0, 9.0, 12.0),
        metavar="T",
        help="times of the four pictures [s]; default: 0 5 9 12",
    )
    return parser


def main():
    """Run what is missing and draw; exit code 2 for wrong input."""
    parser = arguments()
    options = parser.parse_args()
    try:
        out = make_target_folder(options.out)
        with tempfile.TemporaryDirectory() as nowhere:
            for case in CASES:
                folder = Path(options.runs or nowhere) / case
                if not (folder / "summary.json").exists():
                    run(case, folder, options.set)
                files = draw_diagrams(case, folder, out)
                files += draw_pictures(case, folder, out, options.times)
                print(*files, sep="\n", flush=True)
    except (InputError, ImportError) as problem:
        parser.exit(2, f"error: {problem}\n")


if __name__ == "__main__":
    main()

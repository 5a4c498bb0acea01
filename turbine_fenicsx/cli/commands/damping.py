"""Find the damping of one mode in steady wind three ways, and who damps it.

The eigenvalue of the linear equations stands beside the decay of a run that is kicked along the
mode, with what the time steps do and without, and beside the work of air and structure. With -o,
the tables go to damping.csv, decay.csv and work.csv, and a picture to damping.png.
"""

from __future__ import annotations

import argparse
import re
import sys
from math import isfinite, pi
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    NOT_CONVERGED,
    OK,
    add_case,
    fail,
    load_case,
    need_dolfinx,
)
from turbine_fenicsx.cli.commands.modes import add_lock, parse_amplitude
from turbine_fenicsx.cli.commands.steady import parse_winds
from turbine_fenicsx.foundation.errors import InputError

LARGEST_KICK, MOST_CYCLES = 10.0, 1000.0
"""Largest kick [m/s], and largest number of vibrations."""

_KICK = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*m/s", re.ASCII)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("--wind", metavar="WIND", required=True, help="wind speed in m/s")
    parser.add_argument(
        "--mode",
        metavar="MODE",
        required=True,
        help="the mode: its number or its name, as modes --wind shows them",
    )
    parser.add_argument(
        "--kick",
        metavar="SPEED",
        help='largest velocity that the kick gives a section of the blades; default: "0.1 m/s"',
    )
    parser.add_argument(
        "--cycles", metavar="N", type=float, help="vibrations of the run, at most; default: 8"
    )
    parser.add_argument("--count", metavar="N", type=int, help="number of modes; default: 12")
    parser.add_argument(
        "--schedule", metavar="FILE", help="speed and pitch over the wind, as of the command modes"
    )
    parser.add_argument("--keep-power", action="store_true", help="as of the command modes")
    parser.add_argument("--amplitude", metavar="ANGLE", help="as of the command modes")
    add_lock(parser)
    parser.add_argument("-o", "--out", metavar="OUT", help="output folder; without it, only print")
    parser.add_argument("--overwrite", action="store_true", help="replace earlier modes in OUT")
    parser.add_argument("--quiet", action="store_true", help="print no table")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Find the damping and print it."""
    winds = parse_winds(options.wind)
    if len(winds) != 1:
        raise InputError(f"--wind {options.wind}: give one wind speed")
    cycles = options.cycles
    if cycles is not None and not (isfinite(cycles) and 0.5 <= cycles <= MOST_CYCLES):
        raise InputError(f"--cycles {cycles:g}: must be from 0.5 to {MOST_CYCLES:g}")
    if options.count is not None and options.count < 1:
        raise InputError(f"--count {options.count}: must be at least 1")
    kick = None if options.kick is None else _parse_kick(options.kick)
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.cli.commands._progress import show_making
    from turbine_fenicsx.foundation.errors import FileError, StepFailure
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.turbine.modes.kicked_run import (
        CYCLES,
        KICK,
        DampingWanted,
        find_damping,
    )
    from turbine_fenicsx.turbine.modes.wind_modes import AMPLITUDE, COUNT, WindModesWanted

    modes = WindModesWanted(
        winds=winds,
        count=options.count or COUNT,
        schedule=options.schedule,
        keep_power=options.keep_power,
        locked=tuple(dict.fromkeys(options.lock)),
        amplitude=parse_amplitude(options.amplitude, AMPLITUDE),
    )
    wanted = DampingWanted(modes, options.mode, kick or KICK, cycles or CYCLES)
    shows = comm.rank == 0 and not options.quiet
    try:
        with show_making(comm, options.quiet):
            damping, files = find_damping(
                case,
                options.out,
                comm,
                wanted,
                overwrite=options.overwrite,
                found=lambda words: print(words, file=sys.stderr, flush=True) if shows else None,
            )
    except StepFailure as failure:
        return fail(comm, str(failure), NOT_CONVERGED)
    except FileError as error:
        raise InputError(str(error)) from None
    if files:
        files += on_rank0(comm, lambda: _draw(options.out))
    if shows:
        print(format_damping(damping))
        if files:
            print(f"results {options.out}/: {', '.join(files)}", flush=True)
    return OK


def format_damping(damping: Any) -> str:
    """The damping as lines to read."""
    from turbine_fenicsx.turbine.modes.mode_files import describe_place

    decay, work = damping.decay, damping.work
    lines = [
        ("eigenvalue", damping.eigenvalue),
        ("run, steps undone", decay.eigenvalue),
        ("run", decay.with_steps),
    ]
    if decay.eigenvalue == decay.with_steps:  # with numerical dissipation
        del lines[1]
    table = [
        f"  {title:18} {s.imag / (2.0 * pi):8.4f} Hz {-100.0 * s.real / abs(s):8.3f} % "
        f"{-s.real:10.5f} /s"
        for title, s in lines
    ]
    parts = (("air", work.air), ("structure", work.structure), ("drive", work.drive))
    shares = ", ".join(f"{name} {value:.5f} /s" for name, value in parts)
    return "\n".join(
        [
            f"{damping.name} at {describe_place(damping.place)}",
            f"  {'':18} {'frequency':>11} {'damping':>10} {'decay':>13}",
            *table,
            f"  work: {shares}",
            f"  the fit misses {100.0 * decay.miss:.2g} % of the largest amplitude",
        ]
    )


def _parse_kick(text: str) -> float:
    """The velocity of ``--kick`` [m/s]."""
    match = _KICK.fullmatch(text.strip())
    if match is None or not 0.0 < float(match[1]) <= LARGEST_KICK:
        raise InputError(
            f"--kick {text}: give a velocity above 0 and up to {LARGEST_KICK:g} m/s, for example "
            '"0.1 m/s"'
        )
    return float(match[1])


def _draw(out: str) -> list[str]:
    """Draw the picture; without matplotlib say so."""
    from turbine_fenicsx.postprocessing.damping_plot import plot_damping

    try:
        plot_damping(out, f"{out}/damping.png")
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["damping.png"]

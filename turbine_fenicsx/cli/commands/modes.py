"""Find the modes of a turbine, at rest or turning: frequencies, damping, shapes.

Small vibrations about the equilibrium under the weight, or about steady rotation without weight,
in still air or in steady wind. Several speeds give a Campbell diagram. With -o, the tables go to
modes.csv and campbell.csv, the shapes to modes.xdmf, which ParaView and the command render draw.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from math import isfinite, pi, radians
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    NOT_CONVERGED,
    OK,
    add_case,
    add_force,
    fail,
    load_case,
    need_dolfinx,
)
from turbine_fenicsx.cli.commands.steady import parse_winds
from turbine_fenicsx.foundation.errors import InputError

MAX_SPEEDS = 200
"""Largest number of speeds of one range."""

UNITS = {"rpm": pi / 30.0, "rad/s": 1.0, "deg/s": pi / 180.0}
"""Units of a speed in rad/s."""

MAX_AMPLITUDE = 5.0
"""Largest amplitude of the angle of attack [deg]."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_SPEED = re.compile(rf"({_NUMBER})\s*({'|'.join(UNITS)})", re.ASCII)
_RANGE = re.compile(rf"({_NUMBER}):({_NUMBER}):({_NUMBER})\s*({'|'.join(UNITS)})", re.ASCII)


_ANGLE = re.compile(rf"({_NUMBER})\s*deg", re.ASCII)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("--count", metavar="N", type=int, help="number of modes; default: 12")
    speed = parser.add_mutually_exclusive_group()
    speed.add_argument(
        "--speed",
        metavar="SPEED",
        nargs="+",
        help='speed of the rotor, for example "12 rpm"; default: turbine.rotor_speed of the case',
    )
    speed.add_argument(
        "--speeds",
        metavar="RANGE",
        nargs="+",
        help="speeds of a Campbell diagram, START:END:STEP with a unit, for example 0:14:2 rpm",
    )
    speed.add_argument("--at-rest", action="store_true", help="with a rotor that does not turn")
    speed.add_argument(
        "--wind",
        metavar="WINDS",
        help="in steady wind, with what the air does to them: speeds in m/s, START:END:STEP or "
        "separated by commas, for example 3:25:1",
    )
    speed.add_argument(
        "--flutter",
        metavar="RANGE",
        nargs="+",
        help="in the wind that lets the rotor turn freely at speeds, for example 7:12:0.5 rpm, "
        "with the speed from which a mode grows",
    )
    _add_air(parser)
    add_lock(parser)
    parser.add_argument("-o", "--out", metavar="OUT", help="output folder; without it, only print")
    parser.add_argument(
        "--overwrite", action="store_true", help="replace earlier modes in OUT; a run is kept"
    )
    add_force(parser)
    parser.add_argument("--quiet", action="store_true", help="print no table")


def add_lock(parser: argparse.ArgumentParser) -> None:
    """The argument ``--lock``."""
    parser.add_argument(
        "--lock",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help="joint coordinates that a brake holds, for example rotor yaw",
    )


def _add_air(parser: argparse.ArgumentParser) -> None:
    """Arguments that go with --wind."""
    parser.add_argument(
        "--schedule",
        metavar="FILE",
        help="with --wind: speed and pitch over the wind, as of the command steady",
    )
    parser.add_argument(
        "--keep-power",
        action="store_true",
        help="with --schedule FILE: from rated wind on, change the pitch until the power of the "
        "air is that of the table, in its column aero_power_[W]",
    )
    parser.add_argument(
        "--controller",
        action="store_true",
        help='with --wind: the controller, which must be control.kind = "pi", sets speed and pitch '
        "and takes part in the motions; else torque and pitch are constant",
    )
    parser.add_argument(
        "--amplitude",
        metavar="ANGLE",
        help="with --wind: amplitude of the angle of attack over which polars, whose slopes jump, "
        'are averaged, 0 to 5 deg; default: "0.5 deg"',
    )
    parser.add_argument(
        "--frozen-wake", action="store_true", help="with --wind: the wake does not follow"
    )
    parser.add_argument(
        "--quasi-steady",
        action="store_true",
        help="with --wind: lift follows without any delay, also in stall",
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Find the modes and print them."""
    speeds = _speeds(options)
    winds = None if options.wind is None else parse_winds(options.wind)
    if options.flutter is not None:
        speeds = parse_speeds(options.flutter, "--flutter")
        if speeds[0] <= 0.0:
            raise InputError(f"--flutter {' '.join(options.flutter)}: the rotor must turn")
    _check_air(options)
    if options.count is not None and options.count < 1:
        raise InputError(f"--count {options.count}: must be at least 1")
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.foundation.errors import FileError, StepFailure
    from turbine_fenicsx.foundation.interrupts import catch_signals
    from turbine_fenicsx.foundation.parallel import on_rank0

    try:
        with catch_signals() as interrupt:
            if winds is None and options.flutter is None:
                files = _find(case, options, comm, speeds, interrupt)
            else:
                files = _find_in_wind(case, options, comm, winds or speeds or (), interrupt)
    except StepFailure as failure:
        return fail(comm, str(failure), NOT_CONVERGED)
    except FileError as error:
        raise InputError(str(error)) from None
    if "campbell.csv" in files:
        files += on_rank0(comm, lambda: _draw(options.out))
    if comm.rank == 0 and files and not options.quiet:
        print(f"results {options.out}/: {', '.join(files)}", flush=True)
    if comm.allreduce(bool(interrupt.received)):
        raise KeyboardInterrupt
    return OK


def _check_air(options: argparse.Namespace) -> None:
    """Refuse what only wind has."""
    given = {
        "--schedule": options.schedule is not None,
        "--keep-power": options.keep_power,
        "--controller": options.controller,
        "--amplitude": options.amplitude is not None,
        "--frozen-wake": options.frozen_wake,
        "--quasi-steady": options.quasi_steady,
    }
    of_plan = ("--schedule", "--keep-power", "--controller")
    for name, there in given.items():
        if there and options.wind is None and (options.flutter is None or name in of_plan):
            raise InputError(f"{name} needs --wind")
    if options.controller and options.schedule is not None:
        raise InputError("--controller and --schedule: the controller sets speed and pitch itself")


def _find(
    case: Any,
    options: argparse.Namespace,
    comm: Any,
    speeds: tuple[float, ...] | None,
    interrupt: Any,
) -> list[str]:
    """Find the modes without air; names of the files."""
    from turbine_fenicsx.turbine.modes.find_modes import ModesWanted, find_modes

    speeds = (case.turbine.rotor_speed,) if speeds is None else speeds
    wanted = ModesWanted(options.count, speeds, tuple(dict.fromkeys(options.lock)))
    _, files = find_modes(
        case,
        options.out,
        comm,
        wanted,
        force=options.force,
        overwrite=options.overwrite,
        found=lambda table: _show(table, wanted, options, comm) or interrupt(),
    )
    return files


def _find_in_wind(
    case: Any, options: argparse.Namespace, comm: Any, places: Sequence[float], interrupt: Any
) -> list[str]:
    """Find the modes in wind, or of a free rotor; names of the files."""
    from turbine_fenicsx.cli.commands._progress import show_making
    from turbine_fenicsx.turbine.modes.wind_modes import (
        AMPLITUDE,
        COUNT,
        WindModesWanted,
        find_flutter,
        find_wind_modes,
    )

    wanted = WindModesWanted(
        **{"winds" if options.flutter is None else "speeds": places},
        count=options.count or COUNT,
        schedule=options.schedule,
        keep_power=options.keep_power,
        frozen_wake=options.frozen_wake,
        quasi_steady=options.quasi_steady,
        locked=tuple(dict.fromkeys(options.lock)),
        amplitude=parse_amplitude(options.amplitude, AMPLITUDE),
        controlled=options.controller,
    )
    with show_making(comm, options.quiet):
        tables, files = find_wind_modes(
            case,
            options.out,
            comm,
            wanted,
            overwrite=options.overwrite,
            found=lambda table: _show_in_wind(table, places, options, comm) or interrupt(),
        )
    if options.flutter is not None and comm.rank == 0 and not options.quiet:
        print(_describe_flutter(find_flutter(tables), tables[-1].place.speed), flush=True)
    return files


def _describe_flutter(found: Sequence[tuple[float, Any]], last: float) -> str:
    """Modes that begin to grow, in words."""
    from turbine_fenicsx.turbine.modes.mode_files import RPM

    if not found:
        return f"no mode begins to grow up to {last * RPM:.4g} rpm"
    lines = (
        f"grows from {speed * RPM:.4g} rpm: {row.name}, {row.frequency:.3f} Hz"
        for speed, row in found
    )
    return "\n".join(lines)


def parse_amplitude(text: str | None, default: float) -> float:
    """The angle of ``--amplitude`` [rad]."""
    if text is None:
        return default
    match = _ANGLE.fullmatch(text.strip())
    if match is None or not 0.0 <= float(match[1]) <= MAX_AMPLITUDE:
        raise InputError(
            f"--amplitude {text}: give an angle from 0 to {MAX_AMPLITUDE:g} deg, for example "
            '"0.5 deg"'
        )
    return radians(float(match[1]))


def _show_in_wind(
    table: Any, places: Sequence[float], options: argparse.Namespace, comm: Any
) -> bool:
    """Print the least damped mode at a place, and all modes at the last."""
    from turbine_fenicsx.turbine.modes.mode_files import describe_place, format_modes

    if comm.rank > 0 or options.quiet:
        return False
    place = table.place
    here = place.speed if place.is_free else place.wind
    moving = [row for row in table.rows if row.frequency]
    least = min(moving, key=lambda row: row.damping_ratio, default=None)
    words = "" if least is None else f": least damping {100.0 * least.damping_ratio:.2f} %"
    words += "" if least is None else f", {least.frequency:.3f} Hz, {least.name}"
    at = describe_place(place)
    number = f"{places.index(here) + 1} of {len(places)}"
    kind = "speed" if place.is_free else "wind"
    print(f"{kind} {number}: {at}{words}", file=sys.stderr, flush=True)
    if here == places[-1]:
        print(f"modes at {at}; frequencies are those seen from the ground")
        print(format_modes(table), flush=True)
    return False


def _speeds(options: argparse.Namespace) -> tuple[float, ...] | None:
    """Speeds that the options name [rad/s]; None leaves them to the case."""
    if options.at_rest:
        return (0.0,)
    if options.speed is not None:
        return (parse_speed(options.speed),)
    return None if options.speeds is None else parse_speeds(options.speeds)


def _show(table: Any, wanted: Any, options: argparse.Namespace, comm: Any) -> bool:
    """Print the modes at one speed; of several, which of them it is."""
    from turbine_fenicsx.turbine.modes.mode_files import RPM, format_modes

    if comm.rank == 0 and not options.quiet:
        speed = f"{table.place.speed * RPM:.4g} rpm"
        if len(wanted.speeds) > 1:
            place = wanted.speeds.index(table.place.speed) + 1
            print(f"speed {place} of {len(wanted.speeds)}: {speed}", file=sys.stderr, flush=True)
        if table.place.speed == wanted.speeds[-1]:
            print(f"modes at {speed}" if table.place.speed else "modes at rest")
            print(format_modes(table), flush=True)
    return False


def _draw(out: str) -> list[str]:
    """Draw the Campbell diagram; without matplotlib say so."""
    from turbine_fenicsx.postprocessing.campbell import plot_campbell

    try:
        plot_campbell(f"{out}/campbell.csv", f"{out}/campbell.png")
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["campbell.png"]


def parse_speed(words: list[str]) -> float:
    """The speed of ``--speed`` [rad/s].

    Raises:
        InputError: if it is not a number with a unit.
    """
    text = " ".join(words)
    match = _SPEED.fullmatch(text.strip())
    if match is None:
        raise InputError(
            f'--speed {text}: give a number and rpm, rad/s or deg/s, for example "12 rpm"'
        )
    return float(match[1]) * UNITS[match[2]]


def parse_speeds(words: list[str], option: str = "--speeds") -> tuple[float, ...]:
    """The speeds of ``--speeds`` or another option from the first to the last [rad/s].

    Raises:
        InputError: if it is not a finite range with a unit.
    """
    text = " ".join(words)
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise InputError(
            f"{option} {text}: give START:END:STEP and rpm, rad/s or deg/s, for example 0:14:2 rpm"
        )
    start, end, step = (float(match[k]) for k in (1, 2, 3))
    if not all(isfinite(x) for x in (start, end, step)) or step <= 0.0 or end <= start:
        raise InputError(f"{option} {text}: the end must be above the start, the step above 0")
    number = int((end - start) / step * (1.0 + 1e-9)) + 1
    if not 2 <= number <= MAX_SPEEDS:
        raise InputError(
            f"{option} {text}: these are {number} speeds, from 2 to {MAX_SPEEDS} are allowed"
        )
    return tuple((start + k * step) * UNITS[match[4]] for k in range(number))

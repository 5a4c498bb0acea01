"""Find the steady states of a turbine over the wind speed: power, thrust, loads, deflections.

At each wind speed the turbine turns in equilibrium with the air, its blades and tower bent. Speed
and pitch are those of a table, or found: the best tip-speed ratio below rated power, the pitch that
keeps it above. OUT gets steady.csv, steady_blade.csv, steady.yaml and pictures of them.
"""

from __future__ import annotations

import argparse
import sys
import time
from itertools import pairwise
from math import isfinite
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    NOT_CONVERGED,
    OK,
    add_case,
    fail,
    load_case,
    need_dolfinx,
)
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records import names

MOST = 200
"""Largest number of wind speeds, and of azimuths."""

LARGEST_WIND = 100.0
"""Largest wind speed [m/s]."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument(
        "--wind",
        metavar="WINDS",
        required=True,
        help="wind speeds in m/s, START:END:STEP or separated by commas, for example 3:25:1",
    )
    parser.add_argument("-o", "--out", metavar="OUT", required=True, help="output folder")
    parser.add_argument(
        "--schedule",
        metavar="FILE",
        help="table (CSV) with the columns wind_speed_[m/s], rotor_speed_[rpm] and pitch_[deg], "
        "such as a steady.csv, or input of ROSCO (.IN); default: by the controller of the case",
    )
    parser.add_argument(
        "--azimuths",
        metavar="N",
        type=int,
        default=2,
        help="azimuths within a third of a revolution that means are taken over; default: 2",
    )
    parser.add_argument(
        "--beside",
        metavar="FILE",
        nargs="+",
        default=[],
        help="tables (CSV) of other steady states with columns of the same names, for the pictures",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace steady states in OUT")
    parser.add_argument("--quiet", action="store_true", help="print neither progress nor table")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Find the steady states and print them."""
    winds = parse_winds(options.wind)
    if not 1 <= options.azimuths <= MOST:
        raise InputError(f"--azimuths {options.azimuths}: must be from 1 to {MOST}")
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.cli.commands._progress import show_making
    from turbine_fenicsx.foundation.errors import FileError
    from turbine_fenicsx.foundation.interrupts import catch_signals
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.postprocessing.steady_plots import read_beside
    from turbine_fenicsx.turbine.steady.find_steady import find_steady

    on_rank0(comm, lambda: read_beside(options.beside))
    shown = _Shown(winds, options.quiet or comm.rank > 0)
    try:
        with show_making(comm, options.quiet), catch_signals() as interrupt:
            states = find_steady(
                case,
                options.out,
                comm,
                winds,
                options.schedule,
                options.azimuths,
                options.overwrite,
                found=lambda state: shown(state) or interrupt(),
            )
    except FileError as error:
        raise InputError(str(error)) from None
    if not states:
        return fail(comm, "there is a steady state at none of the wind speeds", NOT_CONVERGED)
    files = ["steady.csv", "steady_blade.csv", "steady.yaml"]
    files += on_rank0(comm, lambda: _draw(options.out, options.beside))
    if comm.rank == 0 and not options.quiet:
        print(f"results {options.out}/: {', '.join(files)}", flush=True)
    if comm.allreduce(bool(interrupt.received)):
        raise KeyboardInterrupt
    return OK


class _Shown:
    """Prints a line for each steady state, with the time left."""

    def __init__(self, winds: list[float], quiet: bool) -> None:
        self._winds, self._quiet = winds, quiet
        self._start = time.perf_counter()
        self._headed = False

    def __call__(self, state: Any) -> bool:
        """Print a line."""
        if self._quiet:
            return False
        n = state.numbers
        if not self._headed:
            print("   wind   speed   pitch   power  thrust    C_P    C_T  tip x")
            print("    m/s     rpm     deg      MW      MN      -      -      m")
            self._headed = True
        print(
            f"{n[names.WIND_SPEED]:7.2f} {n[names.ROTOR_SPEED]:7.3f} {n[names.PITCH]:7.3f} "
            f"{1e-6 * n[names.AERO_POWER]:7.3f} {1e-6 * n[names.AERO_THRUST]:7.4f} "
            f"{n['power_coefficient_[-]']:6.3f} {n['thrust_coefficient_[-]']:6.3f} "
            f"{n['tip_deflection_x_[m]']:6.2f}",
            flush=True,
        )
        done = self._winds.index(state.operating.wind) + 1
        left = (time.perf_counter() - self._start) * (len(self._winds) - done) / done
        if left > 1.0:
            words = f"{done} of {len(self._winds)} wind speeds, {left:.0f} s left"
            print(words, file=sys.stderr, flush=True)
        return False


def _draw(out: str, beside: list[str]) -> list[str]:
    """Draw the steady states; without matplotlib say so."""
    from turbine_fenicsx.postprocessing.steady_plots import plot_steady

    try:
        return plot_steady(out, beside)
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []


def parse_winds(text: str) -> list[float]:
    """The wind speeds of ``--wind`` [m/s].

    Raises:
        InputError: if they are not positive numbers that rise, or too many.
    """
    try:
        if ":" in text:
            start, end, step = (float(x) for x in text.split(":"))
            number = int((end - start) / step * (1.0 + 1e-9)) + 1 if step > 0.0 else 0
            found = [start + k * step for k in range(min(number, MOST + 1))]
        else:
            found = [float(x) for x in text.split(",")]
    except (ValueError, OverflowError):
        found = []
    rising = all(a < b for a, b in pairwise(found))
    if not found or not rising or not all(isfinite(x) and 0.0 < x <= LARGEST_WIND for x in found):
        raise InputError(
            f"--wind {text}: give START:END:STEP or wind speeds that rise, above 0 and up to "
            f"{LARGEST_WIND:g} m/s, for example 3:25:1 or 8,10,12"
        )
    if len(found) > MOST:
        raise InputError(f"--wind {text}: up to {MOST} wind speeds are allowed")
    return found

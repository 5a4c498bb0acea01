"""Recover the failure of all plies from a run with reduced blades.

Reads motion.bin, the bases and case.json of the run.

--plies writes OUT/plies.csv. It has a row for each row of the motion, with the largest failure
index of each panel and web in all blades, its place, its ply and its blade.

--worst prints when, where and how a ply came nearest to failure, with what the turbine did then. It
writes OUT/worst.json. Without either, both are done.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, need_dolfinx


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folder", metavar="OUT", help="output folder of a run")
    parser.add_argument(
        "--plies", action="store_true", help="write the history of each panel and web"
    )
    parser.add_argument("--worst", action="store_true", help="find the moment nearest to failure")
    parser.add_argument(
        "--criterion",
        choices=("tsai_wu", "maximum_stress", "maximum_strain"),
        default="tsai_wu",
        help="of failure; default: tsai_wu",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace files that are there")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the files and print what was found."""
    from turbine_fenicsx.foundation.errors import FileError, InputError
    from turbine_fenicsx.foundation.parallel import on_rank0

    need_dolfinx()
    from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
    from turbine_fenicsx.turbine.run.recovery_files import list_files, refuse_to_overwrite, write

    both = not (options.plies or options.worst)
    files = list_files(options.plies or both, options.worst or both)
    if not options.overwrite:
        on_rank0(comm, lambda: refuse_to_overwrite(options.folder, files))
    recorded = RecordedRun.open(options.folder, comm)
    try:
        found = write(recorded, files, options.criterion, _make_progress(comm, options.quiet))
    except FileError as error:
        raise InputError(str(error)) from None
    if comm.rank == 0 and not options.quiet:
        print(*found, sep="\n", flush=True)
    return OK


def _make_progress(comm: Any, quiet: bool) -> Callable[[float], None]:
    """A function that shows on a terminal how much is done."""
    if quiet or comm.rank or not sys.stderr.isatty():
        return lambda part: None

    def show(part: float) -> None:
        end = "" if part < 1.0 else "\n"
        print(f"\r{100.0 * part:3.0f} %", end=end, file=sys.stderr, flush=True)

    return show

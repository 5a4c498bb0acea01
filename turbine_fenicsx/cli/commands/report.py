"""Write one HTML page about a run, modes, or a load set, that opens from disk without a network.

Case, mesh, diagrams, pictures, tables and versions, all from the output folder and all inside the
page. The page leaves out missing files and figures that cannot be drawn here, and says so in a
sentence. Of a run with reduced blades the moment nearest to failure is recovered first, as by the
command recover.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, need_dolfinx
from turbine_fenicsx.cli.commands._worst import PICTURE, draw_worst


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folder", metavar="OUT", help="output folder")
    parser.add_argument(
        "-o", "--out", metavar="FILE", help="the page (.html); default: OUT/report.html"
    )
    parser.add_argument(
        "--times",
        metavar="T,T,...",
        help="times of the pictures in s; default: four of the whole run",
    )
    parser.add_argument(
        "--scale",
        metavar="S",
        type=float,
        default=1.0,
        help="factor of the deformation in the pictures, see render --help",
    )
    parser.add_argument(
        "--beside",
        metavar="FILE",
        nargs="+",
        default=[],
        help="tables such as winds.csv of other load sets or codes, drawn over the wind speed",
    )
    parser.add_argument("--no-pictures", action="store_true", help="leave the pictures out")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the page and print its path."""
    from turbine_fenicsx.foundation.parallel import on_rank0

    path, times = on_rank0(comm, lambda: _check(options))
    note = _find_worst(options, comm)
    on_rank0(comm, lambda: _write(options, path, times, note))
    if comm.rank == 0:
        print(path, flush=True)
    return OK


def _find_worst(options: argparse.Namespace, comm: Any) -> str:
    """Recover the moment nearest to failure of a run with reduced blades; a note if it cannot be.

    It stays as the command ``recover`` has written it, unless the motion is newer.
    """
    from turbine_fenicsx.foundation.errors import FileError, InputError
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.postprocessing.page import format_note
    from turbine_fenicsx.records.conventions import MOTION
    from turbine_fenicsx.records.output_folder import holds_set, is_older

    folder = Path(options.folder)
    if on_rank0(comm, lambda: holds_set(folder)):
        return ""
    result = folder / ("worst.json" if options.no_pictures else PICTURE)
    if on_rank0(comm, lambda: not is_older(result, folder / MOTION)):
        return ""
    try:
        need_dolfinx()
        from turbine_fenicsx.turbine.run import recovery_files as files
        from turbine_fenicsx.turbine.run.ply_history import NoPlies
        from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
        from turbine_fenicsx.turbine.run.run_recovery import RunRecovery

        recovery = RunRecovery(RecordedRun.open(folder, comm))
        try:
            files.write_plies(recovery, CRITERION)
        except NoPlies:
            return ""
        worst, _ = files.write_worst(recovery, CRITERION)
        if not options.no_pictures:
            draw_worst(recovery, worst)
    except (FileError, InputError) as error:
        return format_note(f"The moment nearest to failure is not all there: {error}.")
    return ""


CRITERION = "tsai_wu"
"""Of the failure that the page shows."""


def _check(options: argparse.Namespace) -> tuple[Path, list[float] | None]:
    """The path of the page, and times of the pictures, after a look at all options."""
    from turbine_fenicsx.cli.commands._numbers import parse_numbers
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.records.output_folder import (
        holds_modes,
        holds_set,
        make_target_folder,
        need_folder,
    )

    times = None if options.times is None else parse_numbers("--times", options.times)
    if not 0.0 <= options.scale < float("inf"):
        raise InputError(f"--scale {options.scale:g}: must be a positive number")
    if options.out is not None and Path(options.out).suffix != ".html":
        raise InputError(f"--out {options.out}: the name of a page ends in .html")
    folder = need_folder(options.folder)
    if times is not None and (holds_modes(folder) or holds_set(folder)):
        raise InputError(f"--times {options.times}: modes and load sets have none")
    if options.beside and not holds_set(folder):
        raise InputError(f"--beside: {str(folder)!r} is not the folder of a load set")
    path = Path(options.out or folder / "report.html")
    make_target_folder(path.parent)
    return path, times


def _write(options: argparse.Namespace, path: Path, times: list[float] | None, note: str) -> None:
    """Write the page."""
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.load_sets.report import report_set
    from turbine_fenicsx.postprocessing.mode_report import report_modes
    from turbine_fenicsx.postprocessing.report import report
    from turbine_fenicsx.records.output_folder import holds_modes, holds_set
    from turbine_fenicsx.turbine.case.description import describe_case

    shown = options.scale, not options.no_pictures, describe_case
    if holds_set(options.folder):
        page = report_set(options.folder, options.beside)
    elif holds_modes(options.folder):
        page = report_modes(options.folder, *shown)
    else:
        page = report(options.folder, times, *shown, note)
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {str(path)!r}: {error.strerror}") from None

"""Run a study: one case with many changes, in parallel, with one table at the end."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    NOT_CONVERGED,
    OK,
    fail,
    need_dolfinx,
)
from turbine_fenicsx.cli.commands._many_runs import (
    add_many_runs,
    choose_folder,
    choose_processes,
)
from turbine_fenicsx.cli.commands._running import choose_style


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("study", metavar="STUDY", help="study file (TOML)")
    add_many_runs(parser, "how many runs at a time", "the runs and which of them are finished")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Run what is not finished and print tables."""
    from turbine_fenicsx.foundation.errors import InputError

    if comm.size > 1:
        raise InputError(
            "start a study without mpirun; `ranks = N` in the study file gives N ranks to each run"
        )
    need_dolfinx()
    from turbine_fenicsx.records.output_folder import STUDY
    from turbine_fenicsx.study.file import Study
    from turbine_fenicsx.study.run import run_study

    study = choose_processes(options, Study.load(options.study))
    out = choose_folder(options, options.study)
    if options.list:
        _list(study, out, options.overrides)
        return OK
    result = run_study(study, out, options.overrides, choose_style(options), options.overwrite)
    names = [STUDY]
    if study.convergence is not None:
        names += ["convergence.csv", *_draw_errors(study, result, out)]
    if study.curve is not None:
        names += _draw_curve(study, result, out)
    if not options.quiet:
        _print_orders(result.series)
        for note in result.notes:
            print(f"note: {note}")
        _print_drifts(study, result)
        done, total = len(result.results), len(result.runs)
        print(f"{done} of {total} runs finished; results {out}/: {', '.join(names)}", flush=True)
    if result.failed:
        lines = [f"run {name!r} failed, {reason}" for name, reason in result.failed.items()]
        return fail(comm, "\n".join(lines), NOT_CONVERGED)
    return OK


def _list(study: Any, out: Path, overrides: list[str]) -> None:
    """Print the names of all runs and what there is to do."""
    from turbine_fenicsx.study.plan import plan
    from turbine_fenicsx.study.results import is_finished, is_interrupted

    for planned in plan(study, overrides):
        folder = out / planned.name
        state = "to resume" if is_interrupted(planned, folder) else "to run"
        print(f"{'finished' if is_finished(planned, folder) else state:<10} {planned.name}")
    sys.stdout.flush()


def _print_orders(series: list[Any]) -> None:
    """Print a table for each series, with the fitted order below it."""
    import numpy as np

    from turbine_fenicsx.study.convergence import report
    from turbine_fenicsx.study.results import format_lines

    for s in series:
        if s.label:
            print(s.label)
        print("\n".join(format_lines(report(s))))
        wavy = "; the values go up and down: take finer runs" if s.oscillates else ""
        if not np.isfinite(s.order):
            known = np.isfinite(s.reference)
            why = "the errors follow no power of the size" if known else "no runs point to a limit"
            print(f"observed order: undetermined, {why}{wavy}\n")
            continue
        note = ", the finest run, whose own error makes the order too high" if s.finest else ""
        if s.source:
            note = f", the limit of {s.source!r}"
        elif s.own_limit:
            note = ", its own limit"
        unchecked = "" if s.is_checked else "; fitted, not checked: take more runs"
        print(f"observed order: {s.order:.2f}, against {s.reference:.9g}{note}{unchecked}{wavy}\n")


def _print_drifts(study: Any, result: Any) -> None:
    """Say which means are not those of stationary runs, once for each quantity."""
    for quantity in dict.fromkeys(name for drifts in result.drifts.values() for name in drifts):
        found = {run: d[quantity] for run, d in result.drifts.items() if quantity in d}
        worst = max(found, key=lambda run: found[run])
        most = f"in {len(found)} of {len(result.drifts)} runs, most" if len(found) > 1 else "in run"
        print(
            f"note: {quantity} is not stationary {most} {worst!r}: its means over the two halves "
            f"of the last {study.average:g} s differ by {100.0 * found[worst]:.3g} %"
        )


def _draw_curve(study: Any, result: Any, out: Path) -> list[str]:
    """Draw the curve; without matplotlib say so."""
    from turbine_fenicsx.study.curve import plot_curve

    try:
        plot_curve(study, result.runs, result.results, out / "curve.png")
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["curve.png"]


def _draw_errors(study: Any, result: Any, out: Path) -> list[str]:
    """Draw the errors; without matplotlib say so."""
    from turbine_fenicsx.study.picture import plot_convergence

    key = study.convergence.key
    numbers = isinstance(result.runs[0].value(key), tuple)
    size = f"1 / mean of {key}" if numbers else key
    try:
        plot_convergence(result.series, size, study.title, out / "convergence.png")
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["convergence.png"]

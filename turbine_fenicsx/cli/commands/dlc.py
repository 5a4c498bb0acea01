"""Run a load set: design load cases of IEC 61400-1 as runs of one turbine, all cores at a time.

The file of the set names the case of the turbine and the situations. OUT gets a folder for each
run, and tables. There is runs.csv with how they went. Means and extremes of all channels are in
set.csv, those at each wind speed in winds.csv. Loads of return periods are in extrapolated.csv,
those of the life in fatigue.csv and markov.csv. Arrays of all are in set.nc. Called again, the
command runs what is missing.
"""

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
    parser.add_argument("set", metavar="SET", help="file of the load set (TOML)")
    add_many_runs(
        parser,
        "runs at a time; default: all cores",
        "the runs, which of them are finished, how long they last, and warnings of the first one "
        "of each situation",
    )


def run(options: argparse.Namespace, comm: Any) -> int:
    """Run what is not finished and say what there is."""
    from turbine_fenicsx.foundation.errors import InputError

    if comm.size > 1:
        raise InputError("start a load set without mpirun; with launcher it uses several nodes")
    need_dolfinx()
    from turbine_fenicsx.load_sets.load_set import LoadSet
    from turbine_fenicsx.load_sets.run import run_set

    load_set = choose_processes(options, LoadSet.load(options.set))
    out = choose_folder(options, options.set)
    if options.list:
        _list(load_set, out, options.overrides)
        return OK
    try:
        result = run_set(load_set, out, options.overrides, choose_style(options), options.overwrite)
    except ImportError as error:
        raise InputError(str(error)) from None
    if not options.quiet:
        done, total = len(result.results), len(result.runs)
        names = ", ".join(result.tables)
        print(f"{done} of {total} runs finished; results {out}/: {names}", flush=True)
    if result.failed:
        lines = [f"run {name!r} failed, {reason}" for name, reason in result.failed.items()]
        return fail(comm, "\n".join(lines), NOT_CONVERGED)
    return OK


def _list(load_set: Any, out: Path, overrides: list[str]) -> None:
    """Print all runs and what there is to do, with doubts about the first one of each situation."""
    from turbine_fenicsx.load_sets.plan import plan_set
    from turbine_fenicsx.study.results import is_finished, is_interrupted

    runs = plan_set(load_set, overrides)
    seen: set[str] = set()
    seconds = steps = 0.0
    for each in runs:
        folder, time = out / each.run.name, each.run.case.time
        state = "to resume" if is_interrupted(each.run, folder) else "to run"
        if is_finished(each.run, folder):
            state = "finished"
        else:
            seconds, steps = seconds + time.end, steps + time.end / time.step
        print(f"{state:<10} {time.end:6g} s  {each.run.name}")
        if each.situation not in seen:
            seen.add(each.situation)
            for sentence in list_doubts(each):
                print(f"warning: run {each.run.name!r}: {sentence}", file=sys.stderr)
    print(
        f"{len(runs)} runs of {len(seen)} situations; {seconds:g} s with {steps:.3g} steps to run",
        flush=True,
    )


def list_doubts(each: Any) -> list[str]:
    """Warnings about the case of a run, but for keys of the set that have no effect in it."""
    own = tuple(f"{key} has no effect" for key in each.run.changes)
    return [sentence for sentence in each.run.case.warnings if not sentence.startswith(own)]

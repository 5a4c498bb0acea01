"""Shared by `run` and `restart`: signals, failures, the table at the end."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    INTERRUPTED,
    NOT_CONVERGED,
    OK,
    UNBALANCED,
    WRONG_INPUT,
    fail,
    warn,
)


def carry_out(
    options: argparse.Namespace,
    comm: Any,
    work: Callable[[Callable[[], bool]], tuple[Any, dict[str, Any]]],
) -> int:
    """Do the work and say how it went.

    Args:
        options: With ``out`` and ``progress``.
        comm: Communicator.
        work: Gets a function that says whether to stop; returns the case and its summary.

    Returns:
        The exit code.
    """
    from turbine_fenicsx.foundation.errors import FileError, StepFailure
    from turbine_fenicsx.foundation.interrupts import catch_signals
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.records import names
    from turbine_fenicsx.simulation.energy_check import judge_energy
    from turbine_fenicsx.turbine.run.summary import format_table

    out = options.out
    resume = f"`turbine-fenicsx restart {shlex.quote(out)}` resumes from there"
    try:
        with catch_signals() as interrupt:
            case, result = work(interrupt)
    except StepFailure as failure:
        return fail(comm, f"{failure}. Results up to there are in {out}", NOT_CONVERGED)
    except FileError as error:
        return fail(comm, str(error), WRONG_INPUT)
    except OSError as error:  # of no file of the run: a library, a cache
        name = f"{error.filename}: " if error.filename else ""
        return fail(comm, f"{name}{error.strerror or error}", WRONG_INPUT)
    if result[names.INTERRUPTED]:
        t = result[names.END_TIME]
        return fail(comm, f"interrupted at t = {t:g} s; {resume}", INTERRUPTED)
    pictures = on_rank0(comm, lambda: _draw_history(out, case.title))
    if comm.rank == 0 and not options.quiet:
        files = ["history.csv", "history.out", "statistics.csv", "summary.json", *pictures]
        if case.motion_every > 0.0:
            files.insert(1, "motion.bin")
        if case.fields_every > 0.0:
            fields = ["fields", "wind"][: 2 if case.wind.blows else 1]
            files[1:1] = [f"{name}.{case.output.format}" for name in fields]
        print(f"{case.title or 'turbine'}, {comm.size} rank{'s' * (comm.size > 1)}")
        print(format_table(result))
        print(f"  {'results':<22}{out}/: {', '.join(files)}", flush=True)
    wrong = judge_energy(result)
    warn(comm, [sentence for sentence in result[names.WARNINGS] if sentence != wrong])
    return fail(comm, wrong, UNBALANCED) if wrong else OK


def choose_style(options: argparse.Namespace) -> str:
    """Style of the progress."""
    return "none" if options.quiet else str(options.progress)


def _draw_history(out: str, title: str) -> list[str]:
    """Draw what one looks at first; without matplotlib say so."""
    try:
        from turbine_fenicsx.postprocessing.plots import plot_summary

        plot_summary(f"{out}/history.csv", f"{out}/history.png", title)
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["history.png"]

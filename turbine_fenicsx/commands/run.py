"""Run a case."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from turbine_fenicsx.commands._common import (
    NOT_CONVERGED,
    OK,
    add_case,
    add_progress,
    fail,
    load_case,
    need_dolfinx,
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="OUT", required=True, help="output folder")
    add_progress(parser)


def run(options: argparse.Namespace, comm: Any) -> int:
    """Run the case and print a short table."""
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.parallel import on_rank0
    from turbine_fenicsx.solver import StepFailure
    from turbine_fenicsx.turbine.run import run_case
    from turbine_fenicsx.turbine.summary import table

    try:
        result = run_case(case, options.out, comm, options.progress)
    except StepFailure as failure:
        return fail(comm, f"{failure}. Results up to there are in {options.out}", NOT_CONVERGED)
    pictures = on_rank0(comm, lambda: _picture(options.out))
    if comm.rank == 0:
        names = ["history.csv", "summary.json", *pictures]
        if case.output.fields_every > 0.0:
            names.insert(1, "fields.xdmf")
        print(f"{case.title or 'turbine'}, {comm.size} rank{'s' * (comm.size > 1)}")
        print(table(result))
        print(f"  {'results':<22}{options.out}/: {', '.join(names)}", flush=True)
    return OK


def _picture(out: str) -> list[str]:
    """Draw energies and angles; without matplotlib say so."""
    try:
        from turbine_fenicsx.plots import plot_summary

        plot_summary(f"{out}/history.csv", f"{out}/history.png")
    except ImportError:
        print("no picture: matplotlib is not installed", file=sys.stderr)
        return []
    return ["history.png"]

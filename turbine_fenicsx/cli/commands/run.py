"""Run a case."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    add_case,
    add_force,
    add_progress,
    load_case,
    need_dolfinx,
)
from turbine_fenicsx.cli.commands._progress import show_making
from turbine_fenicsx.cli.commands._running import carry_out, choose_style


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="OUT", required=True, help="output folder")
    parser.add_argument(
        "--overwrite", action="store_true", help="replace the results of an earlier run in OUT"
    )
    add_force(parser)
    add_progress(parser)


def run(options: argparse.Namespace, comm: Any) -> int:
    """Run the case and print a short table."""
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.turbine.run.run import run_case

    style = choose_style(options)
    with show_making(comm, style == "none"):
        return carry_out(
            options,
            comm,
            lambda stop: (
                case,
                run_case(
                    case,
                    options.out,
                    comm,
                    style,
                    stop=stop,
                    force=options.force,
                    overwrite=options.overwrite,
                ),
            ),
        )

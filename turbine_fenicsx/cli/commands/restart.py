"""Resume a run from its last checkpoint."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.cli.commands._common import (
    add_force,
    add_overrides,
    add_progress,
    need_dolfinx,
)
from turbine_fenicsx.cli.commands._running import carry_out, choose_style


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("out", metavar="OUT", help="output folder of the run")
    add_overrides(parser)
    add_force(parser)
    add_progress(parser)


def run(options: argparse.Namespace, comm: Any) -> int:
    """Resume and print a short table."""
    need_dolfinx()
    from turbine_fenicsx.turbine.run.run import restart_case

    return carry_out(
        options,
        comm,
        lambda stop: restart_case(
            options.out, comm, options.overrides, choose_style(options), stop, options.force
        ),
    )

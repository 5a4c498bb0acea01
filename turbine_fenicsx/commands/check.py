"""Check a case and its mesh without running it."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.commands._common import OK, add_case, load_case, need_dolfinx


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)


def run(options: argparse.Namespace, comm: Any) -> int:
    """Check and print size and quality of the mesh."""
    case = load_case(options, comm)
    need_dolfinx()
    from turbine_fenicsx.turbine.model import blade_geometry, load_mesh

    blade_geometry(case)
    report = "rigid turbine, no mesh"
    if case.turbine.model == "hybrid":
        report = str(load_mesh(case, comm).report)
    if comm.rank == 0:
        print(f"{options.case}: valid\n{report}", flush=True)
    return OK

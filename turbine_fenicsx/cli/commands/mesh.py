"""Write the blade mesh of a case as a .msh file."""

from __future__ import annotations

import argparse
import os
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_case, load_case


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="FILE", required=True, help="mesh file (.msh)")
    parser.add_argument("--overwrite", action="store_true", help="replace FILE if it is there")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Write the mesh and print its size and quality."""
    case = load_case(options, comm)
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.meshing import write_rotor
    from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor

    if on_rank0(comm, lambda: os.path.lexists(options.out)) and not options.overwrite:
        raise InputError(f"{options.out!r} is there already: --overwrite replaces it")
    made = case.mesh.model_copy(update={"file": None})  # the built-in one, also beside a file
    plan = plan_rotor(case.model_copy(update={"mesh": made}), comm)
    try:
        _, make = plan.mesh_source()
        report = on_rank0(comm, lambda: write_rotor(make, options.out))
    except OSError as error:
        raise InputError(str(error)) from None
    if comm.rank == 0:
        print(f"{options.out}\n{report}", flush=True)
    return OK

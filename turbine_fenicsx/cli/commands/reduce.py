"""Make, judge and draw the basis of reduced blades ahead of a run.

Without -o the basis is kept in the folder bases beside the case file, where a run looks for it.
The verdict is printed, and written beside the basis with a picture.
"""

from __future__ import annotations

import argparse
import os
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_case, load_case, need_dolfinx
from turbine_fenicsx.cli.commands._progress import show_making


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="FILE", help="file of the basis (.npz)")
    parser.add_argument("--overwrite", action="store_true", help="replace FILE if it is there")
    parser.add_argument("--quiet", action="store_true", help="print neither progress nor verdict")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Make the basis and print the verdict."""
    from turbine_fenicsx.foundation.errors import FileError, InputError
    from turbine_fenicsx.foundation.parallel import on_rank0

    out = options.out
    if out is not None and not out.endswith(".npz"):
        raise InputError(f"-o {out}: expected a name that ends with .npz")
    options.overrides = [*options.overrides, 'blade.model="reduced"']
    case = load_case(options, comm)
    if not case.has_reduced_blades:
        raise InputError('turbine.model = "rigid": there are no flexible blades to reduce')
    need_dolfinx()
    from turbine_fenicsx.turbine.run.reduction import reduce_case

    if out is not None:
        if on_rank0(comm, lambda: os.path.lexists(out)) and not options.overwrite:
            raise InputError(f"{out!r} is there already: --overwrite replaces it")
        folder = os.path.dirname(out) or "."
        if not on_rank0(comm, lambda: os.access(folder, os.W_OK)):
            raise InputError(f"cannot write {out!r}: {folder!r} is no folder that may be written")
    try:
        with show_making(comm, options.quiet):
            found = reduce_case(case, comm, out)
    except FileError as error:
        raise InputError(str(error)) from None
    if comm.rank == 0 and not options.quiet:
        print(found.verdict)
        files = [found.path, *([found.picture] if found.picture else [])]
        print(", ".join(str(file) for file in files), flush=True)
    return OK

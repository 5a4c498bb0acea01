"""Check a case and its mesh, and estimate what a run takes, without running it."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.commands._common import OK, add_case, need_dolfinx

TOO_LARGE = 1_000_000
"""Built-in meshes with more nodes than this are not made just to be looked at."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)


def run(options: argparse.Namespace, comm: Any) -> int:
    """Say everything that is wrong, or the estimate and then size and quality of the mesh."""
    need_dolfinx()
    from turbine_fenicsx.errors import InputError
    from turbine_fenicsx.parallel import on_rank0
    from turbine_fenicsx.turbine.case import Draft
    from turbine_fenicsx.turbine.estimate import estimate
    from turbine_fenicsx.turbine.inspection import inspect_mesh
    from turbine_fenicsx.turbine.model import blade_geometry, mesh_options
    from turbine_fenicsx.turbine.size import size_of_options

    draft = on_rank0(comm, lambda: Draft.load(options.case, options.overrides))
    case = draft.case
    hybrid, mistakes = case.turbine.model == "hybrid", [m.sentence for m in draft.mistakes]
    own = None
    # other mistakes do not keep a mesh from being looked at, but those in what it depends on do
    if hybrid and case.mesh.file and not {"turbine", "blade", "mesh"} & draft.tables:
        own = inspect_mesh(case, comm)
        mistakes += own.mistakes
    if mistakes:
        raise InputError("\n".join(dict.fromkeys(mistakes)))

    size = own.size if own else None
    if hybrid and own is None:
        size = size_of_options(blade_geometry(case), mesh_options(case), case.mesh.degree)
    expected = estimate(case, size)
    _warn(comm, [*case.warnings, *expected.warnings])
    _print(comm, str(expected))
    if not hybrid:
        _print(comm, "rigid turbine, no mesh of blades")
    elif own is None and size is not None and size.vertices > TOO_LARGE:
        _print(comm, "the mesh is too large to be made just for a check; use the command mesh")
    else:
        found = own or inspect_mesh(case, comm)
        if found.mistakes:
            raise InputError("\n".join(found.mistakes))
        _warn(comm, found.warnings)
        _print(comm, found.report)
    _print(comm, f"{options.case}: valid")
    return OK


def _warn(comm: Any, sentences: Any) -> None:
    """Print warnings."""
    _print(comm, "\n".join(f"warning: {sentence}" for sentence in sentences))


def _print(comm: Any, text: str) -> None:
    """Print on one rank, at once, unless there is nothing to say."""
    if comm.rank == 0 and text:
        print(text, flush=True)

"""Check a case and its mesh without running it."""

from __future__ import annotations

import argparse
from typing import Any

from turbine_fenicsx.cli.commands._common import OK, add_case, need_dolfinx


def arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add_case(parser)
    parser.add_argument("-o", "--out", metavar="OUT", help="also look at this output folder")


def run(options: argparse.Namespace, comm: Any) -> int:
    """Say everything that is wrong, or the size and quality of the mesh."""
    need_dolfinx()
    from turbine_fenicsx.foundation.errors import InputError
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.records.output_folder import holds_run
    from turbine_fenicsx.turbine.blades.section_doubts import list_section_doubts
    from turbine_fenicsx.turbine.case.case import Draft
    from turbine_fenicsx.turbine.case.description import describe_bearings
    from turbine_fenicsx.turbine.case.turbine_file import describe_file
    from turbine_fenicsx.turbine.case.wind_checks import describe_aerodynamics
    from turbine_fenicsx.turbine.run.inspection import (
        describe_rigid_blades,
        describe_tower,
        inspect_mesh,
        list_damping_mistakes,
    )
    from turbine_fenicsx.turbine.run.reduction import describe_reduction

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

    warnings = on_rank0(comm, lambda: list(case.warnings))
    if case.turbine.file:
        from turbine_fenicsx.windio.validation import list_schema_mistakes

        file = case.turbine.file
        warnings += on_rank0(comm, lambda: list_schema_mistakes(file))
    if options.out and on_rank0(comm, lambda: holds_run(options.out)):
        warnings.append(f"{options.out!r} holds a run already")
    _warn(comm, warnings)
    _print(comm, "\n".join(on_rank0(comm, lambda: describe_file(case))))
    _print(comm, "\n".join(on_rank0(comm, lambda: describe_aerodynamics(case))))
    _print(comm, "\n".join(on_rank0(comm, lambda: describe_bearings(case))))
    if not hybrid:
        _print(comm, "\n".join(describe_rigid_blades(case, comm)))
    else:
        found = own or inspect_mesh(case, comm)
        if found.mistakes:
            raise InputError("\n".join(found.mistakes))
        _warn(comm, [*found.warnings, *on_rank0(comm, lambda: list_section_doubts(case))])
        _print(comm, found.report)
        reduction = on_rank0(comm, lambda: describe_reduction(case, found.nodes_of_blade))
        _print(comm, "\n".join(reduction))
    if mistakes := list_damping_mistakes(case, comm):
        raise InputError("\n".join(mistakes))
    _print(comm, "\n".join(on_rank0(comm, lambda: describe_tower(case))))
    _print(comm, f"{options.case}: valid")
    return OK


def _warn(comm: Any, sentences: Any) -> None:
    """Print warnings."""
    _print(comm, "\n".join(f"warning: {sentence}" for sentence in sentences))


def _print(comm: Any, text: str) -> None:
    """Print on one rank, immediately, unless there is nothing to say."""
    if comm.rank == 0 and text:
        print(text, flush=True)

"""Reduced blades ahead of a run: their basis made and judged, and in words what they cost."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import load_arrays
from turbine_fenicsx.reduction.basis_file import read_sizes
from turbine_fenicsx.reduction.judge import judge
from turbine_fenicsx.reduction.verdict import Verdict
from turbine_fenicsx.turbine.blades.blade_basis import (
    find_basis,
    list_loads,
    make_basis,
    name_basis,
)
from turbine_fenicsx.turbine.blades.clamped_blade import ClampedBlade, SingleMesh
from turbine_fenicsx.turbine.blades.operating_points import UNSEEN
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.case.case import Case

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class JudgedBasis:
    """A basis that was made and judged.

    Args:
        picture: The picture of the verdict; None without Matplotlib.
    """

    path: Path
    verdict: Verdict
    picture: Path | None


def load_blade(case: Case, comm: MPI.Intracomm) -> ClampedBlade[FlexibleBody]:
    """One of the blades of a case. Collective."""
    rotor = plan_rotor(case, comm)
    single = SingleMesh(rotor)
    try:
        mesh = load_arrays(comm, single.make, single.source, single.examine)
    except OSError as error:
        raise InputError(str(error)) from None
    return ClampedBlade.of("blade", mesh, rotor)


def reduce_case(case: Case, comm: MPI.Intracomm, out: str | None) -> JudgedBasis:
    """Make the basis of the blades of a case, or take it from a file, and judge it. Collective.

    Beside the basis are written the verdict, ``.txt``, and its picture, ``.png``.

    Args:
        out: File of the basis; None for the one that a run takes.
    """
    path = Path(out) if out is not None else on_rank0(comm, lambda: name_basis(case))
    if path is None:
        raise InputError("there is no folder for the basis: name a file with -o")
    blade = load_blade(case, comm)
    basis = find_basis(case, blade) if out is None else make_basis(case, blade, path)
    loads = list_loads(case, blade, UNSEEN)
    verdict = judge(blade.system, blade.body, basis, loads, count=case.blade.reduction.modes or 1)
    text = f"{verdict}\n"
    on_rank0(comm, partial(replace_file, name_verdict(path), text.encode()))
    return JudgedBasis(path, verdict, on_rank0(comm, lambda: _draw(verdict, path)))


def name_verdict(path: Path) -> Path:
    """File of the verdict on the basis of a file."""
    return path.with_suffix(".txt")


def _draw(verdict: Verdict, path: Path) -> Path | None:
    """Draw a verdict beside its basis; without Matplotlib nothing."""
    picture = path.with_suffix(".png")
    try:
        verdict.draw(picture)
    except ImportError:
        return None
    return picture


def describe_reduction(case: Case, nodes: int) -> list[str]:
    """Cost and quality of reduced blades in words; called on rank 0.

    Args:
        nodes: Number of nodes of the displacement of one blade.

    Returns:
        Lines; none without reduced blades, and for beams.
    """
    if case.has_beam_blades or not case.has_reduced_blades:
        return []
    r = case.blade.reduction
    path = Path(r.file) if r.file is not None else name_basis(case)
    if path is not None and (r.file is not None or path.is_file()):
        try:
            found = read_sizes(path)
        except InputError as error:
            if r.file is not None:
                raise
            return [f"reduced blades: {error}; a run makes their basis again"]
        lines = [
            f"reduced blades: {found.functions} functions and {found.strains} strain coordinates "
            f"in place of {3 * nodes} displacements each, from {path}"
        ]
        if found.nodes != nodes:
            raise InputError(
                f"{str(path)!r} is not a basis of these blades, the mesh of a blade has {nodes} "
                f"nodes, and that of the basis {found.nodes}: reduce the blades again"
            )
        return [*lines, _describe_verdict(name_verdict(path))]
    return [
        f"reduced blades: {r.functions} functions in place of {3 * nodes} displacements each; "
        "their basis is not made yet: a run makes it at the start, in some minutes, or the command "
        "reduce ahead of it"
    ]


def _describe_verdict(path: Path) -> str:
    """The warnings of a verdict in a line."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return "the basis is not judged yet: the command reduce does that"
    warnings = [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]
    return f"the basis is judged: {'; '.join(warnings) or 'no warnings'}"

"""A look at the mesh of a case, the user's own or a built-in one, without DOLFINx."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import mesh_tower
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.size import MeshSize
from turbine_fenicsx.turbine.blade_mesh import examine_blades
from turbine_fenicsx.turbine.blade_plan import ROOTS
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.size import size_of_arrays, size_of_tower
from turbine_fenicsx.turbine.rotor_plan import RotorPlan, plan_rotor
from turbine_fenicsx.turbine.station_check import list_station_mistakes
from turbine_fenicsx.turbine.tower import tower_geometry

TOO_LARGE = 1_000_000
"""Built-in meshes with more nodes than this are not made just to be looked at."""


@dataclass(frozen=True)
class Inspection:
    """What a look at a mesh shows.

    Args:
        mistakes: What is wrong with it, one sentence each.
        warnings: What looks wrong, one sentence each.
        report: Size, volumes, masses and quality in a few lines; empty if it cannot be read.
        size: Its numbers; None if it cannot be read.
    """

    mistakes: tuple[str, ...]
    warnings: tuple[str, ...]
    report: str
    size: MeshSize | None


def inspect_mesh(case: Case, comm: MPI.Intracomm) -> Inspection:
    """Read the mesh of a case on rank 0 and look at everything.

    Args:
        case: A hybrid turbine.
        comm: Communicator.

    Raises:
        InputError: on every rank, if a built-in mesh cannot be made or a file not be read.

    Note:
        Collective over ``comm``.
    """
    try:
        plan = plan_rotor(case, comm)
        name, make = plan.mesh_source()
        return on_rank0(comm, lambda: _inspect(case, plan, name, make))
    except OSError as error:
        raise InputError(str(error)) from None


def _inspect(case: Case, plan: RotorPlan, name: str, make: Callable[[], MeshArrays]) -> Inspection:
    """Look at the mesh on this rank."""
    try:
        mesh = make()
    except ModelError as error:
        return Inspection((str(error),), (), "", None)
    report, found = mesh.examine(), examine_blades(mesh, plan.layout, plan.blades)
    warnings = [*report.warnings, *found.warnings, *plan.blades.find_doubts(report)]
    mistakes = tuple(f"{name}: {m}" for m in (*report.mistakes, *plan.list_mistakes(mesh)))
    if not mistakes:
        mistakes = tuple(list_station_mistakes(case, mesh, plan.layout, plan.blades.degree))
    made = () if mistakes else plan.blades.describe(report, mesh, plan.layout)
    size = size_of_arrays(mesh, ROOTS, plan.blades.degree)
    if case.mesh.file and not mistakes:
        # imported here: SciPy takes a while, and a built-in mesh is known without
        from turbine_fenicsx.meshing.parts import count_parts

        parts, layers = count_parts(mesh.points, mesh.cells)
        size = replace(size, parts=parts, layers=layers)
    return Inspection(
        mistakes,
        tuple(warnings),
        "\n".join([str(report), *made, *_describe_tower(case)]),
        size,
    )


def _describe_tower(case: Case) -> list[str]:
    """Size, mass and quality of the tower, if there is one."""
    if not case.tower.flexible:
        return []
    t = case.tower
    if size_of_tower(t).vertices > TOO_LARGE:
        return ["the mesh of the tower is too large to be made just for a check"]
    report = mesh_tower(tower_geometry(t), t.elements, t.degree).examine()
    return [
        str(report),
        f"mass of the tower {sum(report.volumes.values()) * t.density / 1e3:.6g} t",
    ]

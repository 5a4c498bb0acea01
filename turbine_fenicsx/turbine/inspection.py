"""A look at the mesh of a case, the user's own or a built-in one, without DOLFINx."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import MeshReport, tower_arrays
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.turbine.blade_mesh import examine_blades, find_curved_cells
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.doubts import mass_doubt
from turbine_fenicsx.turbine.case.size import MeshSize, size_of_arrays, size_of_tower
from turbine_fenicsx.turbine.rotor_plan import ROOTS, RotorPlan, plan_rotor
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
        plan = plan_rotor(case)
        name, make = plan.mesh_source(comm)
        return on_rank0(comm, lambda: _inspect(case, plan, name, make))
    except OSError as error:
        raise InputError(str(error)) from None


def _inspect(case: Case, plan: RotorPlan, name: str, make: Callable[[], MeshArrays]) -> Inspection:
    """Look at the mesh on this rank."""
    layout, blade = plan.layout, plan.blade
    try:
        mesh = make()
    except ModelError as error:
        return Inspection((str(error),), (), "", None)
    report, found = mesh.examine(), examine_blades(mesh, layout, blade)
    warnings = [*report.warnings, *found.warnings]
    if case.mesh.file:  # that of a built-in mesh is told by the case alone
        mass = sum(report.volumes.values()) * case.material.density / layout.n_blades
        warnings += mass_doubt(mass, case.blade.length)
    curved = find_curved_cells(report.geometry_degree, case.mesh.degree)
    return Inspection(
        tuple(f"{name}: {m}" for m in (*report.mistakes, *found.mistakes, *curved)),
        tuple(warnings),
        "\n".join(
            [str(report), _mass(case, report, blade.volume * layout.n_blades), *_tower(case)]
        ),
        size_of_arrays(mesh, ROOTS, case.mesh.degree),
    )


def _tower(case: Case) -> list[str]:
    """Size, mass and quality of the tower, if there is one."""
    if not case.tower.flexible:
        return []
    t = case.tower
    if size_of_tower(t).vertices > TOO_LARGE:
        return ["the mesh of the tower is too large to be made just for a check"]
    report = tower_arrays(tower_geometry(t), t.elements, t.degree).examine()
    return [
        str(report),
        f"mass of the tower {sum(report.volumes.values()) * t.density / 1e3:.6g} t",
    ]


def _mass(case: Case, report: MeshReport, ideal: float) -> str:
    """Mass of the blades against that of the ideal shape; their shape may be only in a file."""
    volume, density = sum(report.volumes.values()), case.material.density
    text = f"mass of the blades {volume * density / 1e3:.6g} t"
    if case.mesh.file and not {"chord", "thickness"} & case.blade.model_fields_set:
        return text
    change, word = 100.0 * (volume / ideal - 1.0), "less" if volume < ideal else "more"
    return (
        f"{text}, {abs(change):.2g} % {word} than {ideal * density / 1e3:.6g} t of the ideal shape"
    )

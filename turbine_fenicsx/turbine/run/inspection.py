"""A look at the mesh of a case, the user's own or a built-in one, without DOLFINx."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing import mesh_tower
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.topology import count_nodes
from turbine_fenicsx.meshing.tower import BOTTOM, TOP
from turbine_fenicsx.turbine.blades.beam_blades import OF_INTERFACE, OF_NODE, BeamBlades
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.blades.rotor_plan import RotorPlan, plan_rotor
from turbine_fenicsx.turbine.blades.single_blade import list_unequal_blades
from turbine_fenicsx.turbine.blades.station_check import list_station_mistakes
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.beam_tower import find_sections
from turbine_fenicsx.turbine.components.model import assemble, list_components
from turbine_fenicsx.turbine.components.tower import tower_geometry


@dataclass(frozen=True)
class Inspection:
    """Findings on a mesh.

    Args:
        mistakes: What is wrong with it, one sentence each.
        report: Size, unknowns, volumes, masses and quality in a few lines; empty if it cannot be
            read.
        nodes_of_blade: Number of nodes of the displacement of one blade.
    """

    mistakes: tuple[str, ...]
    warnings: tuple[str, ...]
    report: str
    nodes_of_blade: int = 0


def inspect_mesh(case: Case, comm: MPI.Intracomm) -> Inspection:
    """Read the mesh of a case on rank 0 and look at everything.

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
        return Inspection((str(error),), (), "")
    report, found = mesh.examine(), examine_blades(mesh, plan.layout, plan.blades)
    warnings = [*report.warnings, *found.warnings, *plan.blades.find_warnings(report)]
    mistakes = tuple(f"{name}: {m}" for m in (*report.mistakes, *plan.list_mistakes(mesh)))
    if not mistakes and case.has_reduced_blades:
        unequal = list_unequal_blades(mesh, plan.layout)
        mistakes = tuple(f"{name}: {m}" for m in unequal)
    elif not mistakes:
        mistakes = tuple(list_station_mistakes(case, mesh, plan.layout, plan.blades.degree))
    text = [str(report)]
    if not case.has_beam_blades:  # beams say their own
        text.append(_describe_unknowns(mesh, ROOTS, plan.blades.degree))
    if not mistakes:
        text += plan.blades.describe(report, mesh, plan.layout)
    nodes = count_nodes(mesh.cells, mesh.reference, 3, plan.blades.degree) // len(ROOTS)
    return Inspection(mistakes, tuple(warnings), "\n".join(text), nodes)


def list_damping_mistakes(case: Case, comm: MPI.Intracomm) -> list[str]:
    """A sentence if stiffness and mass cannot meet the ratios of two modes. Collective.

    Their modes are found for it, of solids on the whole mesh, which takes some seconds.
    """
    parts = (case.turbine.model == "hybrid", case.blade), (case.tower.flexible, case.tower)
    if not any(is_there and part.damping.may_not_fit for is_there, part in parts):
        return []
    full = {
        name: part.model_copy(update={"model": "full"})
        for name, part in (("blade", case.blade), ("tower", case.tower))
        if part.model == "reduced"
    }
    whole = case.model_copy(update=full)
    try:
        assemble(whole, list_components(whole), comm)
    except ModelError as error:
        return str(error).splitlines()
    return []


def describe_rigid_blades(case: Case, comm: MPI.Intracomm) -> list[str]:
    """Mass and centre of mass of a rigid blade, in a line. Collective."""
    plan = plan_rotor(case, comm)
    inertia = on_rank0(comm, plan.blades.find_inertia)
    if inertia is None:
        return ["rigid turbine, no mesh of blades"]
    source = "section matrices" if isinstance(plan.blades, BeamBlades) else "layup"
    return [
        f"rigid blades with the inertia of their {source}: mass of a blade "
        f"{inertia.mass / 1e3:.6g} t, centre of mass "
        f"{inertia.centre[0] - plan.blades.hub_radius:.4g} m from the root"
    ]


def describe_tower(case: Case) -> list[str]:
    """Lines on size, unknowns, mass and quality of the tower, if it is flexible."""
    if not case.tower.flexible:
        return []
    t = case.tower
    geometry = tower_geometry(t)
    if case.has_beam_tower:
        e = t.beam
        unknowns = 2 * OF_INTERFACE + OF_NODE * (e.elements * e.degree - 1)
        return [
            f"beam of {e.elements} elements of degree {e.degree}: mass of the tower "
            f"{find_sections(t, geometry).mass / 1e3:.6g} t",
            f"unknowns: {unknowns} displacements of the tower",
        ]
    mesh = mesh_tower(geometry, t.elements, t.degree)
    report = mesh.examine()
    lines = [
        str(report),
        _describe_unknowns(mesh, (BOTTOM, TOP), t.degree),
        f"mass of the tower {sum(report.volumes.values()) * t.density / 1e3:.6g} t",
    ]
    if case.has_reduced_tower:
        lines.append(f"reduced tower: {t.reduction.functions} functions in place of its mesh")
    return lines


def _describe_unknowns(mesh: MeshArrays, coupled: tuple[str, ...], degree: int) -> str:
    """Numbers of displacements, and of multipliers on the surfaces that rigid bodies hold."""
    tags = [mesh.surfaces[name] for name in coupled if name in mesh.surfaces]
    facets = mesh.facets[np.isin(mesh.facet_groups, tags)]
    nodes = count_nodes(mesh.cells, mesh.reference, 3, degree)
    held = count_nodes(facets, mesh.reference, 2, degree)
    return f"unknowns: {3 * nodes} displacements, {3 * held} coupling multipliers"

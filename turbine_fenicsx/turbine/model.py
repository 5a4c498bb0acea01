"""From a case to a system: bodies, joints, loads, and what is needed to look at them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.errors import InputError
from turbine_fenicsx.loads import Gravity, JointTorque
from turbine_fenicsx.meshing import (
    BladeGeometry,
    LoadedMesh,
    MeshOptions,
    RotorLayout,
    cached_mesh,
    load_msh,
)
from turbine_fenicsx.observers.tips import Tip
from turbine_fenicsx.rigid_surface import RigidSurface
from turbine_fenicsx.rotations import Array
from turbine_fenicsx.solver import SolverOptions
from turbine_fenicsx.system import MultibodySystem
from turbine_fenicsx.time_functions import Hat
from turbine_fenicsx.turbine.case import Case
from turbine_fenicsx.turbine.hybrid import hybrid_turbine
from turbine_fenicsx.turbine.rigid import AZIMUTHS, rigid_turbine
from turbine_fenicsx.turbine.surfaces import blade_surface, hub_surface, nacelle_surface

NACELLE, HUB, FIRST_BLADE = 0, 1, 2
"""Numbers of the parts in the field output."""


@dataclass(frozen=True, eq=False)
class Turbine:
    """A turbine ready to run.

    Args:
        system: The system.
        surfaces: Surfaces of the rigid parts.
        tips: Blade tips to follow.
        parts: Number of the part of each local cell, one array per flexible body.
        mesh: The mesh of the blades; None for the rigid turbine.
    """

    system: MultibodySystem
    surfaces: tuple[RigidSurface, ...]
    tips: tuple[Tip, ...]
    parts: tuple[Array, ...]
    mesh: LoadedMesh | None


def rotor_layout(case: Case) -> RotorLayout:
    """Where the blades of a case stand."""
    return RotorLayout(centre=(0.0, 0.0, -case.turbine.hub_distance), azimuths=AZIMUTHS)


def blade_geometry(case: Case) -> BladeGeometry:
    """Shape of the blades of a case.

    Raises:
        InputError: if stations and widths do not fit together.
    """
    try:
        return BladeGeometry(**case.blade.model_dump())
    except ValueError as error:
        raise InputError(str(error)) from None


def mesh_options(case: Case) -> MeshOptions:
    """Options of the mesh of a case."""
    m = case.mesh
    return MeshOptions(
        cell=m.cell, geometry_degree=m.geometry_degree, elements=m.elements, size=m.size
    )


def solver_options(case: Case) -> SolverOptions:
    """Options of the step solver of a case."""
    return SolverOptions(**case.solver.model_dump())


def load_mesh(case: Case, comm: MPI.Intracomm) -> LoadedMesh:
    """Mesh of the blades: the user's own file, or made and cached.

    Raises:
        InputError: if the mesh cannot be read or made, or lacks a group.
    """
    layout = rotor_layout(case)
    try:
        path = case.mesh.file or cached_mesh(comm, blade_geometry(case), layout, mesh_options(case))
        mesh = load_msh(comm, path, layout.volume_groups, [f"root_{k}" for k in (1, 2, 3)])
    except (ValueError, OSError) as error:
        raise InputError(str(error)) from None
    _check_blades(mesh)
    return mesh


def build_turbine(case: Case, comm: MPI.Intracomm) -> Turbine:
    """Build the turbine of a case. Collective.

    Args:
        case: The case.
        comm: Communicator.

    Raises:
        InputError: for a mesh that does not fit.
    """
    p, layout, blade = case.turbine.parameters(), rotor_layout(case), blade_geometry(case)
    mesh: LoadedMesh | None = None
    if case.turbine.model == "rigid":
        parts = rigid_turbine(p)
    else:
        mesh = load_mesh(case, comm)
        names = [(mesh.cell_names[f"blade_{k}"], mesh.facet_names[f"root_{k}"]) for k in (1, 2, 3)]
        parts = hybrid_turbine(
            p,
            mesh.mesh,
            mesh.cell_tags,
            mesh.facet_tags,
            [(*tags, layout.frame(k)) for k, tags in enumerate(names, start=1)],
            case.material.make,
            case.material.density,
            case.mesh.degree,
        )
    loads = case.loads
    parts.append(Gravity((0.0, -loads.gravity, 0.0)))
    for joint, peak in (("rotor", loads.rotor_torque), ("yaw", loads.yaw_torque)):
        parts.append(JointTorque(joint, Hat(peak, loads.duration)))
    try:
        system = MultibodySystem(comm, parts, angle_form=case.turbine.angle_form)
    except ValueError as error:
        raise InputError(str(error)) from None

    nacelle, hub = system.rigid_bodies[:2]
    surfaces = [
        nacelle_surface(nacelle, p.hub_distance, NACELLE),
        hub_surface(hub, blade.hub_radius, HUB),
    ]
    tips, cell_parts = [], []
    centre, radius = np.asarray(hub.position), blade.hub_radius + blade.length
    for k in range(3):
        span = layout.frame(k + 1)[0]
        if mesh is None:
            body = system.rigid_bodies[2 + k]
            surfaces.append(blade_surface(body, blade, centre, span, FIRST_BLADE + k))
        else:
            tips.append(Tip(str(k + 1), system.flexible_bodies[0], centre + radius * span, hub))
    if mesh is not None:
        numbers = {mesh.cell_names[f"blade_{k + 1}"]: FIRST_BLADE + k for k in range(3)}
        cell_parts.append(_part_of_cells(mesh, numbers))
    return Turbine(system, tuple(surfaces), tuple(tips), tuple(cell_parts), mesh)


def _check_blades(mesh: LoadedMesh) -> None:
    """Each root must lie on its own blade, and no cell may be outside the blades. Collective.

    Raises:
        InputError: on all ranks.
    """
    comm, topology = mesh.mesh.comm, mesh.mesh.topology
    blades = [mesh.cell_names[f"blade_{k}"] for k in (1, 2, 3)]
    n_cells = len(_compat.geometry_nodes_of_cells(mesh.mesh))
    tags = np.full(n_cells, -1)
    tags[mesh.cell_tags.indices] = mesh.cell_tags.values
    owned = tags[: topology.index_map(3).size_local]
    strangers = comm.allreduce(int(np.count_nonzero(~np.isin(owned, blades))))
    if strangers:
        raise InputError(
            f"{strangers} cells of the mesh belong to none of the groups blade_1, blade_2, blade_3"
        )
    topology.create_connectivity(2, 3)
    cells_of = topology.connectivity(2, 3)
    for k, blade in enumerate(blades, start=1):
        facets = mesh.facet_tags.indices[mesh.facet_tags.values == mesh.facet_names[f"root_{k}"]]
        wrong = sum(int(tags[cells_of.links(f)[0]] != blade) for f in facets)
        wrong = comm.allreduce(wrong)
        if wrong:
            raise InputError(f"{wrong} faces of the group root_{k} do not lie on blade_{k}")


def _part_of_cells(mesh: LoadedMesh, numbers: dict[int, int]) -> Array:
    """Number of the part of each local cell."""
    tags: Any = mesh.cell_tags
    part = np.zeros(len(_compat.geometry_nodes_of_cells(mesh.mesh)))
    part[tags.indices] = [numbers[tag] for tag in tags.values]
    return part

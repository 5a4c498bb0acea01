"""From a case to a system: bodies, joints, loads, and what is needed to look at them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.forces import Gravity, JointTorque
from turbine_fenicsx.forces.time_functions import Hat
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import (
    BladeGeometry,
    LoadedMesh,
    MeshOptions,
    RotorLayout,
    cached_mesh,
    load_arrays,
    read_msh,
    rotor_arrays,
)
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.simulation.observers.tips import Tip
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blade_mesh import examine_blades, too_curved
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.parameters import Inertia
from turbine_fenicsx.turbine.hybrid import hybrid_turbine
from turbine_fenicsx.turbine.pitch import RootRings, pitch_drive, pitch_torques
from turbine_fenicsx.turbine.rigid import AZIMUTHS, rigid_turbine
from turbine_fenicsx.turbine.surfaces import blade_surface, hub_surface, nacelle_surface
from turbine_fenicsx.turbine.tower import Tower, build_tower

NACELLE, HUB, FIRST_BLADE, TOWER = 0, 1, 2, 5
"""Numbers of the parts in the field output."""

PART_NAMES = {
    NACELLE: "nacelle",
    HUB: "hub",
    TOWER: "tower",
    **{FIRST_BLADE + k: f"blade_{k + 1}" for k in range(3)},
}
"""Their names."""

ROOTS = ("root_1", "root_2", "root_3")
"""Physical surfaces of a mesh that move with the hub."""


@dataclass(frozen=True, eq=False)
class Turbine:
    """A turbine ready to run.

    Args:
        system: The system.
        surfaces: Surfaces of the rigid parts.
        tips: Blade tips to follow.
        parts: Number of the part of each local cell, one array per flexible body.
        mesh: The mesh of the blades; None for the rigid turbine.
        roots: Couplings of the roots of flexible blades.
        tower: The flexible tower; None without one.
    """

    system: MultibodySystem
    surfaces: tuple[RigidSurface, ...]
    tips: tuple[Tip, ...]
    parts: tuple[Array, ...]
    mesh: LoadedMesh | None
    roots: tuple[Coupling, ...]
    tower: Tower | None


def rotor_layout(case: Case) -> RotorLayout:
    """Where the blades of a case stand."""
    return RotorLayout(centre=(0.0, 0.0, -case.turbine.hub_distance), azimuths=AZIMUTHS)


def blade_geometry(case: Case) -> BladeGeometry:
    """Shape of the blades of a case.

    Raises:
        ModelError: if stations and widths do not fit together.
    """
    return BladeGeometry(**case.blade.model_dump())


def mesh_options(case: Case) -> MeshOptions:
    """Options of the mesh of a case."""
    m = case.mesh
    return MeshOptions(
        cell=m.cell, geometry_degree=m.geometry_degree, elements=m.elements, size=m.size
    )


def blade_arrays(case: Case, comm: MPI.Intracomm) -> tuple[str, Callable[[], MeshArrays]]:
    """What the mesh of the blades is called, and what makes it on rank 0.

    It is read from a file, the user's own or one of tetrahedra that was cached. Hexahedra are made
    each time, which takes less than reading them.

    Raises:
        ModelError: if the mesh cannot be made.
    """
    layout, blade, options = rotor_layout(case), blade_geometry(case), mesh_options(case)
    if case.mesh.file is None and options.cell == "hexahedron":
        return "mesh of the blades", lambda: rotor_arrays(blade, layout, options)
    path = Path(case.mesh.file or cached_mesh(comm, blade, layout, options))
    return f"mesh file '{path}'", lambda: read_msh(path, layout.volume_groups, ROOTS)


def load_mesh(case: Case, comm: MPI.Intracomm) -> LoadedMesh:
    """Mesh of the blades, distributed.

    Raises:
        ModelError: if the mesh cannot be read or made, lacks a group, or cannot be the blades.
        InputError: if a file cannot be read or written.
    """
    layout, blade = rotor_layout(case), blade_geometry(case)

    def check(mesh: MeshArrays) -> tuple[str, ...]:
        curved = too_curved(mesh.reference.degree, case.mesh.degree)
        return (*examine_blades(mesh, layout, blade).mistakes, *curved)

    try:
        name, make = blade_arrays(case, comm)
        return load_arrays(comm, make, name, check)
    except OSError as error:
        raise InputError(str(error)) from None


def build_turbine(case: Case, comm: MPI.Intracomm) -> Turbine:
    """Build the turbine of a case. Collective.

    Args:
        case: The case.
        comm: Communicator.

    Raises:
        ModelError: for parts, or a mesh, that do not fit together.
        InputError: if a file cannot be read or written.
    """
    tower = build_tower(case.tower, comm) if case.tower.flexible else None
    support = tower.top if tower else None
    mesh: LoadedMesh | None = None
    if case.turbine.model == "rigid":
        parts = rigid_turbine(case.turbine.parameters(), support)
    else:
        mesh = load_mesh(case, comm)
        parts = _hybrid_parts(case, mesh, support)
    roots = tuple(part for part in parts if isinstance(part, Coupling))
    parts += [*(tower.parts if tower else ()), *_loads_and_drives(case)]
    system = MultibodySystem(comm, parts)
    cell_parts = []
    if mesh is not None:
        numbers = {mesh.cell_names[f"blade_{k + 1}"]: FIRST_BLADE + k for k in range(3)}
        cell_parts.append(_part_of_cells(mesh, numbers))
    if tower is not None:
        cell_parts.append(_part_of_cells(tower.mesh, {tower.mesh.cell_names["tower"]: TOWER}))
    surfaces, tips = _surfaces(case, system), _tips(case, roots)
    return Turbine(system, surfaces, tips, tuple(cell_parts), mesh, roots, tower)


def _hybrid_parts(case: Case, mesh: LoadedMesh, support: RigidBody | None) -> list[Any]:
    """Bodies, joints and couplings of the hybrid turbine."""
    layout, pitch = rotor_layout(case), case.pitch
    names = [(mesh.cell_names[f"blade_{k}"], mesh.facet_names[f"root_{k}"]) for k in (1, 2, 3)]
    rings = None
    if pitch.bearings:
        rings = RootRings(Inertia(pitch.ring_mass, pitch.ring_euler), case.blade.hub_radius)
    return hybrid_turbine(
        case.turbine.parameters(),
        mesh.mesh,
        mesh.cell_tags,
        mesh.facet_tags,
        [(*tags, layout.frame(k)) for k, tags in enumerate(names, start=1)],
        case.material.make,
        case.material.density,
        case.mesh.degree,
        rings,
        support,
    )


def _loads_and_drives(case: Case) -> list[Any]:
    """Gravity, torques, and what drives the pitch bearings."""
    loads = case.loads
    parts: list[Any] = [Gravity((0.0, -loads.gravity, 0.0))]
    for joint, peak in (("rotor", loads.rotor_torque), ("yaw", loads.yaw_torque)):
        parts.append(JointTorque(joint, Hat(peak, loads.duration)))
    if case.has_pitch_bearings:
        parts += [*pitch_torques(loads), *pitch_drive(case.pitch)]
    return parts


def _surfaces(case: Case, system: MultibodySystem) -> tuple[RigidSurface, ...]:
    """Surfaces of nacelle, hub and rigid blades."""
    layout, blade = rotor_layout(case), blade_geometry(case)
    nacelle, hub = system.rigid_bodies[:2]
    root = 0.5 * max(blade.chord_at(0.0), blade.thickness_at(0.0))
    size = float(np.hypot(blade.hub_radius, root))  # the roots are inside
    surfaces = [
        nacelle_surface(nacelle, case.turbine.hub_distance, size, NACELLE),
        hub_surface(hub, size, HUB),
    ]
    if case.turbine.model == "rigid":
        for k, body in enumerate(system.rigid_bodies[2:5]):
            span = layout.frame(k + 1)[0]
            centre = np.asarray(hub.position)
            surfaces.append(blade_surface(body, blade, centre, span, FIRST_BLADE + k))
    return tuple(surfaces)


def _tips(case: Case, roots: tuple[Coupling, ...]) -> tuple[Tip, ...]:
    """The tips of the flexible blades, in the frames of what carries their roots."""
    layout, radius = rotor_layout(case), case.blade.hub_radius + case.blade.length
    tips = []
    for k, root in enumerate(roots, start=1):
        assert root.rigid is not None
        point = np.asarray(layout.centre) + radius * layout.frame(k)[0]
        tips.append(Tip(str(k), root.flexible, point, root.rigid))
    return tuple(tips)


def _part_of_cells(mesh: LoadedMesh, numbers: dict[int, int]) -> Array:
    """Number of the part of each local cell."""
    tags: Any = mesh.cell_tags
    cells = mesh.mesh.topology.index_map(3)
    part = np.zeros(cells.size_local + cells.num_ghosts)
    part[tags.indices] = [numbers[tag] for tag in tags.values]
    return part

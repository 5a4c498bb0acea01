"""The flexible tower: a tube of hexahedra between the ground and the yaw bearing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.materials import StVenantKirchhoff
from turbine_fenicsx.materials.lame import lame_constants
from turbine_fenicsx.meshing import LoadedMesh, TowerGeometry, load_arrays, tower_arrays
from turbine_fenicsx.meshing.tower import BOTTOM, TOP
from turbine_fenicsx.turbine.case.tables import TowerCase


@dataclass(frozen=True, eq=False)
class Tower:
    """A tower and what it is coupled to.

    Args:
        body: The tube.
        top: Rigid body at its top, which carries the yaw bearing.
        foot: Coupling to the ground.
        head: Coupling to ``top``.
        mesh: Mesh of the tube.
    """

    body: FlexibleBody
    top: RigidBody
    foot: Coupling
    head: Coupling
    mesh: LoadedMesh

    @property
    def parts(self) -> list[Any]:
        """Bodies and couplings."""
        return [self.top, self.body, self.foot, self.head]


def tower_geometry(tower: TowerCase) -> TowerGeometry:
    """Shape of the tower of a case.

    Raises:
        ModelError: for a wall that leaves no hollow.
    """
    return TowerGeometry(tower.height, tower.bottom_diameter, tower.top_diameter, tower.wall)


def build_tower(case: TowerCase, comm: MPI.Intracomm) -> Tower:
    """Build the tower of a case. Cells are curved if the displacement is quadratic. Collective.

    Args:
        case: Its table.
        comm: Communicator.

    Raises:
        ModelError: if the mesh cannot be made.
    """
    geometry = tower_geometry(case)
    mesh = load_arrays(
        comm, lambda: tower_arrays(geometry, case.elements, case.degree), "mesh of the tower"
    )
    material = StVenantKirchhoff(*lame_constants(case.young, case.poisson))
    body = FlexibleBody("tower", mesh.mesh, material, case.density, case.degree)
    top = RigidBody("tower_top", case.top_mass, case.top_euler)
    foot = Coupling("tower_foot", body, mesh.facets(BOTTOM), None)
    head = Coupling("tower_head", body, mesh.facets(TOP), top)
    return Tower(body, top, foot, head, mesh)

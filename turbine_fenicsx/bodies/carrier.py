"""Meshes of bodies that have mass and stiffness elsewhere, such as beams."""

from __future__ import annotations

from dataclasses import dataclass

from dolfinx.mesh import Mesh

from turbine_fenicsx.bodies.mesh_check import check_body_mesh


@dataclass(frozen=True, eq=False)
class Carrier:
    """A mesh without a law: it carries the surfaces, points and pictures of a reduced body.

    Args:
        name: Unique name.
        mesh: DOLFINx mesh of hexahedra or tetrahedra in the initial configuration [m].
        degree: Polynomial degree of the displacement, 1 or 2.

    Raises:
        ModelError: for a degree other than 1 or 2, or a mesh that is not three-dimensional or has
            other cells.
    """

    name: str
    mesh: Mesh
    degree: int = 1

    def __post_init__(self) -> None:
        check_body_mesh(self.name, self.mesh, self.degree)

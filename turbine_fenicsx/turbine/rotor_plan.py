"""Where the blades of a case stand, their shape, and the mesh they get."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import (
    BladeGeometry,
    MeshOptions,
    RotorLayout,
    cached_mesh,
    read_msh,
    rotor_arrays,
)
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.turbine.blade_mesh import examine_blades, find_curved_cells
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.size import MeshSize, size_of_options

AZIMUTHS = (-2.0 * np.pi / 3.0, 0.0, 2.0 * np.pi / 3.0)
"""Azimuths of blades 1, 2, 3 (bodies 3, 4, 5) about e3 from e2 [rad]."""

PITCH_SIGNS = (1.0, -1.0, 1.0)
"""The paper counts the pitch of the upright blade negative about its outward axis."""

ROOTS = ("root_1", "root_2", "root_3")
"""Physical surfaces of a mesh of blades that move with the hub."""


@dataclass(frozen=True)
class RotorPlan:
    """Blades before they are built.

    Args:
        layout: Where they stand.
        blade: Shape of one.
        options: Mesh that is made for them.
        degree: Polynomial degree of the displacement.
        file: Mesh file to take instead; None makes a mesh.
    """

    layout: RotorLayout
    blade: BladeGeometry
    options: MeshOptions
    degree: int
    file: str | None

    @property
    def tips(self) -> list[Array]:
        """Initial positions of the tips, each of shape (3,) [m]."""
        radius, layout = self.blade.hub_radius + self.blade.length, self.layout
        numbers = range(1, layout.n_blades + 1)
        return [np.asarray(layout.centre) + radius * layout.frame(k)[0] for k in numbers]

    @property
    def size(self) -> MeshSize:
        """Size of the mesh that is made, counted or estimated."""
        return size_of_options(self.blade, self.options, self.degree)

    def mesh_source(self, comm: MPI.Intracomm) -> tuple[str, Callable[[], MeshArrays]]:
        """What the mesh of the blades is called, and what makes it on rank 0. Collective.

        It is read from a file, the user's own or one of tetrahedra that was cached. Hexahedra are
        made each time, which takes less than reading them.

        Raises:
            ModelError: if the mesh cannot be made.
        """
        layout, blade, options = self.layout, self.blade, self.options
        if self.file is None and options.cell == "hexahedron":
            return "mesh of the blades", lambda: rotor_arrays(blade, layout, options)
        path = Path(self.file or cached_mesh(comm, blade, layout, options))
        return f"mesh file '{path}'", lambda: read_msh(path, layout.volume_groups, ROOTS)

    def list_mistakes(self, mesh: MeshArrays) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from being these blades."""
        curved = find_curved_cells(mesh.reference.degree, self.degree)
        return (*examine_blades(mesh, self.layout, self.blade).mistakes, *curved)


def plan_rotor(case: Case) -> RotorPlan:
    """The blades of a case.

    Raises:
        ModelError: if stations and widths do not fit together.
    """
    m = case.mesh
    return RotorPlan(
        RotorLayout(centre=(0.0, 0.0, -case.turbine.hub_distance), azimuths=AZIMUTHS),
        BladeGeometry(**case.blade.model_dump()),
        MeshOptions(
            cell=m.cell, geometry_degree=m.geometry_degree, elements=m.elements, size=m.size
        ),
        m.degree,
        m.file,
    )

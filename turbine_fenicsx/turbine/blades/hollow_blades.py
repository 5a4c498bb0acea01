"""Hollow blades with the layup of a windIO file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.cell_fields import cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import WallTable, tabulate_walls
from turbine_fenicsx.meshing import LoadedMesh, MeshReport, RotorLayout, place_blades, read_msh
from turbine_fenicsx.meshing.hollow import HollowBlock, mesh_hollow
from turbine_fenicsx.meshing.hollow_ends import HEXAHEDRON
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.quality import cell_centres, cell_moments, cell_volumes
from turbine_fenicsx.system.ply_stresses import PlyStresses
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS, BladePlies
from turbine_fenicsx.turbine.blades.shaped_blades import ShapedBlades
from turbine_fenicsx.turbine.blades.wall_cells import WallCells
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.material import MaterialCase
from turbine_fenicsx.turbine.tables.rigid_parts import Inertia
from turbine_fenicsx.windio.blade import WindIOBlade

DEGREE = 2
"""Polynomial degree of displacement and cells: linear cells of thin walls lock."""

CAPPED = 1.05
"""A wall is capped if the one of the file is thicker by this factor."""


@dataclass(frozen=True, eq=False)
class HollowBlades(ShapedBlades[WindIOBlade]):
    """Blades of laminates, a `turbine_fenicsx.turbine.blades.blade_plan.BladePlan`.

    Args:
        span: Number of elements along the span.
        around: Number of elements around a section.
        moments: Whether walls have the bending stiffness of their layup too.
        file: Mesh file that the command `mesh` has written for such blades; None makes the mesh.
    """

    span: int
    around: int
    moments: bool
    material: MaterialCase
    file: str | None = None
    degree: int = DEGREE

    @classmethod
    def of(cls, case: Case, comm: MPI.Intracomm) -> HollowBlades:
        """Those of a case with a windIO file. Collective."""
        file, b, m = case.turbine.file, case.blade, case.mesh
        assert file is not None
        blade = on_rank0(comm, lambda: load_turbine(file).blade)
        blade = replace(blade, hub_radius=b.hub_radius, closed_tip=m.tip == "closed")
        return cls(blade, m.span, m.around, b.layup == "laminate", case.material, m.file)

    def axis_at(self, s: Array) -> Array:
        """Points of the reference axis, shape (m, 3) [m]."""
        return self.shape.axis_at(s)

    def find_inertia(self) -> Inertia:
        """Mass, centre of mass from the rotor centre, and tensor of inertia of one."""
        solids = self.block.points, self.block.cells, self.block.reference
        density = self.table.density
        masses = density * cell_volumes(*solids)
        mass = float(masses.sum())
        centre = masses @ cell_centres(*solids) / mass
        E = np.einsum("c,cij->ij", density, cell_moments(*solids)) - mass * np.outer(centre, centre)
        J = np.trace(E) * np.eye(3) - E
        a1, a2, a3 = (tuple(row) for row in J.tolist())
        return Inertia(mass, (0.0, 0.0, 0.0), tuple(centre.tolist()), (a1, a2, a3))

    @cached_property
    def block(self) -> HollowBlock:
        """The mesh of one blade."""
        return mesh_hollow(self.shape, self.span, self.around)

    @cached_property
    def table(self) -> WallTable:
        """Stiffness and density of each cell of the mesh that is made for a blade."""
        return self._tabulate(WallCells.read(self.shape, self.block.cell_data))

    def _tabulate(self, cells: WallCells) -> WallTable:
        """Stiffness and density of cells."""
        return tabulate_walls(cells.find_plies(), cells.thickness, self.moments)

    def mesh_source(self, layout: RotorLayout) -> tuple[str, Callable[[], MeshArrays]]:
        """Name of the mesh, and the function that makes or reads it on rank 0."""
        if self.file is not None:
            path = Path(self.file)
            return f"mesh file '{path}'", lambda: read_msh(path, layout.volume_groups, ROOTS)

        def make() -> MeshArrays:
            layout.check_clearance(self.hub_radius, self.root_radius)
            return place_blades(self.block, layout)

        return "mesh of the blades", make

    def list_mistakes(self, mesh: MeshArrays, layout: RotorLayout) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from being these blades."""
        found = examine_blades(mesh, layout, self).mistakes
        if mesh.reference != HEXAHEDRON:
            return (*found, "walls of laminates need quadratic hexahedra, one through the wall")
        try:
            self._tabulate(WallCells.read(self.shape, mesh.cell_data))
        except ModelError as error:
            return (*found, str(error))
        return found

    def describe(self, report: MeshReport, mesh: MeshArrays, layout: RotorLayout) -> list[str]:
        """Mass, centre, panels, webs, and where walls are thinner than the file's."""
        first = mesh.cell_groups == mesh.volumes[layout.volume_groups[0]]
        cells = WallCells.read(
            self.shape, {name: values[first] for name, values in mesh.cell_data.items()}
        )
        solids = mesh.points, mesh.cells[first], mesh.reference
        mass = cell_volumes(*solids) * self._tabulate(cells).density
        centre = mass @ (cell_centres(*solids) - layout.centre) / mass.sum()
        panels, webs = dict.fromkeys(self.shape.panels), self.shape.webs
        return [
            f"mass of a blade {mass.sum() / 1e3:.6g} t, centre of mass "
            f"{layout.frame(1)[0] @ centre - self.hub_radius:.4g} m from the root",
            f"{len(panels)} panels: {'; '.join(panels)}",
            *(f"{w.name} from {w.start:.3g} to {w.end:.3g} of the span" for w in webs),
            _describe_caps(cells, mass),
        ]

    def find_warnings(self, report: MeshReport) -> list[str]:
        """Nothing: the mass is that of the layup."""
        return []

    def make_plies(self, system: MultibodySystem, mesh: LoadedMesh) -> BladePlies:
        """Their plies, of all blades together. Collective.

        The plate at the tip, and the row of cells as long as the wall is thick that carries it,
        belong to no panel: no file describes them, and their corners are strained by how the mesh
        ends there. Nor do cells of a trailing edge that is hardly wider than thick.
        """
        comm = mesh.mesh.comm
        number = [body.full.mesh for body in system.flexible_bodies].index(mesh.mesh)
        body = system.flexible_bodies[number]
        cells = WallCells.read(self.shape, mesh.cell_data)
        stresses = PlyStresses(system, body, cells.find_plies())
        closed = comm.allreduce(bool(cells.is_tip.any()), op=MPI.LOR)
        last = comm.allreduce(float(np.max(cells.span[:, 0], initial=0.0)), op=MPI.MAX)
        made_up = cells.is_ridge | ((cells.span[:, 0] == last) & closed)
        numbers: dict[str, list[int]] = {}
        for part, name in enumerate(cells.panels):
            numbers.setdefault(name, []).append(part)
        every = {
            name: np.flatnonzero(np.isin(cells.part, own) & ~made_up)
            for name, own in numbers.items()
        }
        counts = np.sum(comm.allgather([len(own) for own in every.values()]), axis=0)
        panels = {name: every[name] for name, n in zip(every, counts, strict=True) if n}
        places = cells.span.mean(axis=1) * self.length
        bonds = {name: own[~made_up[own]] for name, own in cells.find_bonds(comm).items()}
        return BladePlies(stresses, panels, places, np.flatnonzero(made_up), bonds)

    def make_body(self, name: str, mesh: LoadedMesh, axes: tuple[Any, Any, Any]) -> FlexibleBody:
        """The blades as one body. Collective.

        Args:
            axes: Fields of the axes along span, chord and thickness, as UFL vectors.
        """
        table = self._tabulate(WallCells.read(self.shape, mesh.cell_data))
        material = self.material.add_viscosity(Laminate.from_table(mesh.mesh, table))
        density = cell_field(mesh.mesh, table.density)
        return FlexibleBody(name, mesh.mesh, material, density, self.degree, fibre=axes[0])


def _describe_caps(cells: WallCells, mass: Array) -> str:
    """Where walls would cross, and how much thinner they are there."""
    ratio = cells.wanted / cells.thickness
    worst = int(ratio.argmax())
    if ratio[worst] < CAPPED:
        return "all walls are as thick as in the file"
    share = 100.0 * mass[ratio > CAPPED].sum() / mass.sum()
    s0, s1 = cells.span[worst]
    return (
        f"walls are made thinner, with stiffness and density to match, where they would cross: "
        f"{share:.2g} % of the mass; most in {cells.parts[cells.part[worst]]!r} at "
        f"{s0:.3g} to {s1:.3g} of the span, "
        f"{1e3 * cells.wanted[worst]:.3g} mm to {1e3 * cells.thickness[worst]:.3g} mm"
    )

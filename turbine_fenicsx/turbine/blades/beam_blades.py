"""Blades that are beams of section matrices, of windIO or of another code."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NoReturn

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import LoadedMesh, MeshReport, RotorLayout, place_blades
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.reduction.beam_basis import beam_basis
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import moments_of
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.bare_shape import BareShape
from turbine_fenicsx.turbine.blades.beam_skin import BeamSkin
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades
from turbine_fenicsx.turbine.blades.shaped_blades import ShapedBlades
from turbine_fenicsx.turbine.case.blade_structure import BladeStructure, find_structure
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.beam import BeamCase
from turbine_fenicsx.turbine.tables.rigid_parts import Inertia
from turbine_fenicsx.windio.blade import WindIOBlade

DEGREE = 2
"""Polynomial degree of the cells of the carrier."""

OF_NODE, OF_INTERFACE = 9, 12
"""Displacements of a node of a beam, of its point and two directors, and of an interface."""

SLICES = 4000
"""Parts of the axis in sums over the mass."""

SPAN, AROUND = 40, 32
"""Elements of the mesh whose cells are the pieces of inclined walls."""

TO_SPAN = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""From x, y, z of windIO to a1, a2, a3 of `turbine_fenicsx.meshing.RotorLayout`."""


@dataclass(frozen=True, eq=False)
class BeamBlades(ShapedBlades[WindIOBlade | BeamSkin]):
    """Beams, a `turbine_fenicsx.turbine.blades.blade_plan.BladePlan`.

    Args:
        structure: Axis and matrices of one, from its root.
        span: Number of elements of the carrier along the span.
        around: Number of its elements around a section.
    """

    structure: BladeStructure
    span: int
    around: int
    elements: BeamCase
    degree: int = DEGREE

    @classmethod
    def of(cls, case: Case, comm: MPI.Intracomm) -> BeamBlades:
        """Those of a case with a windIO file, or with a file of beams alone. Collective."""
        file, b, m = case.turbine.file, case.blade, case.mesh
        structure = on_rank0(comm, lambda: find_structure(case))
        if file is None:
            skin = BeamSkin(b.geometry(), place_line(structure.line, b.hub_radius))
            return cls(skin, structure, m.span, m.around, b.beam)
        blade = replace(on_rank0(comm, lambda: load_turbine(file).blade), hub_radius=b.hub_radius)
        if case.has_beam_blades and b.beam.taper:
            structure = on_rank0(comm, lambda: _incline(structure, blade))
        return cls(blade, structure, m.span, m.around, b.beam)

    @cached_property
    def line(self) -> BeamLine:
        """The reference axis from the rotor centre along a1, a2, a3."""
        return place_line(self.structure.line, self.hub_radius)

    def axis_at(self, s: Array) -> Array:
        """Points of the reference axis, shape (m, 3) [m]."""
        return self.line.at(s * self.line.length)[0]

    def make_basis(self, carrier: Carrier, root: npt.NDArray[np.int32]) -> BeamBasis:
        """The basis of a blade that is held at its root. Collective."""
        e, sections = self.elements, self.structure.sections
        return beam_basis(carrier, self.line, sections, e.elements, e.degree, root, hold=e.hold)

    def find_inertia(self) -> Inertia:
        """Mass, centre of mass from the rotor centre, and tensor of inertia of one."""
        p, length = self.structure, self.line.length
        s = (np.arange(SLICES) + 0.5) / SLICES * length
        r, d = self.line.at(s)
        flat = p.inertia.reshape(len(p.stations), -1).T
        inertia = np.column_stack([np.interp(s, p.stations, row) for row in flat])
        A = length / SLICES * moments_of(inertia.reshape(-1, 6, 6))
        X = np.concatenate([r[:, None], d], axis=1)
        mass = float(A[:, 0, 0].sum())
        centre = np.einsum("kb,kbj->j", A[:, 0], X) / mass
        E = np.einsum("kai,kab,kbj->ij", X, A, X) - mass * np.outer(centre, centre)
        J = np.trace(E) * np.eye(3) - E
        a1, a2, a3 = (tuple(row) for row in J.tolist())
        return Inertia(mass, (0.0, 0.0, 0.0), tuple(centre.tolist()), (a1, a2, a3))

    def mesh_source(self, layout: RotorLayout) -> tuple[str, Callable[[], MeshArrays]]:
        """Name of the carrier, and the function that makes it on rank 0."""

        def make() -> MeshArrays:
            layout.check_clearance(self.hub_radius, self.root_radius)
            skin = self.shape
            carrier = skin if isinstance(skin, BeamSkin) else BareShape(skin)
            return place_blades(mesh_hollow(carrier, self.span, self.around), layout)

        return "mesh that carries the blades", make

    def list_mistakes(self, mesh: MeshArrays, layout: RotorLayout) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from carrying these blades."""
        found = examine_blades(mesh, layout, self).mistakes
        try:
            _ = self.structure.sections
        except ModelError as error:
            return (*found, str(error))
        return found

    def describe(self, report: MeshReport, mesh: MeshArrays, layout: RotorLayout) -> list[str]:
        """Mass, centre and elements of the beams."""
        inertia, e = self.find_inertia(), self.elements
        return [
            f"beams of {e.elements} elements of degree {e.degree}: mass of a blade "
            f"{inertia.mass / 1e3:.6g} t, centre of mass "
            f"{inertia.centre[0] - self.hub_radius:.4g} m from the root",
            f"unknowns: {OF_INTERFACE + OF_NODE * e.elements * e.degree} displacements of a blade",
        ]

    def find_warnings(self, report: MeshReport) -> list[str]:
        """Nothing: the mass is that of the matrices."""
        return []

    def make_plies(self, system: MultibodySystem, mesh: LoadedMesh) -> None:
        """Matrices have no plies."""
        return None

    def make_body(self, name: str, mesh: LoadedMesh, axes: tuple[Any, Any, Any]) -> NoReturn:
        """There is no body of a material."""
        raise ModelError(f"{name!r} is a beam of section matrices: no material of it is known")


def _incline(structure: BladeStructure, blade: WindIOBlade) -> BladeStructure:
    """The structure of a blade whose walls are inclined."""
    from turbine_fenicsx.turbine.blades.inclined_walls import find_inclination
    from turbine_fenicsx.turbine.blades.wall_rows import WallRows

    line = place_line(structure.line, blade.hub_radius)
    walls = WallRows.of(blade, line, SPAN, AROUND)
    more = find_inclination(walls, structure.stations)
    return replace(structure, stiffness=structure.stiffness + more)


def place_line(line: BeamLine, hub_radius: float) -> BeamLine:
    """An axis from the root of a blade, as one from the rotor centre along a1, a2, a3."""
    points = line.points @ TO_SPAN.T + [hub_radius, 0.0, 0.0]
    return BeamLine(line.stations, points, line.directors @ TO_SPAN.T)

"""Blades that are beams of the section matrices of a windIO file."""

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
from turbine_fenicsx.meshing import LoadedMesh, MeshReport, RotorLayout, place_blades
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.reduction.beam_basis import beam_basis
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections, moments_of
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.bare_shape import BareShape
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades
from turbine_fenicsx.turbine.blades.shaped_blades import ShapedBlades
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.beam import BeamCase
from turbine_fenicsx.turbine.tables.rigid_parts import Inertia
from turbine_fenicsx.windio.turbine import SectionProperties

DEGREE = 2
"""Polynomial degree of the cells of the carrier."""

ALONG, SLICES = 400, 4000
"""Points along a curved axis, and parts of it that sums over the mass have."""

TO_SPAN = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""From x, y, z of windIO to a1, a2, a3 of `turbine_fenicsx.meshing.RotorLayout`."""


@dataclass(frozen=True, eq=False)
class BeamBlades(ShapedBlades):
    """Beams, a `turbine_fenicsx.turbine.blades.blade_plan.BladePlan`.

    Args:
        properties: Matrices along the axis.
        viscosity: Times of the damping of each strain [s].
        span: Number of elements of the carrier along the span.
        around: Number of its elements around a section.
    """

    properties: SectionProperties
    viscosity: tuple[float, ...]
    span: int
    around: int
    elements: BeamCase
    degree: int = DEGREE

    @classmethod
    def of(cls, case: Case, comm: MPI.Intracomm) -> BeamBlades:
        """Those of a case with a windIO file. Collective."""
        file, b, m = case.turbine.file, case.blade, case.mesh
        assert file is not None
        turbine = on_rank0(comm, lambda: load_turbine(file))
        assert turbine.blade_sections is not None
        shape = replace(turbine.blade, hub_radius=b.hub_radius)
        mu = b.damping.mu or (0.0,) * 6
        return cls(shape, turbine.blade_sections, mu, m.span, m.around, b.beam)

    @cached_property
    def line(self) -> BeamLine:
        """The reference axis from the rotor centre along a1, a2, a3."""
        outer = self.shape.outer_shape
        stations = np.unique(np.concatenate([np.linspace(0.0, 1.0, ALONG), self.properties.grid]))
        points = outer.reference_points(stations) @ TO_SPAN.T
        points[:, 0] += self.hub_radius
        to_trailing, to_suction = outer.frames(stations)
        directors = np.stack([to_suction, to_trailing], axis=1) @ TO_SPAN.T
        return BeamLine(stations, points, directors)

    @cached_property
    def sections(self) -> BeamSections:
        """Stiffness and mass along the axis.

        Raises:
            ModelError: for matrices that no section can have, with the station.
        """
        p = self.properties
        assert p.stiffness is not None
        at = self.line.arc_length(p.grid)
        return BeamSections(at, p.stiffness, p.inertia, self.viscosity)

    def make_basis(self, carrier: Carrier, root: npt.NDArray[np.int32]) -> BeamBasis:
        """The basis of a blade that is held at its root. Collective."""
        e = self.elements
        return beam_basis(
            carrier, self.line, self.sections, e.elements, e.degree, root, hold=e.hold
        )

    def find_inertia(self) -> Inertia:
        """Mass, centre of mass from the rotor centre, and tensor of inertia of one."""
        p, length = self.properties, self.line.length
        s = (np.arange(SLICES) + 0.5) / SLICES * length
        r, d = self.line.at(s)
        at, flat = self.line.arc_length(p.grid), p.inertia.reshape(len(p.grid), -1).T
        inertia = np.column_stack([np.interp(s, at, row) for row in flat]).reshape(-1, 6, 6)
        A = length / SLICES * moments_of(inertia)
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
            return place_blades(mesh_hollow(BareShape(self.shape), self.span, self.around), layout)

        return "mesh that carries the blades", make

    def list_mistakes(self, mesh: MeshArrays, layout: RotorLayout) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from carrying these blades."""
        found = examine_blades(mesh, layout, self).mistakes
        try:
            _ = self.sections
        except ModelError as error:
            return (*found, str(error))
        return found

    def describe(self, report: MeshReport, mesh: MeshArrays, layout: RotorLayout) -> list[str]:
        """Mass, centre and elements of the beams."""
        inertia, e = self.find_inertia(), self.elements
        return [
            f"beams of {e.elements} elements of degree {e.degree}: mass of a blade "
            f"{inertia.mass / 1e3:.6g} t, centre of mass "
            f"{inertia.centre[0] - self.hub_radius:.4g} m from the root"
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

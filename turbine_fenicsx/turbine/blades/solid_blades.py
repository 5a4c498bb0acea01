"""Blades of one material with elliptic sections, solid or hollow, or of a mesh file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import (
    BladeGeometry,
    LoadedMesh,
    MeshOptions,
    MeshReport,
    RotorLayout,
    mesh_rotor,
    read_msh,
)
from turbine_fenicsx.meshing.hollow_shape import EllipticShape
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_mesh import examine_blades, find_curved_cells
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.tables.blade import find_mass_warning
from turbine_fenicsx.turbine.tables.material import MaterialCase


@dataclass(frozen=True)
class SolidBlades:
    """Blades of one material, a `turbine_fenicsx.turbine.blades.blade_plan.BladePlan`.

    Args:
        geometry: Shape of one.
        file: Mesh file to take instead; None makes a mesh.
        shape_given: Whether the case says the shape of the sections, beside a mesh file too.
    """

    geometry: BladeGeometry
    options: MeshOptions
    degree: int
    file: str | None
    material: MaterialCase
    shape_given: bool = True

    @classmethod
    def of(cls, case: Case) -> SolidBlades:
        """Those of a case."""
        m, b = case.mesh, case.blade
        return cls(
            b.geometry(),
            MeshOptions(
                m.cell, m.geometry_degree, m.elements, m.size, span=m.span, around=m.around
            ),
            2 if b.wall and m.file is None else m.degree,
            m.file,
            case.material,
            m.file is None or bool({"chord", "thickness"} & b.model_fields_set),
        )

    def find_inertia(self) -> None:
        """The case has those of rigid blades."""
        return None

    def rings(self, stations: int, around: int) -> Array:
        """Points of elliptic sections for pictures, shape (stations, around, 3) [m]."""
        blade, s = self.geometry, np.linspace(0.0, 1.0, stations)[:, None]
        angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
        across = 0.5 * blade.chord_at(s) * np.cos(angle)
        through = 0.5 * blade.thickness_at(s) * np.sin(angle)
        span = np.broadcast_to(blade.hub_radius + s * blade.length, across.shape)
        return blade.turn(np.stack([span, across, through], axis=-1))

    def axis_at(self, s: Array) -> Array:
        """Points of the pitch axis, shape (m, 3) [m]."""
        return np.column_stack([self.hub_radius + self.length * s, 0.0 * s, 0.0 * s])

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""
        return self.geometry.hub_radius

    @property
    def length(self) -> float:
        """From the root to the tip along the span [m]."""
        return self.geometry.length

    @property
    def tip(self) -> Array:
        """Position of the tip, shape (3,) [m]."""
        return np.array([self.hub_radius + self.length, 0.0, 0.0])

    @property
    def shape(self) -> EllipticShape | None:
        """Outer surface of one; None if only the mesh file has it."""
        return EllipticShape(self.geometry) if self.file is None else None

    @property
    def root_radius(self) -> float:
        """Radius of a circle around the root section [m]."""
        return 0.5 * max(self.geometry.chord[0], self.geometry.thickness[0])

    def mesh_source(self, layout: RotorLayout) -> tuple[str, Callable[[], MeshArrays]]:
        """Name of the mesh, and the function that makes or reads it on rank 0."""
        if self.file is None:
            return "mesh of the blades", lambda: mesh_rotor(self.geometry, layout, self.options)
        path = Path(self.file)
        return f"mesh file '{path}'", lambda: read_msh(path, layout.volume_groups, ROOTS)

    def list_mistakes(self, mesh: MeshArrays, layout: RotorLayout) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from being these blades."""
        curved = find_curved_cells(mesh.reference.degree, self.degree)
        return (*examine_blades(mesh, layout, self).mistakes, *curved)

    def describe(self, report: MeshReport, mesh: MeshArrays, layout: RotorLayout) -> list[str]:
        """Mass of the blades against that of the ideal shape, which a mesh file may not have.

        Args:
            report: Size, volumes and quality of their mesh.
        """
        volume, density = sum(report.volumes.values()), self.material.density
        text = f"mass of the blades {volume * density / 1e3:.6g} t"
        if not self.shape_given:
            return [text]
        ideal = self.geometry.volume * len(ROOTS)
        change, word = 100.0 * (volume / ideal - 1.0), "less" if volume < ideal else "more"
        of_ideal = f"{ideal * density / 1e3:.6g} t of the ideal shape"
        return [f"{text}, {abs(change):.2g} % {word} than {of_ideal}"]

    def find_warnings(self, report: MeshReport) -> list[str]:
        """A sentence if the blades of a mesh file have a mass that looks like a slip."""
        if self.file is None:  # that of a built-in mesh is told by the case alone
            return []
        mass = sum(report.volumes.values()) * self.material.density / len(ROOTS)
        return find_mass_warning(mass, self.length)

    def make_plies(self, system: MultibodySystem, mesh: LoadedMesh) -> None:
        """There are none."""
        return None

    def make_body(self, name: str, mesh: LoadedMesh, axes: tuple[Any, Any, Any]) -> FlexibleBody:
        """The blades as one body. Collective.

        Args:
            axes: Fields of the axes along span, chord and thickness, as UFL vectors.
        """
        m = self.material
        return FlexibleBody(name, mesh.mesh, m.make(axes), m.density, self.degree, fibre=axes[0])

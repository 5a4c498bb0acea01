"""Interface of blades before they are built, whatever they are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing import LoadedMesh, MeshReport, RotorLayout
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.system.ply_stresses import PlyStresses
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.tables.rigid_parts import Inertia

ROOTS = ("root_1", "root_2", "root_3")
"""Physical surfaces of a mesh of blades that move with the hub."""


@dataclass(frozen=True, eq=False)
class BladePlies:
    """Plies of the blades as the output needs them.

    Args:
        panels: Cells of each panel and web that this rank owns, of all blades together.
        place: Distance of each of these cells from the root [m].
        made_up: Cells that stand for no layup of the file: those that close the tip, and a trailing
            edge that is hardly wider than thick.
        bonds: Cells of this rank that end in a bond, by the name of the bond and its side.
    """

    stresses: PlyStresses
    panels: dict[str, IntArray]
    place: Array
    made_up: IntArray
    bonds: dict[str, IntArray]


class BladeSurface(Protocol):
    """Outer surface of a blade; see `turbine_fenicsx.meshing.hollow_shape.HollowShape`."""

    @property
    def panels(self) -> tuple[str, ...]:
        """Names of the n panels around a section; names may repeat."""

    def lines(self, s: Array) -> Array:
        """Contour fractions that bound the panels at span fractions s, shape (m, n + 1) [-]."""

    def leading(self, s: Array) -> Array:
        """Contour fraction of the leading edge at span fractions s, shape (m,) [-]."""

    def surface(self, s: Array, a: Array) -> Array:
        """Points at span and contour fractions, one axis more than the arguments [m]."""


class BladePlan(Protocol):
    """Blades of one kind. Positions are along a1, a2, a3 from the rotor centre."""

    def find_inertia(self) -> Inertia | None:
        """Mass, centre of mass and tensor of inertia of one in its axes a1, a2, a3.

        The centre counts from the rotor centre. None if the case has those of rigid blades.
        """

    def rings(self, stations: int, around: int) -> Array:
        """Points of the skin for pictures, shape (stations, around, 3) [m]."""

    def axis_at(self, s: Array) -> Array:
        """Points of the reference axis at fractions of its length, shape (m, 3) [m]."""

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""

    @property
    def length(self) -> float:
        """From the root to the tip along the span [m]."""

    @property
    def degree(self) -> int:
        """Polynomial degree of the displacement."""

    @property
    def tip(self) -> Array:
        """Position of the tip, shape (3,) [m]."""

    @property
    def shape(self) -> BladeSurface | None:
        """Outer surface of one; None if only the mesh file has it."""

    @property
    def root_radius(self) -> float:
        """Radius of a circle around the root section [m]."""

    def mesh_source(self, layout: RotorLayout) -> tuple[str, Callable[[], MeshArrays]]:
        """Name of the mesh, and the function that makes it on rank 0."""

    def list_mistakes(self, mesh: MeshArrays, layout: RotorLayout) -> tuple[str, ...]:
        """One sentence for everything that keeps a mesh from being these blades."""

    def describe(self, report: MeshReport, mesh: MeshArrays, layout: RotorLayout) -> list[str]:
        """Lines on mass and make for people.

        Args:
            report: Size, volumes and quality of their mesh.
        """

    def find_warnings(self, report: MeshReport) -> list[str]:
        """One sentence for everything in a mesh that looks like a slip."""

    def make_plies(self, system: MultibodySystem, mesh: LoadedMesh) -> BladePlies | None:
        """Their plies; None if they are of one material. Collective."""

    def make_body(self, name: str, mesh: LoadedMesh, axes: tuple[Any, Any, Any]) -> FlexibleBody:
        """The blades as one body. Collective.

        Args:
            axes: Fields of the axes along span, chord and thickness, as UFL vectors.
        """

"""The table of the mesh of the blades."""

from __future__ import annotations

from math import prod
from typing import Annotated, Any, Literal

import numpy as np

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile
from turbine_fenicsx.case.quantities import Metres
from turbine_fenicsx.case.rules import AnyOf, Beside, NotBeside, Only, Unless, With
from turbine_fenicsx.case.section import MAX_ELEMENTS, Count, Degree, Positive, Section
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.blade import SHAPE

_OF_FILE = NotBeside(
    "turbine.file",
    "which has the shape, meshed by mesh.span and mesh.around, of the blades",
)
_MADE = Beside("file")
_WALL = Beside("blade.wall", say="beside blade.wall, which takes quadratic hexahedra")
_NO_BEAM = Unless("blade.model", "beam")
_SOLID = (_OF_FILE, _MADE, _WALL, _NO_BEAM)
_HOLLOW = With("blade.wall", "turbine.file", "blade.beam.file")


class MeshCase(Section):
    """Mesh of the blades; ``file`` takes a custom mesh instead.

    Hollow blades have ``span`` elements along the span and ``around`` around a section; those of a
    windIO file end in a plate, or in an open ``tip``.
    """

    cell: Annotated[Literal["hexahedron", "tetrahedron"], *_SOLID] = "hexahedron"
    """Kind of the cells."""
    elements: Annotated[tuple[Count, Count, Count], *_SOLID, Beside("size")] = (2, 2, 12)
    """Numbers of elements along chord, thickness and span."""
    size: Annotated[Annotated[Metres, Positive] | None, *_SOLID] = None
    """Target length of element edges; takes the place of ``elements``."""
    degree: Annotated[Degree, _OF_FILE, AnyOf(_WALL, With("file")), _NO_BEAM] = 1
    """Polynomial degree of the displacement."""
    geometry_degree: Annotated[Degree, *_SOLID] = 1
    """2 for curved cells, with ``degree = 2`` only."""
    span: Annotated[Count, _MADE, _HOLLOW] = 40
    """Number of elements of hollow blades along the span."""
    around: Annotated[Count, _MADE, _HOLLOW] = 24
    """Number of elements of hollow blades around a section, webs not counted."""
    tip: Annotated[Literal["closed", "open"], _MADE, With("turbine.file"), _NO_BEAM] = "closed"
    """End of the blades of ``turbine.file``: ``"closed"`` by a plate, or ``"open"``, see
    howto/real_turbine."""
    file: Annotated[str | None, DataFile("mesh"), Only("turbine.model", "hybrid")] = None
    """Your own ``.msh`` file, relative to the case file, see howto/mesh; beside ``turbine.file``
    one that the command ``mesh`` has written for it."""

    @check("", *(f"blade.{key}" for key in SHAPE))
    def _check_size(self, case: Any) -> str:
        """The mesh of a blade has not absurdly many elements."""
        b = case.blade
        if self.file or not case.meshes_blades:
            return ""
        key, value = "elements", quote(list(self.elements))
        if self.size:
            key, value = "size", f"{self.size:g}"
        keys = f"mesh.{key} = {value}"
        if case.turbine.file or b.wall or b.model == "beam":
            count = float(self.span * self.around)
            keys = f"mesh.span = {self.span} and mesh.around = {self.around}"
        elif self.cell == "tetrahedron":
            count = self._count_bricks(b.geometry())
        elif self.size:
            widths = (max(b.chord), max(b.thickness), b.length)
            count = prod(width / self.size for width in widths)
        else:
            count = float(prod(self.elements))
        if count <= MAX_ELEMENTS:
            return ""
        return (
            f"{keys}: expected at most {MAX_ELEMENTS} elements in each blade, got some {count:.3g}"
        )

    def _count_bricks(self, shape: Any) -> float:
        """Number of bricks that fill a blade, with edges as long as those of its tetrahedra."""
        from turbine_fenicsx.meshing import MeshOptions  # no other case needs MPI

        options = MeshOptions(self.cell, elements=self.elements, size=self.size)
        s = np.linspace(0.0, 1.0, 500)
        h = np.interp(s, shape.stations, options.edge_lengths(shape))
        with np.errstate(all="ignore"):  # absurd shapes have infinitely many
            volumes = shape.chord_at(s) * shape.thickness_at(s) * shape.length
            return float(np.mean(volumes / h**3))

    @check("geometry_degree", "degree")
    def _check_curved_cells(self, case: Any) -> str:
        """Displacements can follow the shape of the cells, or a rotation would store energy."""
        if not case.has_solid_blades or self.file or case.blade.wall:
            return ""
        if self.geometry_degree <= self.degree:
            return ""
        return (
            f"mesh.geometry_degree = {self.geometry_degree}: expected at most mesh.degree = "
            f"{self.degree}, or a rigid rotation would store energy"
        )

"""Mesh options."""

from dataclasses import dataclass
from math import ceil, isfinite
from numbers import Integral, Real

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.meshing.blade import BladeGeometry

CELLS = ("hexahedron", "tetrahedron")


@dataclass(frozen=True)
class MeshOptions:
    """Cell type, geometry degree and fineness of a mesh.

    Attributes:
        cell: "hexahedron" or "tetrahedron".
        geometry_degree: 1 for flat, 2 for curved elements; not the degree of the fields on
            the mesh.
        elements: Numbers of elements along chord, thickness and span of one blade.
        size: Target length of element edges [m]; if given, it replaces ``elements``.
        span: Number of elements along the span of a hollow blade, which is always of hexahedra of
            degree 2.
        around: Number of elements around its sections.
    """

    cell: str = "hexahedron"
    geometry_degree: int = 1
    elements: tuple[int, int, int] = (2, 2, 12)
    size: float | None = None
    span: int = 40
    around: int = 24

    def __post_init__(self) -> None:
        if self.cell not in CELLS:
            raise ModelError(f"mesh.cell = {self.cell!r}: choose from {', '.join(CELLS)}")
        if self.geometry_degree not in (1, 2):
            raise ModelError(f"mesh.geometry_degree = {self.geometry_degree!r}: choose 1 or 2")
        numbers = tuple(self.elements) if isinstance(self.elements, list | tuple) else ()
        whole = [isinstance(n, Integral) and not isinstance(n, bool) for n in numbers]
        if len(numbers) != 3 or not all(whole) or min(numbers) < 1:
            raise ModelError(
                f"mesh.elements = {self.elements!r}: give three whole numbers from 1, "
                "along chord, thickness and span"
            )
        object.__setattr__(self, "elements", tuple(int(n) for n in numbers))
        for name, least in (("span", 1), ("around", 3)):
            number = getattr(self, name)
            if not isinstance(number, Integral) or isinstance(number, bool) or number < least:
                raise ModelError(f"mesh.{name} = {number!r}: give a whole number from {least}")
        if self.size is not None and not (
            isinstance(self.size, Real) and isfinite(self.size) and self.size > 0
        ):
            raise ModelError(f"mesh.size = {self.size!r}: must be a length greater than 0")

    def hexahedra(self, blade: BladeGeometry) -> tuple[int, int, int]:
        """Return the numbers of hexahedra along chord, thickness and span of a blade.

        With ``size`` no element is longer than that in the widest section or along the span.
        """
        if self.size is None:
            return self.elements
        widths = (max(blade.chord), max(blade.thickness), blade.length)
        chord, thickness, span = (max(1, ceil(width / self.size - 1e-9)) for width in widths)
        return chord, thickness, span

    def edge_lengths(self, blade: BladeGeometry) -> list[float]:
        """Return the target edge length of tetrahedra at each station [m].

        Tetrahedra have no long side, so the numbers of elements in the section rule. An edge is the
        geometric mean of chord and thickness of one brick of the section, and no longer than one
        brick along the span. With ``size`` it is that length. In both cases it is no longer than
        the local thickness, or a thin section would be filled with flat elements.
        """
        n_chord, n_thickness, n_span = self.elements
        lengths = []
        for chord, thickness in zip(blade.chord, blade.thickness, strict=True):
            if self.size is None:
                brick = (chord / n_chord * thickness / n_thickness) ** 0.5
                edge = min(brick, blade.length / n_span)
            else:
                edge = self.size
            lengths.append(min(edge, thickness, chord))
        return lengths

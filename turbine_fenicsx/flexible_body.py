"""Flexible bodies: a mesh, a material and a density."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from turbine_fenicsx.materials.base import Material
from turbine_fenicsx.rotations import Array


@dataclass(frozen=True, eq=False)
class FlexibleBody:
    """A 3D continuum with large deformations, position x = X + u.

    Args:
        name: Unique name.
        mesh: DOLFINx mesh of hexahedra or tetrahedra in the initial configuration [m].
        material: Strain energy.
        density: Reference density rho [kg/m^3], positive.
        degree: Polynomial degree of the displacement, 1 or 2.
        fibre: Direction field of the fibres, or of the span, in the initial configuration as a
            UFL vector: for output, and the slender direction for iterative solvers; or None.
        velocity: Initial velocity field [m/s], a function of positions of shape (n, 3) that returns
            as many velocities; that of the first carrier, or rest, if None.

    Raises:
        ValueError: for a density that is not positive, or a degree other than 1 or 2.
        TypeError: if the material is none.
    """

    name: str
    mesh: Any
    material: Material
    density: float
    degree: int = 1
    fibre: Any = None
    velocity: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        """Check the data."""
        if not self.density > 0.0:
            raise ValueError(
                f"density of flexible body {self.name!r} must be positive, got {self.density}"
            )
        if self.degree not in (1, 2):
            raise ValueError(f"degree of {self.name!r} must be 1 or 2, got {self.degree}")
        if not isinstance(self.material, Material):
            raise TypeError(f"material of {self.name!r} has no strain_energy: {self.material!r}")

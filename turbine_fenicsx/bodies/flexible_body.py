"""Flexible bodies: a mesh, a material and a density."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from dolfinx.mesh import Mesh
from ufl.core.expr import Expr

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.mesh_check import check_body_mesh
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Material
from turbine_fenicsx.materials.cell_fields import Scalar, check_cells


@dataclass(frozen=True, eq=False)
class FlexibleBody(DeformableBody):
    """A 3D continuum with large deformations, position x = X + u.

    Args:
        name: Unique name.
        mesh: DOLFINx mesh of hexahedra or tetrahedra in the initial configuration [m].
        material: Strain energy.
        density: Reference density rho [kg/m^3], positive, a number or a `cell_field`.
        degree: Polynomial degree of the displacement, 1 or 2.
        fibre: Direction field of the fibres, or of the span, in the initial configuration as a
            UFL vector: for output, and the slender direction for iterative solvers; or None.
        velocity: Initial velocity field [m/s], a function of positions of shape (n, 3), a point per
            row, that returns as many velocities; that of the first parent body, or rest, if None.
            (DOLFINx's interpolate has points as columns; what is written for it is refused.)
        displacement: Initial displacement u [m], such a function, or an array with a row for each
            node of this rank in the order of `FlexibleModel.positions`; zero if None. The stresses
            of the material act from t = 0 on. Nodes of couplings must stay where they are.

    Raises:
        ModelError: for a density that is not positive, a degree other than 1 or 2, or a mesh that
            is not three-dimensional or has other cells.
        TypeError: if the material is none, or the velocity or displacement no function.
    """

    name: str
    mesh: Mesh
    material: Material
    density: Scalar
    degree: int = 1
    fibre: Expr | None = None
    velocity: Callable[[Array], Array] | None = None
    displacement: Callable[[Array], Array] | Array | None = None

    def __post_init__(self) -> None:
        check_cells(
            f"density of flexible body {self.name!r} must be positive, got {{density}}",
            lambda rho: (rho > 0.0) & (rho < np.inf),
            density=self.density,
        )
        if not isinstance(self.material, Material):
            raise TypeError(
                f"material of {self.name!r} needs strain_energy() and quadratic, got "
                f"{describe(self.material)}"
            )
        if self.velocity is not None and not callable(self.velocity):
            raise TypeError(
                f"velocity of {self.name!r} must be a function of positions, got "
                f"{describe(self.velocity)}"
            )
        if not (
            self.displacement is None
            or callable(self.displacement)
            or isinstance(self.displacement, np.ndarray)
        ):
            raise TypeError(
                f"displacement of {self.name!r} must be a function of positions or an array, got "
                f"{describe(self.displacement)}"
            )
        check_body_mesh(self.name, self.mesh, self.degree)

    @property
    def full(self) -> FlexibleBody:  # type: ignore[override]
        """The body itself, as of bodies that another one was made of."""
        return self

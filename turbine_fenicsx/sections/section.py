"""The cross-section of a prism of any material: stiffness, mass, centres, stress."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from dolfinx import fem
from dolfinx.mesh import Mesh

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.section_matrices import make_inertia
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Material
from turbine_fenicsx.materials.cell_fields import Scalar
from turbine_fenicsx.sections import centres
from turbine_fenicsx.sections.prism import Prism, strain_along
from turbine_fenicsx.sections.saint_venant import UnitLoads, find_unit_loads


@dataclass(frozen=True, eq=False)
class Section:
    """A cross-section, made by `analyse_section`.

    Rows and columns of matrices are forces and strains along x, y, z, then moments and curvatures
    about them: gamma_x, gamma_y, eps, kappa_x, kappa_y, kappa_z. All are about the origin.

    Args:
        stiffness: Symmetric, positive definite, shape (6, 6) [N, N m, N m^2].
        inertia: Mass matrix, shape (6, 6) [kg/m, kg, kg m].
        mass_centre: Shape (2,) [m].
        prism: The section as matrices of its displacements.
        unit_loads: Its displacements under unit loads.
    """

    stiffness: Array
    inertia: Array
    mass_centre: Array
    prism: Prism
    unit_loads: UnitLoads

    @property
    def compliance(self) -> Array:
        """Strains under unit loads, shape (6, 6)."""
        return self.unit_loads.compliance

    @property
    def mesh(self) -> Mesh:
        """The mesh of the section."""
        return self.prism.mesh

    @property
    def mass(self) -> float:
        """Mass per length [kg/m]."""
        return float(self.inertia[2, 2])

    @cached_property
    def tension_centre(self) -> Array:
        """Point where a force along z does not bend the section, shape (2,) [m]."""
        return centres.find_tension_centre(self.compliance)

    @cached_property
    def shear_centre(self) -> Array:
        """Point where forces across do not twist the section, shape (2,) [m]."""
        return centres.find_shear_centre(self.compliance)

    @property
    def torsion_stiffness(self) -> float:
        """Moment about z per rate of twist, where the section is free otherwise [N m^2]."""
        return float(1.0 / self.compliance[5, 5])

    @property
    def bending(self) -> tuple[Array, float]:
        """Smaller and larger bending stiffness [N m^2], and the direction of the first axis.

        The direction is the angle from x [rad].
        """
        return centres.find_principal_axes(self.compliance)

    def warping(self, loads: npt.ArrayLike) -> fem.Function:
        """Displacement within the section under forces and moments of the section.

        Args:
            loads: Forces along x, y, z and moments about them, shape (6,) [N, N m].

        Returns:
            Function of vectors [m].
        """
        return self._combine(self.unit_loads.warping, loads)

    def stress(self, loads: npt.ArrayLike) -> fem.Function:
        """Stress under forces and moments of the section.

        Args:
            loads: Forces along x, y, z and moments about them, shape (6,) [N, N m].

        Returns:
            Function of tensors that is a polynomial in each cell [Pa].
        """
        prism = self.prism
        strain = prism.strain_across(self.warping(loads))
        strain += strain_along(self._combine(self.unit_loads.derivative, loads))
        found = fem.Function(_compat.cellwise_space(prism.mesh, (3, 3), prism.degree))
        found.interpolate(_compat.expression(prism.stress(strain), found.function_space))
        return found

    def _combine(self, unit: Array, loads: npt.ArrayLike) -> fem.Function:
        """The sum of displacements under unit loads."""
        found = fem.Function(self.prism.space)
        found.x.array[:] = unit @ check_loads(loads)
        return found


def check_loads(loads: npt.ArrayLike) -> Array:
    """Three forces and three moments of a section, shape (6,)."""
    return check_array("loads of a section", loads, (6,), "three forces and three moments")


def analyse_section(
    mesh: Mesh, material: Material, density: Scalar = 1.0, *, degree: int = 2
) -> Section:
    """Find stiffness, mass and stress of the section of a prism by finite elements.

    The prism extends along z. Its energy is that of Saint-Venant's solutions: warping and shear of
    any material are exact but for the mesh, and ends are far away.

    Args:
        mesh: Mesh of the section in the plane of x and y, of one rank (``MPI.COMM_SELF``) [m].
        material: Its law; of one that is not quadratic the stiffness at rest counts, and viscosity
            is left out. Axes of an anisotropic law are vectors of space, z along the prism.
        density: A number, or a `cell_field` [kg/m^3].
        degree: Polynomial degree of displacements.

    Raises:
        ModelError: if the mesh is not of a section, is distributed or does not hang together, or
            the mass is not positive.
    """
    if degree < 1:
        raise ModelError(f"degree of a section must be 1 or more, got {degree}")
    prism = Prism(mesh, material, density, degree)
    mass, centre, seconds = prism.find_inertia()
    loads = find_unit_loads(prism)
    inertia = make_inertia(np.array([mass]), centre[None], seconds[None])[0]
    return Section(np.linalg.inv(loads.compliance), inertia, centre, prism, loads)

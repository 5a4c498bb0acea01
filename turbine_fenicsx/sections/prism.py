"""Energy of a prism per length, in the displacements of its section.

With u(x, y, z) in the section and its derivative u' along z, the strain is

    E = B u + S u',    B u = sym(u_{i,x} e_i e_x + u_{i,y} e_i e_y),    S u = sym(u e_z),

and the strain energy per length is quadratic,

    W = (u.E u + 2 u.C u' + u'.M u')/2,

where the entries of the matrices are integrals over the section of B v : D : B u, B v : D : S u and
S v : D : S u, with the elasticity D at rest.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from scipy import sparse
from ufl.core.expr import Expr

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.base import Material, Sampled, stress_at_rest
from turbine_fenicsx.materials.cell_fields import Scalar, parameters_on

FLATNESS = 1e-9
"""Largest distance of nodes from their plane, relative to the size of the section."""


class Prism:
    """A section of a prism as matrices of its displacements.

    Args:
        mesh: Mesh of the section, of one rank.
        material: Its law.
        density: Mass per volume [kg/m^3].
        degree: Polynomial degree of displacements.

    Attributes:
        space: Space of the displacements, with n degrees of freedom.
        modes: Displacements whose derivative along z is that of a rigid section under the strains
            gamma_x, gamma_y, eps, kappa_x, kappa_y, kappa_z, shape (n, 6).

    Raises:
        ModelError: if the mesh is not of a section in a plane of x and y, or is distributed.
    """

    def __init__(self, mesh: Mesh, material: Material, density: Scalar, degree: int) -> None:
        _check_mesh(mesh)
        self.mesh, self.degree = mesh, degree
        self._parameter = parameters_on(mesh, "section")
        self._material, self._density = material, density
        self.space = _compat.vector_space(mesh, degree)
        x, y = self.space.tabulate_dof_coordinates()[:, :2].T
        one, none = np.ones_like(x), np.zeros_like(x)
        rows = [
            [one, none, none, none, none, -y],
            [none, one, none, none, none, x],
            [none, none, one, y, -x, none],
        ]
        self.modes: Array = np.array(rows).transpose(2, 0, 1).reshape(-1, 6)

    @cached_property
    def _arguments(self) -> tuple[Any, Any]:
        return ufl.TestFunction(self.space), ufl.TrialFunction(self.space)

    @cached_property
    def across(self) -> sparse.csr_matrix:
        """E, shape (n, n) [N/m^2]."""
        v, u = self._arguments
        return self._integrate(ufl.inner(self.strain_across(v), self.stress(self.strain_across(u))))

    @cached_property
    def mixed(self) -> sparse.csr_matrix:
        """C, shape (n, n) [N/m]."""
        v, u = self._arguments
        return self._integrate(ufl.inner(self.strain_across(v), self.stress(strain_along(u))))

    @cached_property
    def along(self) -> sparse.csr_matrix:
        """M, shape (n, n) [N]."""
        v, u = self._arguments
        return self._integrate(ufl.inner(strain_along(v), self.stress(strain_along(u))))

    @cached_property
    def overlap(self) -> sparse.csr_matrix:
        """Integrals of v.u, shape (n, n) [m^2]."""
        v, u = self._arguments
        return _assemble(ufl.inner(v, u) * ufl.dx(domain=self.mesh))

    def strain_across(self, u: Expr) -> Expr:
        """B u, shape (3, 3)."""
        columns = ufl.grad(u)
        if self.mesh.geometry.dim == 3:  # of a surface in space: zero along its normal
            return ufl.sym(columns)
        return ufl.sym(ufl.as_matrix([[columns[i, 0], columns[i, 1], 0.0] for i in range(3)]))

    def stress(self, E: Expr) -> Expr:
        """The stress D : E, shape (3, 3) [Pa]."""
        return stress_at_rest(lambda C: self._material.strain_energy(C, self._parameter), E)

    def find_inertia(self) -> tuple[float, Array, Array]:
        """Mass per length [kg/m], its centre [m], and int rho (x^2, y^2, x y) dA [kg m]."""
        x = ufl.SpatialCoordinate(self.mesh)
        dx = ufl.dx(domain=self.mesh, metadata={"quadrature_degree": 2 * self.degree + 2})
        rho = self._parameter(self._density)
        parts = 1.0, x[0], x[1], x[0] ** 2, x[1] ** 2, x[0] * x[1]
        sums = [fem.assemble_scalar(_compat.compile_form(rho * p * dx)) for p in parts]
        mass = float(sums[0])
        if not mass > 0.0:
            raise ModelError(f"mass of a section must be positive, got {mass:g} kg/m")
        return mass, np.array(sums[1:3]) / mass, np.array(sums[3:])

    def _integrate(self, density: Expr) -> sparse.csr_matrix:
        """A bilinear form of the energy."""
        data: dict[str, Any] = {"quadrature_degree": 2 * self.degree}
        if isinstance(self._material, Sampled) and self._material.quadrature is not None:
            points, weights = self._material.quadrature
            data |= {
                "quadrature_rule": "custom",
                "quadrature_points": points[:, 1:].tolist(),  # around and through a wall
                "quadrature_weights": weights.tolist(),
            }
        return _assemble(density * ufl.dx(domain=self.mesh, metadata=data))


def strain_along(u: Expr) -> Expr:
    """S u, shape (3, 3)."""
    return ufl.sym(ufl.outer(u, ufl.as_vector([0.0, 0.0, 1.0])))


def _assemble(form: Any) -> sparse.csr_matrix:
    """A bilinear form as a matrix of SciPy."""
    compiled = _compat.compile_form(form)
    matrix = _compat.create_matrix(compiled)
    _compat.assemble_matrix(matrix, compiled)
    starts, columns, values = matrix.getValuesCSR()
    return sparse.csr_matrix((values, columns, starts), shape=matrix.size)


def _check_mesh(mesh: Mesh) -> None:
    """Raise a ModelError unless the mesh is a flat section of one rank."""
    if mesh.topology.dim != 2:
        raise ModelError(
            f"a section needs a mesh of triangles or quadrilaterals, got one of the dimension "
            f"{mesh.topology.dim}"
        )
    if mesh.comm.size > 1:
        raise ModelError(
            f"a section needs a mesh of one rank, on MPI.COMM_SELF, got one on {mesh.comm.size}"
        )
    x = mesh.geometry.x
    if np.ptp(x[:, 2]) > FLATNESS * np.ptp(x[:, :2]):
        raise ModelError(
            f"a section must lie in a plane of one z, but its nodes lie between z = "
            f"{x[:, 2].min():g} and {x[:, 2].max():g} m"
        )

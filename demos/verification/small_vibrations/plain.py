"""Frequencies of an elastic body by DOLFINx and SLEPc alone, as anybody would write it.

Linear elasticity, a sparse factor of the free degrees of freedom, and nothing of the package's
equations, bodies or solvers: what its modes are compared with.
"""

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem

from turbine_fenicsx import _compat


def frequencies(mesh, lame, density, count, shift, degree=2, clamped=None):
    """Frequencies [Hz], ascending.

    Args:
        mesh: The mesh.
        lame: Lambda and mu [Pa].
        density: rho [kg/m^3].
        count: Number of frequencies.
        shift: Square of a frequency that is added to all [rad^2/s^2].
        degree: Of the elements.
        clamped: Facets whose nodes do not move; none if None.
    """
    from slepc4py import SLEPc

    V = _compat.vector_space(mesh, degree)
    u, w = ufl.TrialFunction(V), ufl.TestFunction(V)
    strain = ufl.sym(ufl.grad(u))
    stress = lame[0] * ufl.tr(strain) * ufl.Identity(3) + 2.0 * lame[1] * strain
    K, M = (
        _assemble(form * ufl.dx)
        for form in (ufl.inner(stress, ufl.grad(w)), density * ufl.inner(u, w))
    )
    if clamped is not None:
        nodes = fem.locate_dofs_topological(V, 2, clamped)
        held = (3 * nodes[:, None] + np.arange(3)).ravel()
        first, last = K.getOwnershipRange()
        free = first + np.setdiff1d(np.arange(last - first), held)
        rows = PETSc.IS().createGeneral(free.astype(PETSc.IntType), comm=mesh.comm)
        K, M = K.createSubMatrix(rows, rows), M.createSubMatrix(rows, rows)
    eps = SLEPc.EPS().create(mesh.comm)
    K.axpy(shift, M)
    eps.setOperators(K, M)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setDimensions(count)
    eps.setTolerances(1e-14)
    eps.setTarget(0.0)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.getST().setType(SLEPc.ST.Type.SINVERT)
    ksp = eps.getST().getKSP()
    ksp.setType("preonly")
    ksp.getPC().setType("lu")
    ksp.getPC().setFactorSolverType("mumps")
    eps.solve()
    squares = [eps.getEigenvalue(k).real - shift for k in range(count)]
    eps.destroy()
    return np.sqrt(np.maximum(np.sort(squares), 0.0)) / (2.0 * np.pi)


def _assemble(form):
    compiled = _compat.compile_form(form)
    matrix = _compat.create_matrix(compiled)
    _compat.assemble_matrix(matrix, compiled)
    return matrix

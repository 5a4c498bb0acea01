"""Conjugate gradients for the free nodes of a slender body, beyond what a factor can hold."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.coupling import CouplingBlock
from turbine_fenicsx.flexible_block import FlexibleBlock
from turbine_fenicsx.linear.sections import section_motions


class SectionMultigrid:
    """Conjugate gradients, preconditioned by two-level multigrid with section motions.

    The smoother (symmetric Gauss-Seidel) sees the short waves, the coarse space of
    `section_motions` the long ones, whose stiffness is by orders of magnitude smaller in a slender
    body. All of it is PETSc's PCMG; the levels have the options prefixes ``..._mg_levels_`` and
    ``..._mg_coarse_``.

    Args:
        flexible: The body.
        coupling: Its couplings.
        matrix: A_II, symmetric positive definite.
        free: Free degrees of freedom in global numbers.
        prefix: Options prefix.
        tolerance: Relative residual of each solve; `QuasiNewton` needs no more.
    """

    def __init__(
        self,
        flexible: FlexibleBlock,
        coupling: CouplingBlock,
        matrix: PETSc.Mat,
        free: PETSc.IS,
        prefix: str,
        tolerance: float = 1e-2,
    ) -> None:
        """Build the coarse space."""
        nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
        self._matrix = matrix
        self._P = section_motions(flexible, nodes, free)
        self._coarse = matrix.PtAP(self._P)
        self._ksp = ksp = PETSc.KSP().create(matrix.getComm())
        ksp.setOptionsPrefix(prefix)
        ksp.setOperators(matrix)
        ksp.setType("cg")
        ksp.setNormType(PETSc.KSP.NormType.NATURAL)
        ksp.setTolerances(rtol=tolerance, max_it=500)
        pc = ksp.getPC()
        pc.setType("mg")
        pc.setMGLevels(2)
        pc.setMGInterpolation(1, self._P)
        smoother, coarse = pc.getMGSmoother(1), pc.getMGCoarseSolve()
        smoother.setType("richardson")
        smoother.setTolerances(max_it=1)
        smoother.getPC().setType("sor")
        coarse.setType("preonly")
        coarse.getPC().setType("cholesky")
        coarse.getPC().setFactorSolverType("mumps")
        coarse.setOperators(self._coarse)
        ksp.setFromOptions()
        self.iterations = 0

    def update(self) -> None:
        """Project the present values of the matrix to the coarse space and factorise there."""
        self._matrix.PtAP(self._P, result=self._coarse)
        diagonal = self._coarse.getDiagonal()
        self._coarse.shift(1e-12 * diagonal.max()[1])  # sections without nodes
        diagonal.destroy()
        self._ksp.setUp()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""
        self._ksp.solve(b, x)
        self.iterations += self._ksp.getIterationNumber()

    def destroy(self) -> None:
        """Free everything."""
        for thing in (self._ksp, self._coarse, self._P):
            thing.destroy()

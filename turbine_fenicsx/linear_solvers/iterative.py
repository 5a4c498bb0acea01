"""Conjugate gradients for the free nodes of a slender body, beyond what a factor can hold."""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.petsc_options import default_options
from turbine_fenicsx.linear_solvers.factor import FreeSolver
from turbine_fenicsx.linear_solvers.sections import section_motions
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel

DIAGONAL = 1.1
"""Factor of the diagonal of the matrix that the smoother factorises. From 1.02 to 1.4 hardly any
iteration is lost, for stiff, soft and nearly incompressible blades."""


MOST_ITERATIONS = 100
"""Solid bodies take two to three iterations for a solve, thin walls several hundred."""


class SectionMultigrid(FreeSolver):
    """Conjugate gradients, preconditioned by two-level multigrid with section motions.

    The smoother sees the short waves, the coarse space of `section_motions` the long ones, whose
    stiffness is by orders of magnitude smaller in a slender body. As its lattices are some elements
    wide, whatever the mesh, iterations do not grow with refinement. The smoother is one Chebyshev
    step with an incomplete Cholesky factor in blocks of 3 x 3, block-Jacobi over the ranks. The
    factor is that of the matrix with a larger diagonal (`DIAGONAL`), as that of the matrix itself
    is indefinite for nearly incompressible material. All of it is PETSc's PCMG; the levels have
    the options prefixes ``..._mg_levels_`` and ``..._mg_coarse_``.

    Thin walls are not for it: their bending lies between the two, shorter than the lattices and
    soft. They do not need it either, as the factor of a wall grows hardly faster than its mesh.

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
        flexible: FlexibleModel,
        coupling: CouplingBlock,
        matrix: PETSc.Mat,
        free: PETSc.IS,
        prefix: str,
        tolerance: float = 1e-2,
    ) -> None:
        """Build the coarse space."""
        nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
        self._matrix, self._blocks = matrix, block_matrix(matrix)
        self._definite = self._blocks.copy()
        self._P = section_motions(flexible, nodes, free)
        self._coarse = matrix.PtAP(self._P)
        self._ksp = ksp = PETSc.KSP().create(matrix.getComm())
        ksp.setOptionsPrefix(prefix)
        ksp.setOperators(self._blocks)
        ksp.setType("cg")
        ksp.setNormType(PETSc.KSP.NormType.NATURAL)
        ksp.setTolerances(rtol=tolerance, max_it=MOST_ITERATIONS)
        pc = ksp.getPC()
        pc.setType("mg")
        pc.setMGLevels(2)
        pc.setMGInterpolation(1, self._P)
        smoother, coarse = pc.getMGSmoother(1), pc.getMGCoarseSolve()
        smoother.setType("chebyshev")
        smoother.setTolerances(max_it=1)
        smoother.setOperators(self._blocks, self._definite)
        smoother.getPC().setType("bjacobi")
        coarse.setType("preonly")
        coarse.getPC().setType("cholesky")
        coarse.getPC().setFactorSolverType("mumps")
        coarse.setOperators(self._coarse)
        ksp.setFromOptions()
        self._sub_type = f"{prefix}mg_levels_sub_pc_type"
        self.iterations = 0
        self._name, self._tried = flexible.body.name, False

    def update(self) -> None:
        """Project the present values of the matrix to the coarse space and factorise there.

        Raises:
            ModelError: if it does not converge for the first matrix.
        """
        self._matrix.convert("baij", self._blocks)
        self._blocks.copy(self._definite, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        diagonal = self._blocks.getDiagonal()
        diagonal.scale(DIAGONAL)
        self._definite.setDiagonal(diagonal)
        diagonal.destroy()
        self._matrix.PtAP(self._P, result=self._coarse)
        diagonal = self._coarse.getDiagonal()
        self._coarse.shift(1e-12 * diagonal.max()[1])  # points with few nodes
        diagonal.destroy()
        rows = self._matrix.getLocalSize()[0]
        sub_type = "icc" if rows else "none"  # icc crashes without rows
        with default_options(None, {self._sub_type: sub_type}):  # there is no other way to set it
            self._ksp.setUp()
        if not self._tried:
            self._try()

    def _try(self) -> None:
        """Solve for arbitrary forces."""
        x, b = self._matrix.createVecs()
        b.array[:] = np.random.default_rng(self._matrix.getComm().rank).normal(size=b.local_size)
        self._ksp.solve(b, x)
        x.destroy()
        b.destroy()
        self._tried = True
        if self._ksp.getConvergedReason() < 0:
            raise ModelError(
                f"the iterative solver does not suit body {self._name!r}: conjugate gradients take "
                f"more than {MOST_ITERATIONS} iterations for a solve, as in thin walls; use "
                'solver.linear_solver = "frozen", whose factor of thin walls is small'
            )

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for one right-hand side."""
        self._ksp.solve(b, x)
        self.iterations += self._ksp.getIterationNumber()

    def destroy(self) -> None:
        """Free everything."""
        for thing in (self._ksp, self._coarse, self._P, self._blocks, self._definite):
            thing.destroy()


def block_matrix(matrix: PETSc.Mat) -> PETSc.Mat:
    """A copy of a matrix, stored in blocks of 3 x 3. Collective.

    PETSc converts into a matrix that exists, but takes a time that grows with the square of the
    size to make a new one (a minute for 220 000 rows), so that the new one is made here.

    Args:
        matrix: All rows and columns of a node next to each other, with the same entries in each of
            the three rows: all three directions of a node are free or none. Its block size is
            set to 3.
    """
    matrix.setBlockSize(3)
    indptr, columns, _ = matrix.getValuesCSR()
    starts, lengths = indptr[:-1:3], np.diff(indptr)[::3] // 3
    block_ptr = np.concatenate([[0], np.cumsum(lengths)])
    place = np.arange(block_ptr[-1]) - np.repeat(block_ptr[:-1], lengths)
    block_columns = columns[np.repeat(starts, lengths) + 3 * place] // 3
    csr = (block_ptr.astype(PETSc.IntType), block_columns.astype(PETSc.IntType), None)
    blocks = PETSc.Mat().createBAIJ(matrix.getSizes(), 3, csr=csr, comm=matrix.getComm())
    blocks.assemble()
    return matrix.convert("baij", blocks)

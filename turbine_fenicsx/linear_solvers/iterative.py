"""Conjugate gradients for the free nodes of a slender solid body.

Choose it for two reasons only. The first is memory: the factor does not fit. The second is the
number of ranks: beyond some, the factor no longer gains from more. A factor that fits takes a
fourth to a sixth of the time. Matrices are stored as their upper triangles of 3 x 3 blocks: half to
keep and to read.
"""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.petsc_options import default_options
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.factor import FreeSolver
from turbine_fenicsx.linear_solvers.sections import section_motions
from turbine_fenicsx.linear_solvers.symmetric import GatheredFactor
from turbine_fenicsx.system.coupling_block import CouplingBlock
from turbine_fenicsx.system.flexible_model import FlexibleModel


def take_upper_triangle(matrix: PETSc.Mat) -> PETSc.Mat:
    """A symmetric positive definite matrix, stored as the upper triangle of its blocks. Collective.

    PETSc's own conversion takes a time that grows with the square of the size.

    Args:
        matrix: All rows and columns of a node next to each other, with the same entries in each of
            the three rows: all three directions of a node are free or none.
    """
    csr = _take_blocks(matrix, diagonal=False)
    found = PETSc.Mat().createSBAIJ(matrix.getSizes(), 3, csr=csr, comm=matrix.getComm())
    found.assemble()
    found.setOption(PETSc.Mat.Option.SPD, True)
    return found


def take_diagonal(matrix: PETSc.Mat) -> PETSc.Mat:
    """The diagonal blocks of such a matrix. Collective."""
    csr = _take_blocks(matrix, diagonal=True)
    found = PETSc.Mat().createBAIJ(matrix.getSizes(), 3, csr=csr, comm=matrix.getComm())
    found.assemble()
    return found


def _take_blocks(matrix: PETSc.Mat, diagonal: bool) -> tuple[Array, ...]:
    """Blocks of this rank's rows on the diagonal, or there and beyond, in compressed rows."""
    starts, columns, values = matrix.getValuesCSR()
    lengths = np.diff(starts)[::3].astype(np.int64)  # entries of each of the three rows of a node
    row = np.repeat(np.arange(lengths.size), lengths // 3)
    before = np.cumsum(lengths) - lengths
    place = 3 * (np.arange(row.size) - before[row] // 3) + starts[:-1:3].astype(np.int64)[row]
    column, this = columns[place] // 3, row + matrix.getOwnershipRange()[0] // 3
    chosen = column == this if diagonal else column >= this
    row, column, place = row[chosen], column[chosen], place[chosen]
    blocks = np.empty((row.size, 3, 3))
    for i in range(3):
        blocks[:, i] = values[(place + i * lengths[row])[:, None] + np.arange(3)]
    ends = np.cumsum(np.bincount(row, minlength=lengths.size))
    block_starts = np.concatenate([[0], ends]).astype(PETSc.IntType)
    return block_starts, column.astype(PETSc.IntType), blocks.ravel()


SMOOTHING = 4
"""Chebyshev iterations before and after the coarse solve."""

SMOOTHED = "0,0.05,0,1.1"
"""Of the eigenvalues up to the largest one by estimate, those from a twentieth of it to a tenth
beyond it are smoothed."""

MOST_ITERATIONS = 100
"""Solid bodies take two to four iterations for a solve, thin walls several hundred."""

TRIED = 1e-5
"""Relative residual, in the norm of the preconditioner, by which a body is tried."""


class SectionMultigrid(FreeSolver):
    """Conjugate gradients, preconditioned by two-level multigrid with section motions.

    The smoother sees the short waves, the coarse space of `section_motions` the long ones, whose
    stiffness is by orders of magnitude smaller in a slender body. The smoother is Chebyshev's with
    the inverse 3 x 3 blocks of the nodes, so that iterations do not depend on how many ranks share
    the body, and what it sends goes to neighbours. The coarse problem is so small that each rank
    solves all of it (`GatheredFactor`). All of it is PETSc's PCMG; the levels have the options
    prefixes ``..._mg_levels_`` and ``..._mg_coarse_``.

    Thin walls are not for it: their bending lies between the two, shorter than sections are wide
    and soft. They do not need it either, as the factor of a wall grows hardly faster than its mesh.

    Args:
        matrix: A_II, symmetric positive definite; destroyed in `update`, when it has been copied.
        free: Free degrees of freedom in global numbers.
        tolerance: Relative error of each solve, in the norm of the energy; `QuasiNewton` needs no
            more.
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
        self._assembled, self._prefix, self._tolerance = matrix, prefix, tolerance
        self._energies: list[float] = []
        self._P = section_motions(flexible, nodes)
        self._R = PETSc.Mat().createTranspose(self._P)
        self._made: list[PETSc.Object] = []
        self.iterations = 0
        self._name, self._tried = flexible.body.name, False

    def update(self) -> None:
        """Project the present values of the matrix to the coarse space and factorise there."""
        self._free()
        self._assembled.setBlockSize(3)
        self._matrix = take_upper_triangle(self._assembled)
        diagonal = take_diagonal(self._assembled)
        coarse = self._assembled.PtAP(self._P)
        self._assembled.destroy()
        sizes = coarse.getDiagonal()
        coarse.shift(1e-12 * sizes.max()[1])  # sections with few nodes
        self._ksp = self._make_solver(diagonal, coarse)
        self._made = [self._ksp, self._matrix, diagonal, coarse, sizes]
        with default_options(self._prefix, {"mg_levels_ksp_chebyshev_esteig": SMOOTHED}):
            self._ksp.setUp()
        if not self._tried:
            self._try()

    def _make_solver(self, diagonal: PETSc.Mat, coarse: PETSc.Mat) -> PETSc.KSP:
        """Conjugate gradients with multigrid; nothing is factorised yet."""
        ksp = PETSc.KSP().create(self._matrix.getComm())
        ksp.setOptionsPrefix(self._prefix)
        ksp.setOperators(self._matrix)
        ksp.setType("cg")
        ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        ksp.setConvergenceTest(self._judge)
        ksp.setTolerances(rtol=self._tolerance, max_it=MOST_ITERATIONS)
        pc = ksp.getPC()
        pc.setType("mg")
        pc.setMGLevels(2)
        pc.setMGInterpolation(1, self._P)
        pc.setMGRestriction(1, self._R)  # PETSc cannot tell a square P from its transpose
        smoother, solver = pc.getMGSmoother(1), pc.getMGCoarseSolve()
        smoother.setType("chebyshev")
        smoother.setTolerances(max_it=SMOOTHING)
        smoother.setOperators(self._matrix, diagonal)
        smoother.getPC().setType("pbjacobi")
        solver.setType("preonly")
        solver.setOperators(coarse)
        solver.getPC().setType("python")
        solver.getPC().setPythonContext(GatheredFactor())
        ksp.setFromOptions()
        return ksp

    def _judge(self, ksp: PETSc.KSP, iteration: int, residual: float) -> int:
        """Whether the error is small, by how the energy b . x approaches its limit.

        In conjugate gradients x . A x = b . x, so that the square of the error in the norm of the
        energy falls by what b . x grows. The rest is estimated as that of a geometric series. A
        test of preconditioned residuals would take one more preconditioner per solve.
        """
        reason, (tolerance, _, _, most) = PETSc.KSP.ConvergedReason, ksp.getTolerances()
        self._energies = self._energies[-2:] if iteration else []
        self._energies.append(ksp.getRhs().dot(ksp.getSolution()))
        found = reason.DIVERGED_MAX_IT if iteration >= most else reason.ITERATING
        if len(self._energies) == 3:
            before, last = np.diff(self._energies)
            if last**2 <= tolerance**2 * self._energies[-1] * (before - last):
                found = reason.CONVERGED_RTOL
        if residual == 0.0:
            found = reason.CONVERGED_ATOL
        if not np.isfinite(residual):
            found = reason.DIVERGED_NANORINF
        return int(found)

    def _try(self) -> None:
        """Solve for arbitrary forces until no doubt is left: in thin walls soft motions hide."""
        self._ksp.setNormType(PETSc.KSP.NormType.NATURAL)
        self._ksp.setConvergenceTest(None)
        tolerance = self._ksp.getTolerances()[0]
        self._ksp.setTolerances(rtol=TRIED)
        x, b = self._matrix.createVecs()
        b.array[:] = np.random.default_rng(self._matrix.getComm().rank).normal(size=b.local_size)
        self._ksp.solve(b, x)
        x.destroy()
        b.destroy()
        self._ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        self._ksp.setConvergenceTest(self._judge)
        self._ksp.setTolerances(rtol=tolerance)
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
        self._free()
        self._R.destroy()
        self._P.destroy()

    def _free(self) -> None:
        """Free what belongs to the present values."""
        for thing in self._made:
            thing.destroy()
        self._made = []

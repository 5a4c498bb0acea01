"""Quadratic eigenvalue problems: small motions y = x exp(s t) with damping or in a turning frame.

    (s^2 M + s D + K) x + G^T l = 0,    G x = 0.

With a real shift, s = sigma + mu, it is the same problem in mu with the coefficients P(sigma) =
sigma^2 M + sigma D + K, P'(sigma) = 2 sigma M + D and M. SLEPc's two-level orthogonal Arnoldi
method (TOAR) finds the smallest mu by inverting P(sigma). The bordered solver does that on the
motions that the constraints allow, without a basis of these. Real arithmetic gives complex pairs.
To have all coefficients of the same size, mu is taken in units of sigma. TOAR in SLEPc: C. Campos
and J. E. Roman, SIAM J. Sci. Comput. 38 (2016) S385-S411.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import BorderedSolver, blocks_of
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.slepc import Pair, import_slepc, invert_by, keep_if_interrupted
from turbine_fenicsx.analysis.small_problem import solve_small

DIFFERENT = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN
TOLERANCE = 1e-12
"""Relative error of the eigenvalues mu that the Arnoldi method accepts."""

MAX_RESTARTS = 200

MAX_RUNS = 20

ERROR_OF_LIBRARY = 76
"""PETSc's code for an error in a library that it calls (PETSC_ERR_LIB)."""

MAX_DENSE_SIZE = 150
"""Maximum number of degrees of freedom for dense matrices, which give all eigenvalues."""

ADDITIONAL_EIGENVALUES = 8
"""Number of additional ones that are kept: those that come together may be of one eigenvalue."""

RESIDUAL = 1e-2
"""Largest error with which a pair fulfils the equations, relative to its vector. That of pairs that
are round-off is above one, that of others far below."""

EQUAL_TOLERANCE = 1e-6
"""Difference of eigenvalues, relative to them and the shift, below which they are equal."""

MIN_NEW_SHARE = 1e-4
"""Minimum share of the modal mass of a new vector that is normal to those before it."""


class QuadraticProblem:
    """M, D and K by blocks, under the constraints of a system.

    Args:
        linear: The system about a state, for its vectors and constraints.
        mass: M, by `FlatVectors.block_diagonal`.
        damping: D, with gyroscopic terms if there are some; None for zero.
        stiffness: K.
    """

    def __init__(
        self,
        linear: LinearSystem,
        mass: PETSc.Mat,
        damping: PETSc.Mat | None,
        stiffness: PETSc.Mat,
    ) -> None:
        self.linear, self.mass, self.damping, self.stiffness = linear, mass, damping, stiffness

    def at(self, sigma: float) -> PETSc.Mat:
        """New matrix P(sigma) by blocks. Collective."""
        blocks = [K.copy() for K in blocks_of(self.stiffness)]
        for factor, matrix in ((sigma, self.damping), (sigma * sigma, self.mass)):
            if matrix is not None:
                for P, part in zip(blocks, blocks_of(matrix), strict=True):
                    P.axpy(factor, part, DIFFERENT)
        *flexible, rigid = blocks
        values = rigid.getDenseArray().copy()
        rigid.destroy()
        return self.linear.vectors.block_diagonal(flexible, values)

    def destroy(self) -> None:
        """Free damping and stiffness. Collective."""
        for matrix in (self.damping, self.stiffness):
            if matrix is not None:
                for block in (*blocks_of(matrix), matrix):
                    block.destroy()

    def pairs(self, number: int, sigma: float) -> list[Pair]:
        """Eigenvalues nearest to sigma, one of each complex pair, by rising distance. Collective.

        A run from one start finds one vector of a repeated eigenvalue, and others by round-off, if
        at all; so there are further runs, from other starts, until one finds nothing new.

        Args:
            number: How many eigenvalues at least, both of a complex pair counted. There are fewer
                where some are defective, as the zeros of rigid motions are.
            sigma: The shift, positive, about as large as the lowest frequencies [rad/s].
        """
        found = _Pairs(self.mass)
        shifted = _ShiftedProblem(self, sigma)
        try:
            free = self.linear.degrees_of_freedom
            if free <= max(MAX_DENSE_SIZE, _columns(number)):
                shifted.solve_all(number, found)
                return sorted(found.pairs, key=lambda pair: abs(pair.eigenvalue - sigma))
            for _ in range(MAX_RUNS):
                before = len(found.pairs)
                completed = shifted.run(number, found)
                enough = found.number >= number and not found.has_repeated
                if enough or (completed and len(found.pairs) == before):
                    break
        finally:
            shifted.destroy()
        return sorted(found.pairs, key=lambda pair: abs(pair.eigenvalue - sigma))


class _Pairs:
    """Pairs that are found one after the other, each once.

    Args:
        mass: M, in whose inner product vectors of one eigenvalue are normal to each other.

    Attributes:
        has_repeated: Whether there are two of one eigenvalue.
    """

    def __init__(self, mass: PETSc.Mat) -> None:
        self._mass = mass
        self.pairs: list[Pair] = []
        self.has_repeated = False

    @property
    def number(self) -> int:
        """Number of eigenvalues, both of a complex pair counted."""
        return sum(2 if pair.eigenvalue.imag > 0.0 else 1 for pair in self.pairs)

    def add(self, pair: Pair, size: float) -> None:
        """Add a pair, or destroy it if its vector is none but a combination of those before.

        Args:
            size: Eigenvalues closer than `EQUAL_TOLERANCE` times this are one.
        """
        others = [
            p for p in self.pairs if abs(p.eigenvalue - pair.eigenvalue) <= EQUAL_TOLERANCE * size
        ]
        a, b = pair.parts
        Ma, Mb = a.duplicate(), b.duplicate()
        before = self._measure(a, b, Ma, Mb)
        for _ in range(2):
            for x, y in (other.parts for other in others):
                # c + i d = (x + i y)* . M (a + i b), with vectors of unit modal mass
                c, d = x.dot(Ma) + y.dot(Mb), x.dot(Mb) - y.dot(Ma)
                a.axpy(-c, x)
                a.axpy(d, y)
                b.axpy(-c, y)
                b.axpy(-d, x)
                self._measure(a, b, Ma, Mb)
        left = self._measure(a, b, Ma, Mb)
        for vector in (Ma, Mb):
            vector.destroy()
        if not left > MIN_NEW_SHARE * before:
            pair.destroy()
            return
        a.scale(left**-0.5)
        b.scale(left**-0.5)
        self.has_repeated = self.has_repeated or bool(others)
        self.pairs.append(pair)

    def _measure(self, a: PETSc.Vec, b: PETSc.Vec, Ma: PETSc.Vec, Mb: PETSc.Vec) -> float:
        """Modal mass of a + i b, and the products with M."""
        self._mass.mult(a, Ma)
        self._mass.mult(b, Mb)
        return float(a.dot(Ma) + b.dot(Mb))


class _ShiftedProblem:
    """The problem in mu, in units of sigma.

    Args:
        sigma: The shift [rad/s].
    """

    def __init__(self, problem: QuadraticProblem, sigma: float) -> None:
        self._problem, self._sigma = problem, sigma
        self._rng = np.random.default_rng(problem.linear.system.comm.rank)  # each run another start
        self._matrix = problem.at(sigma)
        self._solver = problem.linear.solver(self._matrix, "modes_", symmetric=False)
        self._solver.factorise()
        M, D = problem.mass, problem.damping
        rates = [(M, 2.0 * sigma * sigma)] + ([] if D is None else [(D, sigma)])
        self._terms = [_Sum(t) for t in ([(self._matrix, 1.0)], rates, [(M, sigma * sigma)])]

    def run(self, number: int, found: _Pairs) -> bool:
        """Add pairs that a run from a random start finds to those found. Collective.

        Returns:
            Whether the run came to its end. It cannot where LAPACK finds eigenvalues of the small
            projected problem too close to be put in order; another start gives another problem.
        """
        linear = self._problem.linear
        n = (linear.vectors.local_size, None)
        operators = [
            PETSc.Mat().createPython((n, n), term, comm=linear.system.comm) for term in self._terms
        ]
        start, allowed, x, y = (linear.vectors.new_vector() for _ in range(4))
        start.array[:] = self._rng.standard_normal(start.array_r.size)
        self._solver.solve(start, allowed)
        with _toar(operators, self._solver, number) as iteration:
            iteration.setInitialSpace(allowed)
            completed = _solve(iteration)
            for k in range(iteration.getConverged() if completed else 0):
                mu = linear.system.comm.bcast(iteration.getEigenpair(k, x, y))
                if self._error(mu, x, y) <= RESIDUAL:
                    self._add(mu, x, y, found)
        for thing in (start, allowed, x, y, *operators):
            thing.destroy()
        return completed

    def solve_all(self, number: int, found: _Pairs) -> None:
        """Add the pairs of a small problem to those found, some more than a number. Collective."""
        products = [term.multiply for term in self._terms]
        for mu, x, y in solve_small(self._problem.linear, products, self._solver.solve):
            if found.number < number + ADDITIONAL_EIGENVALUES:
                self._add(mu, x, y, found)

    def _add(self, mu: complex, x: PETSc.Vec, y: PETSc.Vec, found: _Pairs) -> None:
        """Add a pair to those found, one of each two that are conjugate."""
        if mu.imag >= 0.0:
            s = self._sigma * (1.0 + mu)
            found.add(Pair(s, (x.copy(), y.copy())), self._sigma + abs(s))

    def destroy(self) -> None:
        """Free the factors. Collective."""
        self._solver.destroy()
        for block in (*blocks_of(self._matrix), self._matrix):
            block.destroy()

    def _error(self, mu: complex, x: PETSc.Vec, y: PETSc.Vec) -> float:
        """Size of P(sigma)^-1 P(s) z over that of z = x + i y."""
        lacking, image = [x.copy(), y.copy()], x.duplicate()
        for term, factor in zip(self._terms[1:], (mu, mu * mu), strict=True):
            for z, weights in (
                (x, (factor.real, factor.imag)),
                (y, (-factor.imag, factor.real)),
            ):
                term.multiply(z, image)
                part = image.duplicate()
                self._solver.solve(image, part)
                for sum_, weight in zip(lacking, weights, strict=True):
                    sum_.axpy(weight, part)
                part.destroy()
        error = np.hypot(*(v.norm() for v in lacking)) / np.hypot(x.norm(), y.norm())
        for vector in (*lacking, image):
            vector.destroy()
        return float(error)


def _columns(number: int) -> int:
    """Size of the space of an iteration for a number of eigenvalues."""
    return 2 * number + 20


class _Sum:
    """Shell matrix: a sum of matrices with factors."""

    def __init__(self, terms: list[tuple[PETSc.Mat, float]]) -> None:
        self._terms = terms

    def mult(self, _: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """Set y to the product with x, for PETSc."""
        self.multiply(x, y)

    def multiply(self, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """Set y to the sum of factor A x."""
        (first, factor), *others = self._terms
        first.mult(x, y)
        y.scale(factor)
        if others:
            part = y.duplicate()
            for A, factor in others:
                A.mult(x, part)
                y.axpy(factor, part)
            part.destroy()


def _solve(iteration: Any) -> bool:
    """Run SLEPc's solver; False if LAPACK failed on the projected problem, on all ranks alike."""
    try:
        iteration.solve()
    except PETSc.Error as error:
        if error.ierr != ERROR_OF_LIBRARY:
            raise
        return False
    return True


@contextmanager
def _toar(operators: list[PETSc.Mat], solver: BorderedSolver, number: int) -> Iterator[Any]:
    """SLEPc's solver, with options of the prefix ``modes_``."""
    SLEPc = import_slepc()
    problem = SLEPc.PEP().create(operators[0].getComm())
    problem.setOptionsPrefix("modes_")
    problem.setOperators(operators)
    problem.setProblemType(SLEPc.PEP.ProblemType.GENERAL)
    problem.setType(SLEPc.PEP.Type.TOAR)
    problem.setDimensions(number, _columns(number))
    problem.setTolerances(TOLERANCE, MAX_RESTARTS)
    problem.setTarget(0.0)
    problem.setWhichEigenpairs(SLEPc.PEP.Which.TARGET_MAGNITUDE)
    # else the ranks go apart where round-off decides
    problem.getDS().setParallel(SLEPc.DS.ParallelType.SYNCHRONIZED)
    transform = invert_by(problem, solver)
    transform.setShift(0.0)
    transform.setTransform(True)
    problem.setFromOptions()
    with keep_if_interrupted(problem):
        yield problem
    problem.destroy()

"""The eigenvalue problem K y + G^T l = w^2 M y, G y = 0, by SLEPc.

Krylov-Schur iterations in the inner product of M, shifted and inverted: y -> (K + s M)^-1 M y.
Solutions of the bordered solver fulfil the constraints, so no basis of the allowed motions is
needed. Its eigenvalues are 1/(w^2 + s). For s > 0 the matrix has an inverse although free bodies
and mechanisms have motions without stiffness; these come out with w = 0. G. W. Stewart, A
Krylov-Schur algorithm for large eigenproblems, SIAM J. Matrix Anal. Appl. 23 (2001) 601-614.
"""

from __future__ import annotations

import logging
from typing import Any

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.linear_system import LinearSystem, entry_sizes, quadratic_form
from turbine_fenicsx.analysis.slepc import Pair, invert_by, keep_if_interrupted
from turbine_fenicsx.analysis.statics import UNHELD
from turbine_fenicsx.analysis.strain_meter import (
    StrainMeter,
    swelling_of,
    warn_of_round_off,
)
from turbine_fenicsx.foundation.errors import StepFailure

log = logging.getLogger(__name__)

SHIFT_RATIO = 1e-6
"""Shift relative to the square of the frequency at which a body would swell and shrink: small
against squares of frequencies of bending, large against round-off of the stiffness."""

EQUAL_TOLERANCE = 1e-6
"""Eigenvalues that differ by less than this part may be one."""

ROUGH_TOLERANCE = 1e-2
"""Relative tolerance of the iteration that only asks whether an eigenvalue is missing."""

RESIDUAL = 1e-6
"""Largest part by which modes may be wrong, besides what the last digits of K make of them: these
count in thin walls, which are so much stiffer stretched than bent."""

ROUND_OFF = 1e-13
"""Round-off of y.K y, relative to its size by the entries of K."""

UNSYMMETRIC = 1e-12
"""Difference of a symmetric block and its transpose, over the block, by round-off."""


class SquaredFrequencies:
    """Iterations for the eigenvalues w^2 nearest to zero, and their vectors.

    Args:
        linear: Mass and stiffness. The shift is added to the stiffness.
        shift: s [rad^2/s^2]; None chooses it.

    Attributes:
        symmetric: Whether K is; then all w^2 are real.
    """

    def __init__(self, SLEPc: Any, linear: LinearSystem, shift: float | None) -> None:
        self._SLEPc, self._linear = SLEPc, linear
        self._A, self._M = linear.stiffness, linear.mass
        self._shift = soft_shift(linear) if shift is None else shift
        self.symmetric = all(_is_symmetric(block) for block in blocks_of(self._A))
        self._meter = StrainMeter(linear)  # of the stiffness alone
        for A, M in zip(blocks_of(self._A), blocks_of(self._M), strict=True):
            A.axpy(self._shift, M, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
        self._sizes = entry_sizes(linear.vectors, linear.stiffness)
        self._solver = linear.solver(self._A, "modes_", self.symmetric)

    def find(self, count: int, tolerance: float) -> list[Pair]:
        """All converged pairs once their number is reached and none nearer to the shift is missing.

        A Krylov space holds one vector of each eigenvalue, and further ones of a repeated
        eigenvalue only by round-off. So the iteration restarts, orthogonal to what was found, until
        it comes to an eigenvalue beyond.

        Args:
            count: Number of pairs, at most that of degrees of freedom.
            tolerance: Of the iteration, relative.
        """
        self._solver.factorise()
        pairs = self._iterate(count, tolerance, [])
        if self.symmetric:
            self._complete(pairs, count, tolerance)
            self._warn_of_growing(pairs)
        elif len(pairs) < self._linear.degrees_of_freedom:
            others = self._iterate(1, ROUGH_TOLERANCE, pairs)
            if len(pairs) < count or not self._is_beyond(others, pairs, count, -ROUGH_TOLERANCE):
                raise StepFailure(
                    "a mode of a repeated frequency is missing, which cannot be mended where "
                    "stiffness is unsymmetric; ask for more modes"
                )
            _destroy(others)
        log.info("%d modes after %d solves", len(pairs), self._solver.solves)
        lowest = sorted((abs(p.eigenvalue), p.round_off, p.is_rigid) for p in pairs)[:count]
        squares = [(square, error) for square, error, is_rigid in lowest if not is_rigid]
        warn_of_round_off(self._linear.system.comm, squares)
        self._check(pairs)
        return pairs

    def _complete(self, pairs: list[Pair], count: int, tolerance: float) -> None:
        """Add what is missing to pairs, orthogonal to what there is."""
        while len(pairs) < self._linear.degrees_of_freedom:
            enough = len(pairs) >= count
            if enough:
                rough = self._iterate(1, ROUGH_TOLERANCE, pairs)
                last = self._is_beyond(rough, pairs, count, ROUGH_TOLERANCE)
                _destroy(rough)
                if last:
                    return
            more = self._iterate(1, tolerance, pairs)
            last = enough and self._is_beyond(more, pairs, count, EQUAL_TOLERANCE)
            pairs += more
            if last:
                return
            if not more:
                raise StepFailure(
                    f"{len(pairs)} of {count} modes were found; another shift may help"
                )

    def _warn_of_growing(self, pairs: list[Pair]) -> None:
        """Warn if motions grow that are not among those found."""
        growing = self._solver.count_negative()
        known = sum(pair.eigenvalue.real + self._shift < 0.0 for pair in pairs)
        if growing > known and self._linear.system.comm.rank == 0:
            log.warning(
                "the equilibrium is unstable: %d motions grow, and only %d of them are among the "
                "modes found; ask for more modes to see the others",
                growing,
                known,
            )

    def destroy(self) -> None:
        """Free the factors. Collective."""
        self._solver.destroy()
        self._sizes.destroy()

    def _iterate(self, count: int, tolerance: float, found: list[Pair]) -> list[Pair]:
        """Pairs besides those that were found already, as many as converge until count have."""
        eps = self._new_iteration(count, tolerance, found)
        with keep_if_interrupted(eps):
            eps.solve()
        pairs = [self._pair(eps, k) for k in range(eps.getConverged())]
        eps.destroy()
        return [pair for pair in pairs if pair is not None]

    def _is_beyond(self, others: list[Pair], pairs: list[Pair], count: int, margin: float) -> bool:
        """Whether other pairs are farther from the shift than a number of pairs, by a margin."""
        distances = sorted(abs(pair.eigenvalue + self._shift) for pair in pairs)
        nearest = min((abs(pair.eigenvalue + self._shift) for pair in others), default=np.inf)
        return nearest > (1.0 + margin) * distances[count - 1]

    def _new_iteration(self, count: int, tolerance: float, found: list[Pair]) -> Any:
        """The solver of SLEPc, with the bordered solver as that of its shift and invert."""
        EPS = self._SLEPc.EPS
        eps = EPS().create(self._linear.system.comm)
        eps.setOptionsPrefix("modes_")
        eps.setOperators(self._A, self._M)
        kind = EPS.ProblemType.GHEP if self.symmetric else EPS.ProblemType.PGNHEP
        eps.setProblemType(kind)
        free, size = self._linear.degrees_of_freedom, self._A.getSize()[0]
        widest = max(min(2 * count + 6, free - len(found)), count + 1)  # as SLEPc has it
        eps.setDimensions(count, min(widest, size))
        known = [part for pair in found for part in pair.parts]
        if known:
            eps.setDeflationSpace(known)
        start = self._linear.vectors.new_vector()
        seed = len(found), start.comm.rank  # of a vector from which nothing was found yet
        start.array[:] = np.random.default_rng(seed).standard_normal(start.local_size)
        eps.setInitialSpace([start])
        start.destroy()
        eps.setTolerances(tolerance)
        eps.setWhichEigenpairs(EPS.Which.TARGET_MAGNITUDE)
        eps.setTarget(0.0)
        eps.setPurify(False)  # all vectors fulfil the constraints anyway
        invert_by(eps, self._solver)
        eps.setFromOptions()
        return eps

    def _pair(self, eps: Any, k: int) -> Pair | None:
        """A pair of unit modal mass; None for what only round-off has made.

        With y^H M y = 1, w^2 + s = y^H (K + s M) y is more accurate than the iteration.
        """
        a, b = self._linear.vectors.new_vector(), self._linear.vectors.new_vector()
        theta = complex(eps.getEigenpair(k, a, b))
        parts = (a, b) if theta.imag else (a,)
        size = np.sqrt(sum(quadratic_form(self._M, part, part) for part in parts))
        for part in parts:
            part.scale(1.0 / size)
        quotient = complex(sum(quadratic_form(self._A, part, part) for part in parts))
        if theta.imag:
            quotient += 1j * (quadratic_form(self._A, a, b) - quadratic_form(self._A, b, a))
        if abs(quotient - theta) > ROUGH_TOLERANCE * abs(quotient):
            a.destroy()
            b.destroy()
            return None
        square = quotient - self._shift
        if theta.imag:
            return Pair(square, parts)
        b.pointwiseMult(self._sizes, a)
        size = b.dot(a)
        b.destroy()
        is_rigid = abs(square) <= ROUND_OFF * size + UNHELD
        is_rigid = is_rigid and not self._meter.is_strained([a], abs(square))
        return Pair(square, parts, is_rigid, float(np.finfo(float).eps) * size)

    def _check(self, pairs: list[Pair]) -> None:
        """Raise a StepFailure if (K + s M)^-1 M (w^2 + s) y = y does not hold for all pairs.

        One solution is enough for all: that for the sum of their real and imaginary parts.
        """
        y, z, error = (self._linear.vectors.new_vector() for _ in range(3))
        allowed = RESIDUAL
        for pair in pairs:
            theta = complex(pair.eigenvalue) + self._shift
            error.pointwiseMult(self._sizes, pair.parts[0])
            allowed += float(np.finfo(float).eps * error.dot(pair.parts[0]) / abs(theta))
            for part, sign in zip(pair.parts, (1.0, -1.0), strict=False):
                y.axpy(1.0, part)
                z.axpy(theta.real + sign * theta.imag, part)
        self._M.mult(z, error)
        self._solver.solve(error, z)
        z.axpy(-1.0, y)
        wrong = np.sqrt(quadratic_form(self._M, z, z))
        for vector in (y, z, error):
            vector.destroy()
        if not wrong <= allowed:
            raise StepFailure(
                f"the modes do not fulfil their equations: they are wrong by {wrong:.1e} where "
                f"{allowed:.1e} is allowed; another shift may help"
            )


def _destroy(pairs: list[Pair]) -> None:
    """Free some pairs. Collective."""
    for pair in pairs:
        pair.destroy()


def soft_shift(linear: LinearSystem) -> float:
    """A shift that is small against all squared frequencies that matter [rad^2/s^2].

    It comes from the softest body. Systems without any stiffness get one.
    """
    square = square_of_swelling(linear)
    if not linear.system.flexible_models:
        rigid = [blocks_of(matrix)[-1].norm() for matrix in (linear.stiffness, linear.mass)]
        square = rigid[0] / (rigid[1] or 1.0)
    return SHIFT_RATIO * (square if square > UNHELD else 1.0 / SHIFT_RATIO)


def square_of_swelling(linear: LinearSystem) -> float:
    """Square of the frequency at which the softest body would swell and shrink [rad^2/s^2].

    0 if none is flexible and stiff.
    """
    system = linear.system
    flexible = zip(blocks_of(linear.stiffness)[:-1], blocks_of(linear.mass)[:-1], strict=True)
    squares = []
    for m, (K, M) in zip(system.flexible_models, flexible, strict=True):
        swelling = swelling_of(m)
        squares.append(quadratic_form(K, swelling) / quadratic_form(M, swelling))
        swelling.destroy()
    return min((s for s in squares if s > UNHELD), default=0.0)


def _is_symmetric(K: PETSc.Mat) -> bool:
    """Whether K y = K^T y for some vector without any symmetry."""
    y, there = K.createVecs()
    first, last = y.getOwnershipRange()
    y.array[:] = np.sin(1.0 + np.arange(first, last) ** 2)
    back = there.duplicate()
    K.mult(y, there)
    K.multTranspose(y, back)
    size = there.norm()
    back.axpy(-1.0, there)
    difference = back.norm()
    for vector in (y, there, back):
        vector.destroy()
    return bool(difference <= UNSYMMETRIC * size)

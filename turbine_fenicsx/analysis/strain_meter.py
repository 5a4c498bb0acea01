"""How much a small motion strains flexible bodies, without the round-off of their stiffness.

Products y.K y of slow motions are differences of large numbers. Elongations between neighbouring
nodes are not: with d between two nodes and y of both, summed over all pairs,

    e^2 = sum [d . (y_i - y_j)]^2/d^2 / sum d^2,

which vanishes for rigid motions of any part of a body, and is 1 for one that swells. With the
energy k of the latter, a strained body has about the energy k e^2. One in which the energy of its
prestress balances that, as in a bent tower below a nacelle that turns, is held by nothing.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from math import pi, sqrt

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.linear_system import LinearSystem, quadratic_form
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_model import BodyModel

log = logging.getLogger(__name__)

MAX_ERROR = 0.03
"""Relative error of a squared frequency that is not worth a warning."""

MIN_STRAIN = 1e-13
"""e^2 over that of a motion which swells the body with the same modal mass, above which it counts.
Round-off makes some 1e-15; the first mode of a wire of 10 000 diameters has 1e-9."""

MAX_BALANCED = 30.0
"""k e^2 over the energy of all that holds a body, above which the strain is balanced by others."""


class StrainMeter:
    """Says whether motions strain some flexible body. Collective."""

    def __init__(self, linear: LinearSystem) -> None:
        self._vectors = linear.vectors
        self._comm = linear.system.comm
        self._bodies: list[tuple[Array, Array, IntArray]] = []
        self._swelling: list[tuple[float, float]] = []
        blocks = zip(blocks_of(linear.stiffness), blocks_of(linear.mass), strict=True)
        models = zip(linear.system.flexible_models, linear.state.u, blocks, strict=False)
        for model, u, (K, M) in models:
            x = model.positions + u.array_r.reshape(-1, 3)
            self._bodies.append((x, model.is_point, _find_pairs(K, model)))
            arms = swelling_of(model)
            self._swelling.append((quadratic_form(K, arms), quadratic_form(M, arms)))
            arms.destroy()

    def is_strained(self, parts: Iterable[PETSc.Vec], energy: float) -> bool:
        """Whether a motion strains some body, and nothing balances the strain. Collective.

        Args:
            parts: Its real part, and the imaginary one if there is one, of unit modal mass.
            energy: The sum of y.K y over the parts, with its round-off.
        """
        sums = np.zeros((len(self._bodies), 2))
        for part in parts:
            *displacements, _ = self._vectors.split(part)
            for k, ((x, h, pairs), y) in enumerate(zip(self._bodies, displacements, strict=True)):
                sums[k] += _sum_squares(x, y.reshape(-1, 3), h, pairs)
        elongation, size = self._comm.allreduce(sums).T
        square = elongation / np.maximum(size, np.finfo(float).tiny)
        stiffness, mass = np.reshape(self._swelling, (-1, 2)).T
        strained = (square * mass > MIN_STRAIN).any()
        return bool(strained and square @ stiffness < MAX_BALANCED * energy)


def warn_of_round_off(comm: MPI.Comm, squares: Iterable[tuple[float, float]]) -> None:
    """Warn of frequencies that the last digits of the stiffness change.

    Args:
        squares: Squared frequencies and their errors [rad^2/s^2].
    """
    wrong = [(w2, error) for w2, error in squares if error > MAX_ERROR * w2]
    if wrong and comm.rank == 0:
        w2, _ = max(wrong)
        share = max(error / max(w2, error) for w2, error in wrong)
        log.warning(
            "%d modes of up to %.3g Hz lie near round-off, their squared frequencies may be wrong "
            "by %.0f %%: cells are so small, or so stiff stretched, that last digits of their "
            "stiffness bend the body",
            len(wrong),
            sqrt(w2) / (2.0 * pi),
            100.0 * share,
        )


def swelling_of(model: BodyModel) -> PETSc.Vec:
    """New vector of positions relative to their mean: the body swells. Collective."""
    found = model.new_vector()
    sums = model.comm.allreduce(np.append(model.positions.sum(axis=0), len(model.positions)))
    found.array[:] = (model.positions - sums[:3] / sums[3]).ravel()
    return found


def _find_pairs(K: PETSc.Mat, model: BodyModel) -> IntArray:
    """Nodes of this rank that share a cell, or two vectors of one reduced part, shape (2, n)."""
    local = K if K.getType() == "seqaij" else K.getDiagonalBlock()
    rows, columns, _ = local.getValuesCSR()
    of_row = np.repeat(np.arange(len(rows) - 1), np.diff(rows))
    first = (of_row % 3 == 0) & (columns % 3 == 0)  # one of the nine entries of each pair
    i, j = of_row[first] // 3, columns[first] // 3
    keep = (i <= j) & (model.is_point[i] == model.is_point[j])
    keep &= (i < j) | (model.is_point[i] == 0.0)
    found: IntArray = np.stack([i, j])[:, keep]
    return found


def _sum_squares(x: Array, y: Array, h: Array, pairs: IntArray) -> tuple[float, float]:
    """Sums of squared elongations and of squared distances; of vectors those of their products.

    Args:
        x: Points and vectors, shape (n, 3).
        y: Their motion, of the same shape.
        h: 1 for points and 0 for vectors, shape (n,).
        pairs: Numbers of nodes, shape (2, m).
    """
    (i, j), h = pairs, h[pairs[0], None]
    # d . d' of two points, (x_i . x_j)' of two vectors
    change = h * (x[i] - x[j]) * (y[i] - y[j]) + (1.0 - h) * (x[i] * y[j] + y[i] * x[j])
    square = h * (x[i] - x[j]) ** 2 + (1.0 - h) * (x[i] ** 2 + x[j] ** 2)
    total, size = change.sum(axis=1), square.sum(axis=1)
    return float(np.sum(total**2 / np.where(size > 0.0, size, np.inf))), float(size.sum())

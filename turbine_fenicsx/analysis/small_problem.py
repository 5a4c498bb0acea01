"""Quadratic eigenvalue problems of few degrees of freedom, by dense matrices.

The iteration for large ones breaks down where its space is as large as that of all motions. Here
random forces give a basis Q of the motions that the constraints allow, and LAPACK all eigenvalues
of Q^T (A_0 + mu A_1 + mu^2 A_2) Q.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from petsc4py import PETSc

import numpy as np
from scipy.linalg import eig, qr

from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array

Product = Callable[[PETSc.Vec, PETSc.Vec], None]
"""Sets the second vector to a matrix times the first."""


def solve_small(
    linear: LinearSystem, products: Sequence[Product], allow: Product
) -> Iterator[tuple[complex, PETSc.Vec, PETSc.Vec]]:
    """All eigenvalues by rising size, with vectors that the next one overwrites. Collective.

    Args:
        allow: Turns any vector into a motion that the constraints allow.
    """
    comm, free = linear.system.comm, linear.degrees_of_freedom
    x, y = linear.vectors.new_vector(), linear.vectors.new_vector()
    Q = find_allowed(linear, allow)
    reduced = np.zeros((3, free, free))
    for A, multiply in zip(reduced, products, strict=True):
        for k in range(free):
            x.array[:] = Q[:, k]
            multiply(x, y)
            A[:, k] = Q.T @ y.array_r
    total = comm.reduce(reduced)
    values, vectors = on_rank0(comm, lambda: _eigenpairs(total))
    for mu, v in zip(values, vectors.T, strict=True):
        motion = Q @ v
        x.array[:], y.array[:] = motion.real, motion.imag
        yield complex(mu), x, y
    x.destroy()
    y.destroy()


def find_allowed(linear: LinearSystem, allow: Product) -> Array:
    """This rank's rows of an orthonormal basis of the motions that constraints allow. Collective.

    Args:
        allow: As of `solve_small`.
    """
    x, y = linear.vectors.new_vector(), linear.vectors.new_vector()
    columns, rng = [], np.random.default_rng(linear.system.comm.rank)
    for _ in range(linear.degrees_of_freedom):
        x.array[:] = rng.standard_normal(x.array_r.size)
        allow(x, y)
        columns.append(y.array_r.copy())
    x.destroy()
    y.destroy()
    return _orthonormal(linear, np.array(columns).reshape(len(columns), -1).T)


def _orthonormal(linear: LinearSystem, X: Array) -> Array:
    """This rank's rows of an orthonormal basis of the space of distributed columns."""
    comm = linear.system.comm
    parts = comm.gather(X)

    def basis() -> Array:
        Q: Array = qr(np.concatenate(parts), mode="economic")[0]
        return Q

    Q = on_rank0(comm, basis)
    first = comm.exscan(len(X)) or 0
    return Q[first : first + len(X)]


def _eigenpairs(A: Array) -> tuple[Array, Array]:
    """Eigenvalues by rising size, and their vectors as columns.

    Found as their inverses, whose round-off is small beside those of the smallest.
    """
    n = A.shape[1]
    inverse = np.linalg.solve(A[0], np.concatenate([A[2], A[1]], axis=1))
    theta, vectors = eig(np.block([[np.zeros((n, n)), np.eye(n)], [-inverse]]))
    falling = np.argsort(-np.abs(theta))
    falling = falling[np.abs(theta[falling]) > 0.0]
    return 1.0 / theta[falling], vectors[:n, falling]

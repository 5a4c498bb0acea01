"""The strain energy of a reduced body, a quadratic function of scalar products of its vectors.

With the vectors y = L z of a copy of the body (`ReducedBasis.strain_vectors`) the deformation
gradient is F = sum_k y_k (x) grad f_k, and the strain

    E = (F^T F - 1)/2 = 1/2 sum_kl (y_k . y_l - y_k . y_l at rest) grad f_k (x) grad f_l

is linear in the scalar products of all pairs p = (k, l), k <= l (Barbic and James 2005 found that
the forces are cubic in z). With e_p, their change since rest, and K = W W^T

    U = 1/2 e.K e = 1/2 c.c,        c = W^T e,
    forces L^T S y,                 S: s = W c as a symmetric matrix, with 2 s_kk in the diagonal,
    J = dc/dz,   J[r, k] = sum_l T[r, k, l] y_l,    L^T S y = J^T c.

J is linear in y, so that the mean J of two configurations takes their difference to that of c.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from turbine_fenicsx.foundation.types import Array

SPARSE = 0.1
"""Share of entries that are not zero below which a matrix is kept as a sparse one, as of beams."""


class GramStrain:
    """Strain coordinates c of some equal copies of a body.

    Args:
        strain_factor: W, shape (pairs, r).
        strain_vectors: L, shape (m, n).
        at_rest: y at rest, shape (m, 3).
        rigid: Numbers of vectors y whose scalar products with each other never change.
    """

    def __init__(
        self, strain_factor: Array, strain_vectors: Array, at_rest: Array, rigid: range
    ) -> None:
        m, n = strain_vectors.shape
        i, j = np.triu_indices(m)
        self._places = m * i + j  # of pairs in a flat matrix
        self._pair_of = np.zeros((m, m), dtype=np.intp)
        self._pair_of[i, j] = self._pair_of[j, i] = np.arange(len(i))
        kept = ~(np.isin(i, rigid) & np.isin(j, rigid))
        W = np.where(kept[:, None], strain_factor, 0.0)
        self._W, self._W_single = _store(W)
        self._W_T = _store(W.T)[0]
        self._L = strain_vectors
        self._L_single = self._L.astype(np.float32)
        self._at_rest = self._pair(at_rest[None], at_rest[None])
        self.size = r = W.shape[1]
        T = np.zeros((r, m, m))
        T[:, i, j] = W.T
        T[:, j, i] += W.T
        self._T, self._T_single = _store((self._L.T @ T).reshape(r * n, m))

    def vectors(self, z: Array) -> Array:
        """Vectors y = L z, shape (copies, m, 3) for z of shape (copies, n, 3)."""
        y: Array = self._L @ z
        return y

    def strain(self, y: Array) -> Array:
        """Strain coordinates c of vectors y, shape (copies, r)."""
        return _multiply(self._pair(y, y) - self._at_rest, self._W_T)

    def change(self, y: Array, dy: Array) -> Array:
        """Change of c when the vectors change by dy, and are y in the middle, shape (copies, r)."""
        products = y @ dy.swapaxes(1, 2)
        return _multiply(self._take(products + products.swapaxes(1, 2)), self._W_T)

    def stress(self, c: Array, single: bool = False) -> Array:
        """S of strain coordinates c, shape (copies, m, m); single as of `jacobian`."""
        W = self._W_single if single else self._W
        S: Array = _multiply(c.astype(W.dtype), W).take(self._pair_of, axis=1)
        np.einsum("...kk->...k", S)[...] *= 2.0
        return S

    def forces(self, S: Array, y: Array) -> Array:
        """Forces L^T S y on the vectors z, shape (copies, n, 3)."""
        forces: Array = self._L.T @ (S @ y)
        return forces

    def geometric(self, S: Array) -> Array:
        """Stiffness L^T S L of each component of z, shape (copies, n, n)."""
        L = self._L_single if S.dtype == np.float32 else self._L
        stiffness: Array = L.T @ S @ L
        return stiffness

    def jacobian(self, y: Array, single: bool = False) -> Array:
        """J = dc/dz, shape (copies, r, 3 n).

        Args:
            y: The vectors, shape (copies, m, 3).
            single: Whether it is found in single precision, enough for tangents of Newton's method.
        """
        copies, n = len(y), self._L.shape[1]
        T = self._T_single if single else self._T
        J = T @ y.swapaxes(0, 1).reshape(y.shape[1], 3 * copies).astype(T.dtype)
        by_copy = J.reshape(self.size, n, copies, 3).transpose(2, 0, 1, 3)
        return np.ascontiguousarray(by_copy).reshape(copies, self.size, 3 * n)

    def _pair(self, a: Array, b: Array) -> Array:
        """Scalar products of all pairs, shape (copies, pairs)."""
        return self._take(a @ b.swapaxes(1, 2))

    def _take(self, products: Array) -> Array:
        """Entries of matrices for all pairs, shape (copies, pairs)."""
        size = len(self._L) ** 2  # ranks without copies have none to find it from
        return products.reshape(len(products), size).take(self._places, axis=1)


def _store(matrix: Array) -> tuple[Any, Any]:
    """A matrix in double and in single precision, sparse if few entries are not zero."""
    if np.count_nonzero(matrix) < SPARSE * matrix.size:
        matrix = csr_matrix(matrix)
    return matrix, matrix.astype(np.float32)


def _multiply(rows: Array, matrix: Any) -> Array:
    """Rows times the transpose of a matrix; that of a sparse one is not made for it."""
    product: Array = rows @ matrix.T if isinstance(matrix, np.ndarray) else (matrix @ rows.T).T
    return product


def add_to_components(A: Array, of_each: Array, factor: float) -> None:
    """Add a matrix of each component of vectors to matrices of all, A += factor B (x) 1_3.

    Args:
        A: Shape (copies, 3 n, 3 n).
        of_each: B, shape (copies or 1, n, n).
    """
    n = of_each.shape[-1]
    blocks = A.reshape(len(A), n, 3, n, 3)
    for i in range(3):
        blocks[:, :, i, :, i] += factor * of_each

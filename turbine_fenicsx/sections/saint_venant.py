"""Saint-Venant's solutions of a prism that is loaded at its ends alone.

The displacement is that of rigid sections whose strains e(z) = e_0 + z e_1 vary linearly, and a
warping g(z) = g_0 + z g_1. With the modes Z of rigid sections (see `Prism`), and

    R = C Z,    L = M Z,    A = Z^T M Z,

equilibrium of all powers of z, and the resultants F + z T F of a section, are

    E g_1 + R e_1 = 0,                                  R^T g_1 + A e_1 = T F,
    E g_0 + R e_0 = L e_1 + (C^T - C) g_1,              R^T g_0 + A e_0 = F - L^T g_1,

because moments vary with z by the shear forces, M_x' = F_y and M_y' = -F_x. Conditions Z^T N g = 0
with the overlap N make g unique. At z = 0 the derivative along z is a = Z e_0 + g_1, and the energy
of unit loads is the compliance

    g_0^T E g_0 + g_0^T C a + a^T C^T g_0 + a^T M a.

V. Giavotto et al., Anisotropic beam theory and applications, Computers & Structures 16 (1983).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.sections.prism import Prism

TOLERANCE = 1e-6
"""Largest residual of the equations, relative to their right-hand side."""


class UnitLoads(NamedTuple):
    """A section at z = 0 under a unit of each force and moment.

    Attributes:
        warping: g_0, shape (n, 6) [m/N, or 1/N for moments].
        derivative: a, by z, shape (n, 6).
        compliance: Strains gamma_x, gamma_y, eps, kappa_x, kappa_y, kappa_z, shape (6, 6).
    """

    warping: Array
    derivative: Array
    compliance: Array


def find_unit_loads(prism: Prism) -> UnitLoads:
    """Displacements and compliance under unit loads.

    Raises:
        ModelError: if parts of the section do not hang together.
    """
    E, C, M, Z = prism.across, prism.mixed, prism.along, prism.modes
    R, L, n = C @ Z, M @ Z, len(Z)
    A = Z.T @ L
    # lengths of the order of the section, and conditions of the order of the stiffness
    size = np.repeat([1.0, np.sqrt(np.trace(Z.T @ prism.overlap @ Z)) / np.sqrt(n)], 3)
    held = prism.overlap @ Z * (abs(E).max() / abs(prism.overlap).max() / size)
    K = sparse.bmat([[E, R, held], [R.T, A, None], [held.T, None, None]], format="csc")
    T = np.zeros((6, 6))
    T[3, 1], T[4, 0] = 1.0, -1.0  # M_x' = F_y, M_y' = -F_x
    none = np.zeros((6, 6))
    try:
        factor = splu(K)
        b_1 = np.vstack([np.zeros((n, 6)), T, none])
        first = factor.solve(b_1)
        g_1, e_1 = first[:n], first[n : n + 6]
        b_0 = np.vstack([L @ e_1 + C.T @ g_1 - C @ g_1, np.eye(6) - L.T @ g_1, none])
        second = factor.solve(b_0)
    except RuntimeError:  # exactly singular
        raise _torn() from None
    for b, x in (b_1, first), (b_0, second):
        if not np.linalg.norm(K @ x - b) <= TOLERANCE * np.linalg.norm(b):
            raise _torn()
    g_0, a = second[:n], Z @ second[n : n + 6] + g_1
    mixed = g_0.T @ (C @ a)
    compliance = g_0.T @ (E @ g_0) + mixed + mixed.T + a.T @ (M @ a)
    return UnitLoads(g_0, a, 0.5 * (compliance + compliance.T))


def _torn() -> ModelError:
    return ModelError(
        "a section must hang together by edges of its cells: the equations of its warping are "
        "singular"
    )

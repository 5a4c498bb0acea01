"""Failure indices of plies: 0 without load, 1 where the ply fails, proportional to the load.

A strength that is infinite never fails; a ply without finite strengths has the index 0.
S. W. Tsai and E. M. Wu, A general theory of strength for anisotropic materials, J. Composite
Materials 5 (1971) 58-80.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply_table import Criterion, PlyTable


def tsai_wu(table: PlyTable, strains: Array) -> Array:
    """The load over the load at which the polynomial of Tsai and Wu is one, in plane stress.

    With the strengths Xt, Xc along the fibre, Yt, Yc across it and S, the ply fails where
    F1 s1 + F2 s2 + F11 s1^2 + F22 s2^2 + F66 t^2 + 2 F12 s1 s2 = 1 with

        F1 = 1/Xt - 1/Xc,   F11 = 1/(Xt Xc),   F66 = 1/S^2,   F12 = -sqrt(F11 F22)/2.

    Args:
        table: The n plies.
        strains: In their axes, shape (n, ..., 3).

    Returns:
        Shape (n, ...).
    """
    s1, s2, t = _components(table.stresses(strains))
    Xt, Yt = _columns(table.tension, s1)
    Xc, Yc = _columns(table.compression, s1)
    F11, F22 = 1.0 / (Xt * Xc), 1.0 / (Yt * Yc)
    linear = (1.0 / Xt - 1.0 / Xc) * s1 + (1.0 / Yt - 1.0 / Yc) * s2
    square = F11 * s1**2 + F22 * s2**2 - np.sqrt(F11 * F22) * s1 * s2
    square += (t / _column(table.shear, t)) ** 2
    # with the load factor r: linear r + square r^2 = 1; the index is 1/r
    return np.asarray(0.5 * (linear + np.sqrt(linear**2 + 4.0 * square)))


def maximum_stress(table: PlyTable, strains: Array) -> Array:
    """The largest of the stresses over their strengths; arguments as of `tsai_wu`."""
    return _largest_share(table, table.stresses(strains))


def maximum_strain(table: PlyTable, strains: Array) -> Array:
    """The largest of the strains over those at which a ply fails that is loaded in one direction.

    These are the strengths over Young's moduli and the shear modulus; arguments as of `tsai_wu`.
    """
    moduli = [(*ply.material.young[:2], ply.material.shear[0]) for ply in table.plies]
    stiffness = np.array(moduli).reshape(-1, *(1,) * (strains.ndim - 2), 3)
    return _largest_share(table, stiffness * strains)


CRITERIA: dict[str, Criterion] = {
    "tsai_wu": tsai_wu,
    "maximum_stress": maximum_stress,
    "maximum_strain": maximum_strain,
}
"""By the names that fields and columns have."""


def _largest_share(table: PlyTable, stresses: Array) -> Array:
    s1, s2, t = _components(stresses)
    shares = np.abs(t) / _column(table.shear, t)
    for k, s in enumerate((s1, s2)):
        tension, compression = (_column(x[:, k], s) for x in (table.tension, table.compression))
        shares = np.maximum(shares, np.maximum(s / tension, -s / compression))
    return np.asarray(shares)


def _components(values: Array) -> tuple[Array, Array, Array]:
    return values[..., 0], values[..., 1], values[..., 2]


def _column(values: Array, like: Array) -> Array:
    """Values of the plies in the shape of an array whose first axis are the plies."""
    return values.reshape(-1, *(1,) * (like.ndim - 1))


def _columns(values: Array, like: Array) -> tuple[Array, Array]:
    return _column(values[:, 0], like), _column(values[:, 1], like)

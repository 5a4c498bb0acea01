"""Stiffness and inertia of a blade's cross-sections as the file has them, for comparison."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.curves import Curve, read_grid
from turbine_fenicsx.windio.entry import Entry


@dataclass(frozen=True, eq=False)
class SectionProperties:
    """Matrices of a Timoshenko beam along the reference axis, in axes that turn with the twist.

    Axis x points to the suction side, y to the trailing edge, z along the span; rows and columns
    are forces and strains along x, y, z, then moments and curvatures about them: x bends edgewise.
    (The words of windIO's schema have x and y the other way round. Its files have them like this,
    and only so the centre of mass and the moments of inertia that they give go together.)

    Args:
        grid: Span fractions, (m,) [-].
        stiffness: Shape (m, 6, 6) [N, N m, N m^2]; None where the file has diagonals alone.
        inertia: About the reference axis, shape (m, 6, 6); zero where the file has nothing but
            masses [kg/m, kg, kg m].
    """

    grid: Array
    stiffness: Array | None
    inertia: Array

    @property
    def line_mass(self) -> Curve:
        """Mass per length [kg/m]."""
        return Curve(self.grid, self.inertia[:, 0, 0])


def read_section_properties(entry: Entry) -> SectionProperties:
    """The blade's `elastic_properties`; a stiffness of diagonals alone is left out."""
    stiffness, inertia = entry["stiffness_matrix"], entry["inertia_matrix"]
    grid = read_grid(stiffness["grid"])
    M = _at_stations(grid, *_read_inertia(inertia))
    places = [(i, j) for i in range(6) for j in range(i, 6)]
    if not any(f"K{i + 1}{j + 1}" in stiffness for i, j in places if i != j):
        return SectionProperties(grid, None, M)
    K = np.zeros((len(grid), 6, 6))
    for i, j in places:
        K[:, i, j] = K[:, j, i] = stiffness[f"K{i + 1}{j + 1}"].numbers(len(grid))
    return SectionProperties(grid, K, M)


def read_damping(entry: Entry | None) -> float:
    """Mean factor of the bending stiffness in the damping matrix [s], 0 where there is none.

    Args:
        entry: `elastic_properties` of blade or tower, with ``mu`` of shear along x and y, stretch,
            bending about x and y, and torsion; None where there are none.
    """
    damping = entry.get("structural_damping") if entry else None
    if damping is None or "mu" not in damping:
        return 0.0
    mu = damping["mu"].numbers(6)
    if (mu < 0.0).any():
        damping["mu"].fail("must not be negative")
    return float(mu[3:5].mean())


def _read_inertia(entry: Entry) -> tuple[Array, Array]:
    grid = read_grid(entry["grid"])
    m = entry["mass"].numbers(len(grid))
    x, y, edge, flap, polar, cross = (
        entry[key].numbers(len(grid)) if key in entry else np.zeros(len(grid))
        for key in ("cm_x", "cm_y", "i_edge", "i_flap", "i_plr", "i_cp")
    )
    M = np.zeros((len(grid), 6, 6))
    M[:, 0, 0] = M[:, 1, 1] = M[:, 2, 2] = m
    M[:, 0, 5] = M[:, 5, 0] = -m * y
    M[:, 1, 5] = M[:, 5, 1] = m * x
    M[:, 2, 3] = M[:, 3, 2] = m * y
    M[:, 2, 4] = M[:, 4, 2] = -m * x
    M[:, 3, 3], M[:, 4, 4], M[:, 5, 5] = edge, flap, polar
    M[:, 3, 4] = M[:, 4, 3] = -cross
    return grid, M


def _at_stations(wanted: Array, grid: Array, values: Array) -> Array:
    """Matrices at other stations, straight between their own."""
    flat = values.reshape(len(grid), -1)
    columns = [np.interp(wanted, grid, column) for column in flat.T]
    return np.column_stack(columns).reshape(len(wanted), 6, 6)

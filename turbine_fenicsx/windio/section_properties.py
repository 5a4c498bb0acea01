"""Section matrices of a windIO file: stiffness, mass and damping along the reference axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.section_matrices import interpolate_matrices, make_inertia
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.curves import Curve, read_grid
from turbine_fenicsx.windio.entry import Entry

SAME = 1e-6
"""Relative difference of moments of inertia that are the same."""


@dataclass(frozen=True, eq=False)
class SectionProperties:
    """Matrices of a Timoshenko beam along the reference axis, in axes that turn with the twist.

    Axis x points to the suction side, y to the trailing edge, z along the span; rows and columns
    are forces and strains along x, y, z, then moments and curvatures about them: x bends edgewise.
    (The words of windIO's schema have x and y the other way round. Its files have them like this,
    and only so the centre of mass and the moments of inertia that they give go together.)

    Args:
        grid: Span fractions, (m,) [-].
        stiffness: Shape (m, 6, 6); diagonal where the file has nothing else [N, N m, N m^2].
        inertia: About the reference axis, shape (m, 6, 6); zero where the file has nothing but
            masses [kg/m, kg, kg m].
        warnings: Entries that are not taken as they are, a sentence each.
    """

    grid: Array
    stiffness: Array
    inertia: Array
    warnings: tuple[str, ...] = ()

    @property
    def line_mass(self) -> Curve:
        """Mass per length [kg/m]."""
        return Curve(self.grid, self.inertia[:, 0, 0])


def read_section_properties(entry: Entry) -> SectionProperties:
    """The blade's `elastic_properties`."""
    stiffness, inertia = entry["stiffness_matrix"], entry["inertia_matrix"]
    grid = read_grid(stiffness["grid"])
    places = [(i, j) for i in range(6) for j in range(i, 6)]
    full = any(f"K{i + 1}{j + 1}" in stiffness for i, j in places if i != j)
    K = np.zeros((len(grid), 6, 6))
    for i, j in places if full else [(i, i) for i in range(6)]:
        K[:, i, j] = K[:, j, i] = stiffness[f"K{i + 1}{j + 1}"].numbers(len(grid))
    doubts: list[str] = []
    if not np.any(K[:, :2]):
        K[:, 0, 0] = K[:, 1, 1] = K[:, 2, 2]
        doubts.append(
            f"{stiffness.file}: {stiffness.place}: K11 and K22 are zero; K33 takes their place, "
            "and sections hardly shear"
        )
    found, M = _read_inertia(inertia, doubts)
    return SectionProperties(grid, K, interpolate_matrices(grid, found, M), tuple(doubts))


def read_damping(entry: Entry | None) -> tuple[float, ...]:
    """Factors of the stiffness in the damping matrix [s], zero where there are none.

    Args:
        entry: `elastic_properties` of blade or tower, with ``mu`` of shear along x and y, stretch,
            bending about x and y, and torsion; None where there are none.
    """
    damping = entry.get("structural_damping") if entry else None
    if damping is None or "mu" not in damping:
        return (0.0,) * 6
    mu = damping["mu"].numbers(6)
    if (mu < 0.0).any():
        damping["mu"].fail("must not be negative")
    return tuple(mu.tolist())


def _read_inertia(entry: Entry, doubts: list[str]) -> tuple[Array, Array]:
    """Stations of the mass, and its matrices there."""
    grid = read_grid(entry["grid"])
    m = entry["mass"].numbers(len(grid))
    x, y, edge, flap, polar, cross = (
        entry[key].numbers(len(grid)) if key in entry else np.zeros(len(grid))
        for key in ("cm_x", "cm_y", "i_edge", "i_flap", "i_plr", "i_cp")
    )
    if not np.any(flap) and np.any(np.abs(polar - edge) > SAME * polar):
        flap, cross = polar - edge, np.zeros(len(grid))
        doubts.append(
            f"{entry.file}: {entry.place}: i_flap is zero, though i_plr is not i_edge; "
            "i_plr - i_edge takes its place, and zero that of i_cp"
        )
    centre, seconds = np.column_stack([x, y]), np.column_stack([flap, edge, cross])
    return grid, make_inertia(m, centre, seconds)

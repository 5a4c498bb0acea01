"""Stiffness and mass of the sections of a beam along its axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.foundation.types import Array

EQUAL = 1e-6
"""Relative difference of entries of a matrix that shall be symmetric."""


@dataclass(frozen=True, eq=False)
class BeamSections:
    """Matrices of a Timoshenko beam, straight between stations.

    Rows and columns are the forces and strains along x, y, z, then the moments and curvatures about
    them, with x and y the directors of the section, and z along the axis. All are about the point
    where the axis crosses the section.

    Args:
        stations: Arc length along the axis, rising, shape (m,) [m].
        stiffness: Symmetric, positive definite, shape (m, 6, 6) [N, N m, N m^2].
        inertia: Mass matrix of the section, symmetric, shape (m, 6, 6) [kg/m, kg, kg m]. Read are
            M_33 (mass), M_35 and M_34 (its centre), M_44, M_55 and M_45 (second moments).
        viscosity: Times of stiffness-proportional damping of each strain, not negative, shape (6,)
            [s]; zero by default. The damping matrix is sqrt(t_i t_j) C_ij.

    Raises:
        ModelError: for matrices of another shape, and with the station for one that is not
            symmetric, not positive definite, or an inertia that no section can have.
    """

    stations: Array
    stiffness: Array
    inertia: Array
    viscosity: Array | tuple[float, ...] = (0.0,) * 6

    def __post_init__(self) -> None:
        m = np.size(self.stations)
        shapes = {"stations": (m,), "stiffness": (m, 6, 6), "inertia": (m, 6, 6), "viscosity": (6,)}
        for name, shape in shapes.items():
            words = f"finite numbers of the shape {shape}"
            values = check_array(f"{name} of a beam", getattr(self, name), shape, words)
            object.__setattr__(self, name, values)
        if m < 2 or np.any(np.diff(self.stations) <= 0.0):
            raise ModelError("stations of the sections of a beam must be two or more and rise")
        if np.any(np.asarray(self.viscosity) < 0.0):
            raise ModelError("viscosity of a beam must not be negative")
        for name in ("stiffness", "inertia"):
            self._check_symmetry(name, getattr(self, name))
        self._check_stiffness()
        self._check_inertia()

    def _check_symmetry(self, name: str, matrices: Array) -> None:
        """Raise a ModelError with the first station whose matrix is not symmetric."""
        # entries of forces and moments have other units: each against its diagonal
        root = np.sqrt(np.abs(np.einsum("mii->mi", matrices)))
        gaps = np.abs(matrices - matrices.swapaxes(1, 2))
        wrong = np.argwhere(gaps > EQUAL * root[:, :, None] * root[:, None, :])
        if len(wrong):
            k, i, j = wrong[0].tolist()
            raise ModelError(
                f"{name} of the beam at {self.stations[k]:g} m is not symmetric: entry {i + 1}, "
                f"{j + 1} is {matrices[k, i, j]:g}, and {j + 1}, {i + 1} is {matrices[k, j, i]:g}"
            )

    def _check_stiffness(self) -> None:
        """Raise a ModelError with the first station whose stiffness is not positive definite."""
        diagonal = np.einsum("mii->mi", self.stiffness)
        for k, i in np.argwhere(diagonal <= 0.0):
            raise ModelError(
                f"stiffness of the beam at {self.stations[k]:g} m is not positive definite: entry "
                f"{i + 1}, {i + 1} is {diagonal[k, i]:g}"
            )
        root = np.sqrt(diagonal)
        least = np.linalg.eigvalsh(self.stiffness / (root[:, :, None] * root[:, None, :]))[:, 0]
        for k in np.flatnonzero(least <= 1e-12):
            raise ModelError(
                f"stiffness of the beam at {self.stations[k]:g} m is not positive definite: its "
                "couplings are larger than its diagonal allows"
            )

    def _check_inertia(self) -> None:
        """Raise a ModelError with the first station whose mass or second moments cannot be."""
        A = moments_of(self.inertia)
        for k in np.flatnonzero(A[:, 0, 0] <= 0.0):
            raise ModelError(
                f"inertia of the beam at {self.stations[k]:g} m must have a positive mass, got "
                f"{A[k, 0, 0]:g} kg/m"
            )
        size = np.maximum(A[:, 1, 1] + A[:, 2, 2], 1e-12 * A[:, 0, 0])
        scale = np.sqrt(np.column_stack([A[:, 0, 0], size, size]))
        least = np.linalg.eigvalsh(A / (scale[:, :, None] * scale[:, None, :]))[:, 0]
        for k in np.flatnonzero(least < -EQUAL):
            raise ModelError(
                f"inertia of the beam at {self.stations[k]:g} m is that of no section: its second "
                "moments are less than what the centre of its mass alone has"
            )

    @property
    def mass(self) -> float:
        """Mass of the beam [kg]."""
        per_length = self.inertia[:, 2, 2]
        return float(0.5 * (per_length[1:] + per_length[:-1]) @ np.diff(self.stations))

    def stiffness_at(self, s: Array) -> Array:
        """C at arc lengths, shape (k, 6, 6)."""
        return interpolate_matrices(s, self.stations, self.stiffness)

    def moments_at(self, s: Array) -> Array:
        """Integrals of rho (1, xi, eta) (1, xi, eta)^T over sections, shape (k, 3, 3)."""
        return moments_of(interpolate_matrices(s, self.stations, self.inertia))


def moments_of(inertia: Array) -> Array:
    """Integrals of rho (1, xi, eta) (1, xi, eta)^T of mass matrices, shape (k, 3, 3)."""
    M = inertia
    rows = [
        [M[:, 2, 2], -M[:, 2, 4], M[:, 2, 3]],
        [-M[:, 2, 4], M[:, 4, 4], -M[:, 3, 4]],
        [M[:, 2, 3], -M[:, 3, 4], M[:, 3, 3]],
    ]
    return np.array(rows).transpose(2, 0, 1)

"""Turbulence boxes of Mann's model, with exact spectra at each point of a grid.

A box is a sum of waves exp(i k.x) with random phases, E(c_i c_j*) = C_ij dk_1 dk_2 dk_3. Points
across the wind lie metres apart, and waves too short for them look like longer ones there. So C is
not the spectral tensor Phi itself, but its sum over all waves that look alike,

    C_ij(k) = sum_mn Phi_ij(k_1, k_2 + 2 pi m/d_y, k_3 + 2 pi n/d_z),

by which the one-point spectra are those of the model, the cross spectrum of u and w too. Of far
waves, |m| or |n| above 2, only the sum over all k_2 and k_3 counts. The box is made twice as wide
and as high as needed, since it repeats itself. J. Mann, Wind field simulation, Probabilistic
Engineering Mechanics 13 (1998) 269-282.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
import numpy.typing as npt
import scipy.fft

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.box_grid import BoxGrid
from turbine_fenicsx.wind.mann_tensor import one_point_spectra, spectral_tensor

ISOTROPIC_DEVIATION = 0.55
"""Standard deviation of the isotropic turbulence over s_1, IEC 61400-1, annex C."""

LENGTH = 0.8
"""L over Lambda_1, IEC 61400-1, annex C."""

SHEAR = 3.9
"""Gamma, IEC 61400-1, annex C."""

ISOTROPIC_VARIANCE = 0.688
"""Variance of isotropic turbulence over (alpha epsilon L)^(2/3), (2/3) int k^4/(1+k^2)^(17/6)."""

NODES = 80
"""Wave numbers along the wind with a tensor; between them it is linear over their logarithm."""

NEAR = 2
"""Waves that look alike are added up to this m and n."""

Rule = tuple[Array, Array]
"""Points of a cell of wave numbers from its middle, in parts of the cell, and their weights."""

MIDDLE: Rule = (np.zeros(1), np.ones(1))
GAUSS: Rule = (np.array([-(0.15**0.5), 0.0, 0.15**0.5]), np.array([5.0, 8.0, 5.0]) / 18.0)


@dataclass(frozen=True)
class MannModel:
    """Mann's model with the parameters of IEC 61400-1.

    Args:
        speed: Mean wind [m/s].
        deviation: Standard deviation s_1 along the wind [m/s].
        length: Lambda_1 [m].
    """

    speed: float
    deviation: float
    length: float

    def spectra(self, f: Array) -> Array:
        """One-sided spectra of u, v and w and cross spectrum of u and w, shape (4, n) [m^2/s].

        Args:
            f: Frequencies [Hz].
        """
        k1 = 2.0 * np.pi * f / self.speed * self._L
        F = one_point_spectra(k1, SHEAR)[[0, 1, 2, 4]]
        return np.asarray(4.0 * np.pi / self.speed * self._L * self._scale * F)

    def make(self, grid: BoxGrid, seed: int) -> npt.NDArray[np.float32]:
        """Fluctuations on a grid, shape (n_x, n_z, n_y, 3) [m/s].

        The first wave along the wind has also what is slower than the box lasts.
        """
        n_x, n_y, n_z = grid.points
        k = grid.waves * self._L
        size = (2 * n_y, 2 * n_z)
        nodes, tensors = _tabulate(k[0], k[-1], size, grid.spacing[1:], self._L)
        phases = np.random.default_rng([seed, 3])
        waves = np.zeros((3, n_x // 2 + 1, 2 * n_z, 2 * n_y), dtype=np.complex64)
        extra = self._enlarge_first(k[0])
        place = np.interp(np.log(k), np.log(nodes), np.arange(len(nodes)))
        for i, s in enumerate(place):
            j = min(int(s), len(nodes) - 2)
            C = (1.0 - s + j) * tensors[j] + (s - j) * tensors[j + 1]
            n = np.exp(2j * np.pi * phases.random((3, 2 * n_z, 2 * n_y)))
            waves[:, i + 1] = (extra if i == 0 else 1.0) * _take_root(C, n)
        waves *= np.sqrt(self._scale * k[0])
        shape = (2 * n_z, 2 * n_y, n_x)
        fields = scipy.fft.irfftn(waves, shape, axes=(2, 3, 1), norm="forward")
        return np.ascontiguousarray(np.moveaxis(fields[:, :, :n_z, :n_y], 0, -1), np.float32)

    @property
    def _L(self) -> float:
        """L of the tensor [m]."""
        return LENGTH * self.length

    @property
    def _scale(self) -> float:
        """(alpha epsilon L)^(2/3) [m^2/s^2]."""
        return (ISOTROPIC_DEVIATION * self.deviation) ** 2 / ISOTROPIC_VARIANCE

    @staticmethod
    def _enlarge_first(first: float) -> float:
        """Factor of the first wave, which has all that is slower, by the spectrum of u."""
        k = np.linspace(0.01, 1.5, 30) * first
        F = one_point_spectra(k, SHEAR)[0]
        return float(np.sqrt(1.5 * F.mean() / np.interp(first, k, F)))


@lru_cache(maxsize=2)
def _tabulate(
    first: float, last: float, size: tuple[int, int], spacing: tuple[float, float], L: float
) -> tuple[Array, Array]:
    """Wave numbers k_1 L and C_ij dk_2 dk_3 at them, shape (nodes, 6, n_z, n_y) [-].

    Args:
        first: The least k_1 L.
        last: The largest.
        size: Points of the box across the wind and upwards.
        spacing: Distances between them [m].
    """
    nodes = np.geomspace(first, last, NODES)
    (n_y, n_z), (d_y, d_z) = size, spacing
    k2, k3 = (2.0 * np.pi * np.fft.fftfreq(n, d / L) for n, d in ((n_y, d_y), (n_z, d_z)))
    dk2, dk3 = 2.0 * np.pi * L / (n_y * d_y), 2.0 * np.pi * L / (n_z * d_z)
    exact, dense = one_point_spectra(nodes, SHEAR), _crowd_points()
    found = np.empty((NODES, 6, n_z, n_y))

    def integrate(k1: float, k2: Array, k3: Array, rule2: Rule, rule3: Rule) -> Array:
        """The tensor over the cells around wave numbers, shape (6, n_3, n_2)."""
        (p, v), (q, w) = rule2, rule3
        a, b = k2[:, None] + p * dk2, (k3[:, None] + q * dk3)[:, :, None, None]
        Phi = spectral_tensor(np.full((1, 1, 1, 1), k1), a, b, SHEAR)
        return np.asarray(np.einsum("cnqmp,q,p->cnm", Phi, w, v) * dk2 * dk3)

    for C, k1, F in zip(found, nodes, exact.T, strict=True):
        C[:] = integrate(k1, k2, k3, GAUSS, GAUSS)
        # long eddies are a narrow ridge along k_2 = 0
        C[:, :, :1] = integrate(k1, k2[:1], k3, dense, dense)
        for m, n in product(range(-NEAR, NEAR + 1), repeat=2):
            if m or n:
                C += integrate(k1, k2 + m * n_y * dk2, k3 + n * n_z * dk3, MIDDLE, MIDDLE)
        C += _bound(F - C.sum(axis=(1, 2)))[:, None, None] / (n_y * n_z)
    return nodes, found


def _bound(rest: Array) -> Array:
    """The part of a tensor of shape (6,) that can be a covariance, by the symmetry in y."""
    u, v, w, _, uw, _ = rest
    u, v, w = np.maximum([u, v, w], 0.0)
    return np.array([u, v, w, 0.0, np.clip(uw, -np.sqrt(u * w), np.sqrt(u * w)), 0.0])


def _crowd_points() -> Rule:
    """Points of a cell that crowd in its middle."""
    t = (np.arange(8) + 0.5) / 8
    p, v = 0.5 * t**4, 2.0 * t**3 / 8
    return np.concatenate([-p[::-1], p]), np.concatenate([v[::-1], v])


def _take_root(C: Array, n: Array) -> Array:
    """Factor of Cholesky of C, shape (6, ...), times vectors n, shape (3, ...)."""
    C11, C22, C33, C12, C13, C23 = C
    A11 = np.sqrt(C11)
    A21, A31 = C12 / A11, C13 / A11
    A22 = np.sqrt(np.maximum(C22 - A21**2, 0.0))
    A32 = (C23 - A31 * A21) / np.maximum(A22, 1e-9 * A11)
    A33 = np.sqrt(np.maximum(C33 - A31**2 - A32**2, 0.0))
    return np.stack([A11 * n[0], A21 * n[0] + A22 * n[1], A31 * n[0] + A32 * n[1] + A33 * n[2]])

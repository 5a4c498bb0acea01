"""Turbulence of IEC 61400-1 by Kaimal's spectra and exponential coherence.

With the mean wind V, the standard deviation s_1 along it, Lambda_1, and the distance r of two
points in the plane across the wind, the one-sided spectra and the coherence of u are (edition 4,
annex C)

    S_k(f) = 4 s_k^2 (L_k/V)/(1 + 6 f L_k/V)^(5/3),      s = s_1 (1, 0.8, 0.5),
    L = Lambda_1 (8.1, 2.7, 0.66),
    Coh(r, f) = exp(-12 ((f r/V)^2 + (0.12 r/L_1)^2)^(1/2)).

v and w have no coherence, for which the standard gives none. The waves of each frequency have
random phases, and the factor of Cholesky of the coherence combines those of u: P. S. Veers,
Three-dimensional wind simulation, SAND88-0152 (1988).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.fft

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.wind.box_grid import BoxGrid

DEVIATIONS = (1.0, 0.8, 0.5)
"""Standard deviations of u, v and w over that of u."""

LENGTHS = (8.1, 2.7, 0.66)
"""Integral lengths L_k over Lambda_1."""

DECAY, OFFSET = 12.0, 0.12

BAND = 1.03
"""Frequencies with decays of the coherence in this ratio share a factor; coherence to 0.006."""

ALONE = 12.0
"""Neighbours whose coherence is exp(-12) or less have none."""


@dataclass(frozen=True)
class KaimalModel:
    """Kaimal's spectra with exponential coherence.

    Args:
        speed: Mean wind V [m/s].
        deviation: Standard deviation s_1 along the wind [m/s].
        length: Lambda_1 [m].
    """

    speed: float
    deviation: float
    length: float

    def spectra(self, f: Array) -> Array:
        """One-sided spectra S_k of u, v and w at frequencies, shape (3, n) [m^2/s]."""
        s, T = self._scales
        return np.asarray(4.0 * s**2 * T / (1.0 + 6.0 * f * T) ** (5.0 / 3.0))

    def coherence(self, r: Array, f: float) -> Array:
        """Coherence of u at distances and a frequency, in the shape of the distances [-]."""
        return np.asarray(np.exp(-self._decay(f) * r))

    def make(self, grid: BoxGrid, seed: int) -> npt.NDArray[np.float32]:
        """Fluctuations on a grid, shape (n_x, n_z, n_y, 3) [m/s].

        The first wave also has what is slower than the box lasts; what is faster than two planes
        is left out, by which deviations are some per cent smaller.
        """
        n_x, n_y, n_z = grid.points
        y, z = grid.sides
        places = np.stack(np.meshgrid(y, z, indexing="xy"), axis=-1).reshape(-1, 2)
        f = grid.waves * self.speed / (2.0 * np.pi)
        amplitudes = np.sqrt(0.5 * self._variances(f))
        values = np.empty((n_x, n_z * n_y, 3), dtype=np.float32)
        for k in range(3):
            phases = np.random.default_rng([seed, k]).random((len(f), len(places)))
            waves = np.exp(2j * np.pi * phases)
            if k == 0:
                self._correlate(waves, f, places)
            waves *= amplitudes[k, :, None]
            spectrum = np.zeros((n_x // 2 + 1, len(places)), dtype=complex)
            spectrum[1 : 1 + len(f)] = waves
            values[..., k] = scipy.fft.irfft(spectrum, n_x, axis=0, norm="forward")
        return values.reshape(n_x, n_z, n_y, 3)

    @property
    def _scales(self) -> tuple[Array, Array]:
        """Standard deviations [m/s] and L_k/V [s], shape (3, 1)."""
        s, L = np.array(DEVIATIONS)[:, None], np.array(LENGTHS)[:, None]
        return self.deviation * s, self.length / self.speed * L

    def _decay(self, f: npt.ArrayLike) -> Array:
        """The coherence falls by exp(-decay r) [1/m]."""
        least = OFFSET / (LENGTHS[0] * self.length)
        return np.asarray(DECAY * np.hypot(np.asarray(f) / self.speed, least))

    def _variances(self, f: Array) -> Array:
        """Variances of waves, which have the spectrum around them, shape (3, n) [m^2/s^2]."""
        s, T = self._scales
        ends = np.concatenate([[0.0], f + 0.5 * f[0]])
        # the integral of S_k from 0 to f is s^2 (1 - (1 + 6 f T)^(-2/3))
        parts = -np.diff((1.0 + 6.0 * ends * T) ** (-2.0 / 3.0), axis=1)
        return np.asarray(s**2 * parts)

    def _correlate(self, waves: npt.NDArray[np.complex128], f: Array, places: Array) -> None:
        """Combine independent waves of u at places, shape (f, places), by their coherence."""
        distances = np.linalg.norm(places[:, None] - places[None], axis=2)
        near = np.min(distances[0, 1:])
        for band in _list_bands(self._decay(f)):
            decay = float(np.mean(self._decay(f[band])))
            if decay * near > ALONE:
                return
            coherence = np.exp(-decay * distances)
            factor = np.linalg.cholesky(coherence + 1e-9 * np.eye(len(places)))
            for part in (waves.real, waves.imag):
                part[band] = part[band] @ factor.T


def _list_bands(decay: Array) -> Iterator[IntArray]:
    """Numbers of frequencies whose decays of the coherence are nearly the same, rising."""
    bands = np.floor(np.log(decay / decay[0]) / np.log(BAND))
    ends = np.flatnonzero(np.diff(bands)) + 1
    yield from np.split(np.arange(len(decay)), ends)

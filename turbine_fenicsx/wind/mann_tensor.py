"""Mann's spectral tensor of turbulence that uniform shear has distorted.

J. Mann, The spatial structure of neutral atmospheric surface-layer turbulence, Journal of Fluid
Mechanics 273 (1994) 141-168, and Wind field simulation, Probabilistic Engineering Mechanics 13
(1998) 269-282. Axes are x along the wind, y across it, z up. Wave numbers are times L here, and the
tensor is over (alpha epsilon)^(2/3) L^(11/3), so that it depends on Gamma alone.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.special

from turbine_fenicsx.foundation.types import Array

_LOGS = np.linspace(-14.0, 14.0, 4001)
"""Logarithms of wave numbers at which the lifetime of eddies is tabulated."""


@lru_cache(maxsize=4)
def _tabulate_lifetime(shear: float) -> Array:
    """Beta of eddies at the wave numbers of the table."""
    k = np.exp(_LOGS)
    hyper = scipy.special.hyp2f1(1.0 / 3.0, 17.0 / 6.0, 4.0 / 3.0, -(k**-2.0))
    return np.asarray(shear * k ** (-2.0 / 3.0) / np.sqrt(hyper))


def spectral_tensor(k1: Array, k2: Array, k3: Array, shear: float) -> Array:
    """Phi_ij of the directions 11, 22, 33, 12, 13 and 23, shape (6, ...) [-].

    Args:
        k1: Wave numbers along the wind times L, not zero; broadcast with the others.
        k2: Across it.
        k3: Upwards.
        shear: Gamma, the distortion by shear; 0 for isotropic turbulence [-].
    """
    k1, k2, k3 = np.broadcast_arrays(k1, k2, k3)
    flat, k = k1**2 + k2**2, np.sqrt(k1**2 + k2**2 + k3**2)
    # lifetime of eddies, equation (3.6) of 1994
    beta = np.interp(np.log(k), _LOGS, _tabulate_lifetime(shear))
    k30 = k3 + beta * k1
    k0 = np.sqrt(flat + k30**2)
    # equations (3.16), (3.17) and (3.13), (3.15) of 1994
    C1 = beta * k1**2 * (k0**2 - 2.0 * k30**2 + beta * k1 * k30) / (k**2 * flat)
    angle = np.arctan2(beta * k1 * np.sqrt(flat), k0**2 - k30 * k1 * beta)
    C2 = k2 * k0**2 / flat**1.5 * angle
    z1, z2 = C1 - k2 / k1 * C2, k2 / k1 * C1 + C2
    # energy of von Karman, E(k0) = k0^4/(1 + k0^2)^(17/6)
    near = (1.0 + k0**2) ** (-17.0 / 6.0) / (4.0 * np.pi)
    mixed, far = near * (k0 / k) ** 2, near * (k0 / k) ** 4
    # equations (3.18) to (3.23) of 1994
    return np.stack(
        [
            near * (k0**2 - k1**2 - 2.0 * k1 * k30 * z1 + flat * z1**2),
            near * (k0**2 - k2**2 - 2.0 * k2 * k30 * z2 + flat * z2**2),
            far * flat,
            near * (-k1 * k2 - k1 * k30 * z2 - k2 * k30 * z1 + flat * z1 * z2),
            mixed * (-k1 * k30 + flat * z1),
            mixed * (-k2 * k30 + flat * z2),
        ]
    )


def one_point_spectra(k1: Array, shear: float) -> Array:
    """Two-sided spectra F_ij(k1) of the directions of `spectral_tensor`, shape (6, n) [-].

    They are the integral of the tensor over k2 and k3, by rings around k1, over
    (alpha epsilon)^(2/3) L^(5/3).
    """
    logs = np.linspace(-9.0, 12.0, 281)  # of the radius of a ring over (k1^2 + 1)^(1/2)
    angles = np.pi * ((np.arange(48) + 0.5) / 48 - 0.5)  # where k2 > 0, by symmetry
    y, z = np.cos(angles), np.sin(angles)
    found = []
    for k in np.asarray(k1, dtype=float):
        r = np.exp(logs)[:, None] * np.sqrt(k**2 + 1.0)
        Phi = spectral_tensor(np.full((1, 1), k), r * y, r * z, shear)
        found.append((Phi * r**2).sum(axis=(1, 2)) * (logs[1] - logs[0]) * 2.0 * np.pi / 48)
    return np.array(found).T * [[1.0], [1.0], [1.0], [0.0], [1.0], [0.0]]

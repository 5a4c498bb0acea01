"""Frequency and decay of a measured vibration, and what time steps add to them.

Measured values are fitted by q = c exp(s_h t) + c_0. A step of the midpoint rule makes s_h of s,

    s = (2/h) tanh(s_h h/2).

Seen from what turns, values of one that whirls have the frequency of s + i Omega where it goes
round against the rotation, and s - i Omega where with it. There the midpoint rule does this.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class Decay:
    """A vibration and its fit.

    Args:
        times: Shape (n,) [s].
        measured: q, relative to the largest, complex, shape (n,).
        fitted: The same of the fit.
        with_steps: s_h [rad/s].
        eigenvalue: s; s_h where steps are not undone [rad/s].
    """

    times: Array
    measured: Array
    fitted: Array
    with_steps: complex
    eigenvalue: complex

    @property
    def miss(self) -> float:
        """Largest distance of measured and fitted values."""
        return float(np.max(np.abs(self.measured - self.fitted)))


def fit_decay(
    times: Array, values: Array, guess: complex, step: float | None = None, shift: float = 0.0
) -> Decay:
    """Fit a vibration.

    Args:
        times: Shape (n,) [s].
        values: q, complex, shape (n,).
        guess: Of s [rad/s].
        step: h, whose part is undone [s]; None leaves it in.
        shift: Of the frequency where h is undone [rad/s].
    """
    q = values / np.max(np.abs(values))

    def model(p: Array) -> Array:
        constant = complex(p[4], p[5])
        return np.asarray(complex(p[0], p[1]) * np.exp(complex(p[2], p[3]) * times) + constant)

    def miss(p: Array) -> Array:
        difference = model(p) - q
        return np.concatenate([difference.real, difference.imag])

    start = [q[0].real, q[0].imag, guess.real, guess.imag, 0.0, 0.0]
    p = least_squares(miss, start, x_scale=[1.0, 1.0, abs(guess), abs(guess), 1.0, 1.0]).x
    found = complex(p[2], p[3])
    undone = found
    if step is not None:
        there = found + 1j * shift
        undone = complex(2.0 / step * np.tanh(0.5 * there * step)) - 1j * shift
    return Decay(times, q, model(p), found, undone)

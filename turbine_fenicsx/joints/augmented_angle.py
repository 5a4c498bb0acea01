"""Augmented joint angles: the angle Theta as an extra coordinate, eqs (15)-(18), (24).

The constraint ties Theta to the functions c and s of the directors that equal its cosine and sine.
Two forms exist. Both take arrays over all joint angles; index 0 and 1 are the two ends of the step,
D = Theta_1 - Theta_0, m marks means.

`regular` (default)     Phi = sin(Theta) c - cos(Theta) s,     dPhi/dTheta = 1 on the manifold;
`paper`                 Phi = c - cos(Theta) - s + sin(Theta), dPhi/dTheta = cos + sin, eq. (18),
                        which vanishes at -45 and 135 degrees: the step then picks a wrong branch.

A discrete gradient consists of the factors g_c, g_s of grad c and grad s at the midpoint, and of
g_T, such that  g_c (c1 - c0) + g_s (s1 - s0) + g_T D = Phi_1 - Phi_0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.types import Array


class AngleTerms(NamedTuple):
    """Constraint, discrete gradient and their derivatives with respect to the end of the step.

    Every entry has shape (n_T,). ``X_y`` is the derivative of X with respect to y at t_{n+1}.
    """

    Phi: Array
    Phi_T: Array
    Phi_c: Array
    Phi_s: Array
    g_c: Array
    g_s: Array
    g_T: Array
    g_c_T: Array
    g_s_T: Array
    g_T_T: Array
    g_T_c: Array
    g_T_s: Array


AngleForm = Callable[[Array, Array, Array, Array, Array, Array], AngleTerms]
"""A form of the constraint: (Theta_0, Theta_1, c0, c1, s0, s1) -> AngleTerms."""


def sinc(x: Array) -> Array:
    """sin(x)/x, 1 at x = 0."""
    safe = np.where(x == 0.0, 1e-20, x)
    ratio: Array = np.sin(safe) / safe
    return ratio


_POWERS = np.arange(5.0)
_SERIES = np.array([-1 / 3, 1 / 30, -1 / 840, 1 / 45360, -1 / 3991680])


def sinc_derivative(x: Array) -> Array:
    """Derivative of `sinc`: (cos x - sinc x)/x, by its series near zero."""
    small = np.abs(x) < 0.1
    series: Array = x * ((x * x)[..., None] ** _POWERS @ _SERIES)
    if small.all():
        return series
    safe = np.where(small, 1.0, x)
    return np.where(small, series, (np.cos(safe) - np.sin(safe) / safe) / safe)


def regular(T0: Array, T1: Array, c0: Array, c1: Array, s0: Array, s1: Array) -> AngleTerms:
    """Form without singularity, sin(Theta) c - cos(Theta) s."""
    half_D = 0.5 * (T1 - T0)
    angles = np.array([T0, T1, T0 + half_D])
    sin, cos = np.sin(angles), np.cos(angles)
    half_sin, half_cos = 0.5 * sin, 0.5 * cos
    c, s = np.array([c1, 0.5 * (c0 + c1)]), np.array([s1, 0.5 * (s0 + s1)])  # end and mean
    # Phi = sin(Theta) c - cos(Theta) s at the end of the step, and its discrete gradient
    along_1, along = cos[1:] * c + sin[1:] * s
    across_1, across = cos[1:] * s - sin[1:] * c
    w, w_T = sinc(half_D), 0.5 * sinc_derivative(half_D)
    return AngleTerms(
        Phi=-across_1,
        Phi_T=along_1,
        Phi_c=sin[1],
        Phi_s=-cos[1],
        g_c=half_sin[0] + half_sin[1],
        g_s=-half_cos[0] - half_cos[1],
        g_T=w * along,
        g_c_T=half_cos[1],
        g_s_T=half_sin[1],
        g_T_T=w_T * along + (0.5 * w) * across,
        g_T_c=w * half_cos[2],
        g_T_s=w * half_sin[2],
    )


def paper(T0: Array, T1: Array, c0: Array, c1: Array, s0: Array, s1: Array) -> AngleTerms:
    """The paper's form with its discrete gradient (24); singular at -45 and 135 degrees."""
    D, Tm = T1 - T0, 0.5 * (T0 + T1)
    sin_m, cos_m = np.sin(Tm), np.cos(Tm)
    w, w_T = sinc(0.5 * D), 0.5 * sinc_derivative(0.5 * D)
    one, zero = np.ones_like(D), np.zeros_like(D)
    # Phi of eq. (18) and its discrete gradient, eq. (24)
    return AngleTerms(
        Phi=c1 - np.cos(T1) - s1 + np.sin(T1),
        Phi_T=np.sin(T1) + np.cos(T1),
        Phi_c=one,
        Phi_s=-one,
        g_c=one,
        g_s=-one,
        g_T=w * (cos_m + sin_m),
        g_c_T=zero,
        g_s_T=zero,
        g_T_T=w_T * (cos_m + sin_m) + 0.5 * w * (cos_m - sin_m),
        g_T_c=zero,
        g_T_s=zero,
    )


FORMS: dict[str, AngleForm] = {"regular": regular, "paper": paper}
"""The selectable forms of the constraint by name."""


def on_right_branch(D: Array, T1: Array, c1: Array, s1: Array) -> bool:
    """Whether a step may be accepted: the roots of the constraint repeat every pi.

    True if cos(Theta_1) c1 + sin(Theta_1) s1 > 0 and |D| < pi/2 for all angles.
    """
    right = (np.cos(T1) * c1 + np.sin(T1) * s1 > 0.0) & (np.abs(D) < np.pi / 2)
    return bool(right.all())

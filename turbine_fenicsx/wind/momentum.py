"""Blade-element momentum theory of one annulus: the inflow angle that balances both.

A. Ning, "A simple solution method for the blade element momentum equations with guaranteed
convergence", Wind Energy 17 (2014) 1327-1345, writes both balances as one residual in the inflow
angle phi. His form divides by V_y and has a pole where the swirl equals it. This one has neither,
so sections that stand or move backwards have one balance too:

    R(phi) = sin(phi)/(1 - a) (V_y/V_x + t) - cos(phi) = 0,    0 < phi < pi,
    t = w_t/V_x = sigma C_t (1 - a)/(4 F sin^2(phi)),

with Prandtl's losses F at tip and hub, and Buhl's thrust coefficient where the momentum theory
fails. Induced velocities never exceed the wind: |a| <= 1 and |w_t| <= |V_y|. All annuli are solved
together, by a method that is never slower than bisection by more than a step: I. F. D. Oliveira,
R. H. C. Takahashi, "An enhancement of the bisection method average performance preserving minmax
optimality", ACM Transactions on Mathematical Software 47 (2021) 5.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.types import Array

SMALLEST = 1e-6
"""Smallest distance of the inflow angle from 0 and pi [rad]."""

ACCURACY = 2e-15
"""Of the inflow angle [rad]."""

HALVINGS = 51
"""Number of halvings of the interval from 0 to pi that leave twice the accuracy, and one more."""

MOMENTUM_FAILS = 2.0 / 3.0
"""kappa from which on Buhl's relation holds; the axial induction is 0.4 there."""

MAX_INDUCTION = 1.0
"""Maximum magnitude of a and a': no induced velocity exceeds the wind [-]."""

ROUND_OFF = 1e-12
"""Minimum of 1 - a where it divides [-]."""

FADE = (1.0, 2.0)
"""Tip-speed ratios without and with full induction. A rotor that hardly turns has no annuli whose
momentum its few blades could change; AeroDyn 15 fades between the same ratios."""


def find_induction_share(tip_speed: float, wind_speed: float) -> float:
    """Share of the loads that the wake balances: 0 for a rotor that hardly turns, 1 in operation.

    The share rises smoothly, as (1 - cos(pi x))/2, between the tip-speed ratios `FADE`.

    Args:
        tip_speed: Rotor speed times radius, of any sign [m/s].
        wind_speed: Speed of the mean wind in any direction, not negative [m/s].
    """
    first, last = FADE
    if abs(tip_speed) >= last * wind_speed:
        return 1.0
    x = max(0.0, (abs(tip_speed) / wind_speed - first) / (last - first))
    return float(0.5 - 0.5 * np.cos(np.pi * x))


class Annuli(NamedTuple):
    """Geometry of all annuli, arrays that broadcast with each other.

    Attributes:
        radius: r [m].
        solidity: sigma = B c/(2 pi r) [-].
        blades: B, the number of blades.
        tip_radius: R [m].
        hub_radius: R_h [m].
    """

    radius: Array
    solidity: Array
    blades: int
    tip_radius: float
    hub_radius: float

    def loss(self, phi: Array) -> Array:
        """Prandtl's factor F of tip and hub losses [-]."""
        s = np.abs(np.sin(phi))
        factor = np.ones(np.broadcast(phi, self.radius).shape)
        for outer, inner, end in (
            (self.tip_radius, self.radius, self.radius),
            (self.radius, self.hub_radius, self.hub_radius),
        ):
            exponent = 0.5 * self.blades * (outer - inner) / (end * s)
            factor = factor * (2.0 / np.pi) * np.arccos(np.exp(-np.maximum(exponent, 0.0)))
        return factor


class Induction(NamedTuple):
    """Induction of the rotor at each annulus.

    Attributes:
        phi: Inflow angle, from the rotor plane [rad].
        axial: a; the axial wind at the rotor is (1 - a) V_x [-].
        tangential: a' = w_t/V_y; the tangential wind is (1 + a') V_y. 0 where V_y is 0 [-].
    """

    phi: Array
    axial: Array
    tangential: Array


Lookup = Callable[[Array], tuple[Array, Array]]
"""C_l and C_d for inflow angles phi."""


def solve_momentum(
    annuli: Annuli, V_x: Array, V_y: Array, polars: Lookup, share: float = 1.0
) -> Induction:
    """Inflow angles and induction of all annuli.

    Args:
        V_x: Wind through the rotor plane [m/s].
        V_y: Wind in the rotor plane, against the motion of the section, of any sign [m/s].
        polars: C_l and C_d of all annuli at inflow angles.
        share: Share of the loads that the wake balances, see `find_induction_share`.

    Returns:
        The induction; none where V_x is not positive.
    """
    shape = np.broadcast(V_x, V_y, annuli.radius).shape
    V_x, V_y = (np.broadcast_to(V, shape) for V in (V_x, V_y))
    through = V_x > 0.0
    ratio = V_y / np.where(through, V_x, 1.0)
    annuli = annuli._replace(solidity=share * annuli.solidity)

    def residual(phi: Array) -> Array:
        a, t = _find_induction(annuli, polars, phi, ratio)
        found = np.sin(phi) / np.maximum(1.0 - a, ROUND_OFF) * (ratio + t) - np.cos(phi)
        return np.asarray(found)

    phi = _find_root(residual, np.full(shape, SMALLEST), np.full(shape, np.pi - SMALLEST))
    found = _find_induction(annuli, polars, phi, ratio)
    a, t = (np.where(through, x, 0.0) for x in found)
    w_t = t * V_x
    a_prime = w_t / np.where(V_y == 0.0, np.inf, V_y)
    return Induction(np.arctan2((1.0 - a) * V_x, V_y + w_t), a, a_prime)


def _find_root(function: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Where functions rise through zero, with the middle, the secant and a step beyond its root.

    Functions that are positive all the way have theirs at `low`, others without a root at `high`.
    """
    f_low, f_high = function(low), function(high)
    shift = 0.2 / (high - low)
    for halving in range(HALVINGS):
        width = high - low
        if np.all(width <= 2.0 * ACCURACY):
            break
        middle = 0.5 * (low + high)
        with np.errstate(divide="ignore", invalid="ignore"):  # without a change of sign
            root = (f_high * low - f_low * high) / (f_high - f_low)
        side = np.sign(middle - root)
        beyond = np.maximum(shift * width * width, ACCURACY)
        is_inside = (low <= root) & (root <= high) & (beyond <= np.abs(middle - root))
        near = np.where(is_inside, root + side * beyond, middle)
        # as far from the middle as a bisection may still catch up with
        far = np.maximum(ACCURACY * 2.0 ** (HALVINGS - halving) - 0.5 * width, 0.0)
        guess = np.clip(near, middle - far, middle + far)
        f = function(guess)
        positive = f > 0.0
        low, f_low = np.where(positive, low, guess), np.where(positive, f_low, f)
        high, f_high = np.where(positive, guess, high), np.where(positive, f, f_high)
    return 0.5 * (low + high)


def _find_induction(
    annuli: Annuli, polars: Lookup, phi: Array, ratio: Array
) -> tuple[Array, Array]:
    """Induction a and t = w_t/V_x that balance the loads at inflow angles, |a| and |a'| <= 1."""
    C_l, C_d = polars(phi)
    s, c = np.sin(phi), np.cos(phi)
    C_n, C_t = C_l * c + C_d * s, C_l * s - C_d * c
    F = annuli.loss(phi)
    # kappa = sigma C_n/(4 F sin^2 phi) and t = sigma C_t (1 - a)/(4 F sin^2 phi)
    by_momentum = annuli.solidity / (4.0 * F * s * s)
    a = axial_induction(by_momentum * C_n, F)
    limit = MAX_INDUCTION * np.abs(ratio)
    t = np.clip(by_momentum * C_t * (1.0 - a), -limit, limit)
    return a, t


def induction_of_thrust(C_T: Array, F: Array) -> Array:
    """The axial induction a of a thrust coefficient, the inverse of both relations.

    Args:
        C_T: Local thrust coefficient [-].
        F: Factor of Prandtl's losses [-].
    """
    load = C_T / F
    momentum = 0.5 * (1.0 - np.sqrt(np.maximum(1.0 - load, 0.0)))
    # Buhl, C_T = 8/9 + (4 F - 40/9) a + (50/9 - 4 F) a^2, from a = 0.4 on
    root = np.sqrt(np.maximum(C_T * (50.0 - 36.0 * F) + 12.0 * F * (3.0 * F - 4.0), 0.0))
    buhl = (18.0 * F - 20.0 - 3.0 * root) / (36.0 * F - 50.0)
    return np.asarray(np.where(load <= 4.0 * 0.4 * 0.6, momentum, buhl))


def axial_induction(kappa: Array, F: Array) -> Array:
    """The axial induction a from kappa = sigma C_n/(4 F sin^2 phi), between -1 and 1.

    Args:
        kappa: kappa; negative where the rotor drives the wind [-].
        F: Factor of Prandtl's losses [-].
    """
    # a = -1, the limit, has kappa = -1/2
    kappa = np.maximum(kappa, -MAX_INDUCTION / (1.0 + MAX_INDUCTION))
    momentum = kappa / (1.0 + kappa)
    # Buhl: C_T = 8/9 + (4 F - 40/9) a + (50/9 - 4 F) a^2, met at a = 0.4
    g_1 = 2.0 * F * kappa - (10.0 / 9.0 - F)
    g_2 = np.maximum(2.0 * F * kappa - F * (4.0 / 3.0 - F), 0.0)
    g_3 = 2.0 * F * kappa - (25.0 / 9.0 - 2.0 * F)
    root = np.sqrt(g_2)
    near = np.abs(g_3) < 1e-6
    with np.errstate(divide="ignore"):
        buhl = np.where(near, 1.0 - 0.5 / root, (g_1 - root) / np.where(near, 1.0, g_3))
    return np.asarray(np.where(kappa <= MOMENTUM_FAILS, momentum, buhl))

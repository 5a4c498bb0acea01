"""Blade-element momentum theory of one annulus: which inflow angle balances both.

The residual in the inflow angle phi alone, its brackets and the empirical region are those of
A. Ning, "A simple solution method for the blade element momentum equations with guaranteed
convergence", Wind Energy 17 (2014) 1327-1345, with Prandtl's losses at tip and hub and Buhl's
thrust coefficient where the momentum theory fails. All annuli are solved at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.types import Array

SMALLEST = 1e-6
"""Inflow angles closer to 0 and pi are not looked at [rad]."""

HALVINGS = 50
"""Halvings of an interval below pi: they leave 3e-15 rad."""

MOMENTUM_FAILS = 2.0 / 3.0
"""kappa from which on Buhl's relation holds; the axial induction is 0.4 there."""


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
    """What the rotor does to the wind at each annulus.

    Attributes:
        phi: Inflow angle, from the rotor plane [rad].
        axial: a; the axial wind at the rotor is (1 - a) V [-].
        tangential: a'; the tangential wind is (1 + a') times that of the rotation [-].
    """

    phi: Array
    axial: Array
    tangential: Array


Lookup = Callable[[Array], tuple[Array, Array]]
"""C_l and C_d for inflow angles phi."""


def solve_momentum(annuli: Annuli, V_x: Array, V_y: Array, polars: Lookup) -> Induction:
    """Inflow angles and induction of all annuli.

    Args:
        annuli: Their geometry.
        V_x: Wind through the rotor plane [m/s].
        V_y: Wind in the rotor plane, from the rotation, positive [m/s].
        polars: C_l and C_d of all annuli at inflow angles.

    Returns:
        The induction; where no angle balances (no wind, no rotation) there is none of it.
    """
    shape = np.broadcast(V_x, V_y, annuli.radius).shape
    V_x, V_y = (np.broadcast_to(V, shape) for V in (V_x, V_y))

    def residual(phi: Array) -> Array:
        return _balance(annuli, V_x, V_y, polars, phi)[0]

    # turbine, windmill brake with V_x < 0, and the rest (Ning, section 2.3)
    brackets = (SMALLEST, np.pi / 2), (-np.pi / 4, -SMALLEST), (np.pi / 2, np.pi - SMALLEST)
    low, high = np.zeros(shape), np.zeros(shape)
    found = np.zeros(shape, dtype=bool)
    for first, last in brackets:
        change = residual(np.full(shape, first)) * residual(np.full(shape, last)) < 0.0
        new = change & ~found
        low, high = np.where(new, first, low), np.where(new, last, high)
        found |= new
    sign = np.sign(residual(np.where(found, low, 1.0)))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        beyond = sign * residual(np.where(found, middle, 1.0)) <= 0.0
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    phi = np.where(found, 0.5 * (low + high), np.arctan2(V_x, V_y))
    _, a, a_prime = _balance(annuli, V_x, V_y, polars, np.where(found, phi, 1.0))
    return Induction(phi, np.where(found, a, 0.0), np.where(found, a_prime, 0.0))


def _balance(
    annuli: Annuli, V_x: Array, V_y: Array, polars: Lookup, phi: Array
) -> tuple[Array, Array, Array]:
    """Residual of Ning's equation, a and a' for inflow angles."""
    C_l, C_d = polars(phi)
    s, c = np.sin(phi), np.cos(phi)
    C_n, C_t = C_l * c + C_d * s, C_l * s - C_d * c
    F = annuli.loss(phi)
    kappa = annuli.solidity * C_n / (4.0 * F * s * s)
    kappa_t = annuli.solidity * C_t / (4.0 * F * s * c)
    # axial: momentum theory, Buhl's relation, propeller brake
    a = axial_induction(kappa, F, phi)
    a_prime = kappa_t / (1.0 - kappa_t)
    ratio = np.where(V_y == 0.0, np.inf, V_x / np.where(V_y == 0.0, 1.0, V_y))
    forward = s / (1.0 - a) - ratio * c * (1.0 - kappa_t)
    backward = s * (1.0 - kappa) - ratio * c * (1.0 - kappa_t)
    return np.where(phi > 0.0, forward, backward), a, a_prime


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


def axial_induction(kappa: Array, F: Array, phi: Array) -> Array:
    """The axial induction a from kappa = sigma C_n/(4 F sin^2 phi).

    Args:
        kappa: kappa [-].
        F: Factor of Prandtl's losses [-].
        phi: Inflow angle; its sign tells a turbine from a propeller brake [rad].
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        momentum = kappa / (1.0 + kappa)
        # Buhl: C_T = 8/9 + (4 F - 40/9) a + (50/9 - 4 F) a^2, met at a = 0.4
        g_1 = 2.0 * F * kappa - (10.0 / 9.0 - F)
        g_2 = np.maximum(2.0 * F * kappa - F * (4.0 / 3.0 - F), 0.0)
        g_3 = 2.0 * F * kappa - (25.0 / 9.0 - 2.0 * F)
        root = np.sqrt(g_2)
        near = np.abs(g_3) < 1e-6
        buhl = np.where(near, 1.0 - 0.5 / root, (g_1 - root) / np.where(near, 1.0, g_3))
        brake = np.where(kappa > 1.0, kappa / (kappa - 1.0), 0.0)
    forward = np.where(kappa <= MOMENTUM_FAILS, momentum, buhl)
    return np.asarray(np.where(phi > 0.0, forward, brake))

"""Stations of an aerodynamic blade, and the blade at other stations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.polar import Polar


def place_stations(start: float, end: float, count: int) -> tuple[Array, Array]:
    """Stations along a span, and the lengths whose loads they stand for [m].

    They are the points and weights of Gauss and Legendre, closer together at hub and tip, where
    losses make the loads fall steeply. With 16 stations power and thrust of the NREL 5 MW and the
    IEA 15 MW rotor lie within 0.13 % of their limit for many; with 16 equal parts within 1 %.

    Args:
        start: Where the blade begins [m].
        end: Where it ends [m].
        count: Number of stations.

    Returns:
        Radii and lengths, each of shape (count,); the sum of the lengths is that of the blade.
    """
    from scipy.special import roots_legendre

    point, weight = roots_legendre(count)
    half = 0.5 * (end - start)
    return start + half * (1.0 + point), np.asarray(half * weight)


def resample_blade(blade: AeroBlade, radius: npt.ArrayLike) -> AeroBlade:
    """The blade with chord, twist, bend and polars at other stations, linear between its own.

    Args:
        radius: Stations along the span, rising, shape (n,) [m].
    """
    r = check_array("stations of a blade", radius, (np.size(radius),), "a list of numbers")
    if not (blade.hub_radius <= r.min() and r.max() <= blade.tip_radius):
        raise ModelError(
            f"stations of a blade must lie between {blade.hub_radius:g} and "
            f"{blade.tip_radius:g} m, got {r.min():g} to {r.max():g} m"
        )
    own = blade.radius

    def at(values: npt.ArrayLike) -> Array:
        return np.interp(r, own, np.broadcast_to(values, own.shape))

    right = np.clip(np.searchsorted(own, r), 1, len(own) - 1)
    share = np.clip((r - own[right - 1]) / (own[right] - own[right - 1]), 0.0, 1.0)
    polars = tuple(
        _blend(blade.polars[k - 1], blade.polars[k], float(s))
        for k, s in zip(right, share, strict=True)
    )
    return replace(
        blade,
        radius=r,
        chord=at(blade.chord),
        twist=at(blade.twist),
        polars=polars,
        prebend=None if blade.prebend is None else at(blade.prebend),
        reference=at(blade.reference),
        aerodynamic_centre=at(blade.aerodynamic_centre),
        lengths=None,
    )


def _blend(first: Polar, second: Polar, share: float) -> Polar:
    """A polar between two, at the angles of both."""
    if first is second or share == 0.0:
        return first
    if share == 1.0:
        return second
    angle = np.union1d(first.angle, second.angle)
    a, b = first.coefficients(angle), second.coefficients(angle)
    lift, drag, moment = (1.0 - share) * a + share * b
    return Polar(f"{first.name} and {second.name}", angle, lift, drag, moment)

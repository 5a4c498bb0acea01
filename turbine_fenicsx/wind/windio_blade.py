"""The aerodynamic blade of a turbine that a windIO file describes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.argument_checks import check_array
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.aero_blade import STATION_TOLERANCE, STEEPEST, AeroBlade
from turbine_fenicsx.wind.polar import Polar
from turbine_fenicsx.windio import WindIOTurbine
from turbine_fenicsx.windio.airfoils import SAME_THICKNESS
from turbine_fenicsx.windio.outer_shape import OuterShape
from turbine_fenicsx.windio.polars import AirfoilPolar

_FINE = np.linspace(0.0, 1.0, 4001)
"""Span fractions between which heights above the root are straight."""


def make_aero_blade(turbine: WindIOTurbine, radius: npt.ArrayLike) -> AeroBlade:
    """Chord, twist, bend and polars at stations along the straight span.

    Stations follow the shape of the file's outer surface (monotone splines). Polars are linear in
    the relative thickness between those of the airfoils, and in the angle of attack; between
    airfoils of one thickness they are linear in the span.

    Args:
        turbine: What was read of the file.
        radius: Distances from the rotor centre along the span, rising, from the root to the tip;
            shape (n,) [m].

    Raises:
        ModelError: for stations off the blade, and for polars that are missing, wrong or do not
            close the circle.
    """
    shape, hub = turbine.blade.outer_shape, turbine.hub.radius
    height = shape.axis[2].smooth(_FINE)
    tip = hub + float(height[-1])
    r = check_array("stations of a blade", radius, (np.size(radius),), "a list of numbers")
    if len(r) < 2 or not (hub - STATION_TOLERANCE <= r[0] and r[-1] <= tip + STATION_TOLERANCE):
        ends = f"{r[0]:g} to {r[-1]:g} m" if len(r) else "none"
        raise ModelError(
            f"stations of the blade of {turbine.polars.file} must be two or more between "
            f"{hub:g} and {tip:g} m, got {ends}"
        )
    r = np.clip(r, hub + STATION_TOLERANCE, tip - STATION_TOLERANCE)
    s = np.interp(r - hub, height, _FINE)
    thicknesses = {airfoil.name: airfoil.thickness for airfoil in shape.sections.airfoils}
    airfoils = turbine.polars.read(thicknesses)
    thickness = shape.thickness.smooth(s)
    mix = _mix_airfoils(airfoils, thickness, s)
    try:
        polars = _blend_polars(airfoils, mix)
    except ModelError as error:
        raise ModelError(f"{turbine.polars.file}: {error}") from None
    prebend, reference = _cross_span(turbine, shape, s)
    return AeroBlade(
        hub,
        tip,
        r,
        shape.chord.smooth(s),
        np.radians(shape.twist.smooth(s)),
        polars,
        prebend=prebend,
        reference=reference,
        aerodynamic_centre=mix @ np.array([a.aerodynamic_centre for a in airfoils]),
    )


def _mix_airfoils(airfoils: tuple[AirfoilPolar, ...], thickness: Array, s: Array) -> Array:
    """Shares of airfoils at stations, linear in the thickness; of one thickness, in the span.

    Args:
        thickness: Relative thicknesses of the stations, shape (n,) [-].
        s: Their span fractions, shape (n,) [-].

    Returns:
        Shape (n, airfoils); the sum of each row is 1.
    """
    values = np.array([airfoil.thickness for airfoil in airfoils])
    first = np.flatnonzero(np.diff(values, prepend=-np.inf) >= SAME_THICKNESS)
    mix = np.zeros((len(s), len(airfoils)))
    for k, group in enumerate(np.split(np.arange(len(airfoils)), first[1:])):
        share = np.interp(thickness, values[first], np.eye(len(first))[k])
        if len(group) == 1:
            mix[:, group[0]] = share
            continue
        places = sorted((place, i) for i in group for place in airfoils[i].positions)
        at, which = np.array(places).T
        for i in group:
            mix[:, i] = share * np.interp(s, at, which == i)
    return mix


def _blend_polars(airfoils: tuple[AirfoilPolar, ...], mix: Array) -> tuple[Polar, ...]:
    """Polars of stations, means of those of the airfoils with the shares `mix`, (n, airfoils)."""
    angle = np.unique(np.concatenate([airfoil.angle for airfoil in airfoils]))
    tables = []
    for airfoil in airfoils:
        columns = (airfoil.lift, airfoil.drag, airfoil.moment)
        _make_polar(airfoil.name, airfoil.angle, *columns)  # checks each airfoil under its name
        tables.append([np.interp(angle, airfoil.angle, column) for column in columns])
    values = np.tensordot(mix, np.array(tables), 1)
    names = [" and ".join(a.name for a, x in zip(airfoils, row, strict=True) if x) for row in mix]
    return tuple(
        _make_polar(name, angle, *table) for name, table in zip(names, values, strict=True)
    )


def _make_polar(name: str, angle: Array, lift: Array, drag: Array, moment: Array) -> Polar:
    return Polar(name, np.radians(angle), lift, drag, moment)


def _cross_span(turbine: WindIOTurbine, shape: OuterShape, s: Array) -> tuple[Array, Array]:
    """Where chords cross the plane of the span and the rotor's axis.

    Returned are how far downwind of the straight span that is, and at which fraction of the chord.
    The chord runs through the reference axis (x, y), moved by the offset o_x to the suction side,
    in the direction (sin theta, cos theta) to the trailing edge.
    """
    theta = np.radians(shape.twist.smooth(s))
    if np.max(np.abs(theta)) > STEEPEST:
        raise ModelError(
            f"{turbine.polars.file}: twist must be below {np.degrees(STEEPEST):g} degrees for "
            f"aerodynamics, got {np.degrees(theta[np.argmax(np.abs(theta))]):g}"
        )
    x, y = shape.reference_points(s)[:, :2].T
    o_x, o_y, c = (curve.smooth(s) for curve in (shape.offset_x, shape.offset_y, shape.chord))
    way = (o_x * np.sin(theta) - y) / np.cos(theta)
    return x + o_x * np.cos(theta) + way * np.sin(theta), (o_y + way) / c

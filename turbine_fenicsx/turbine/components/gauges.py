"""Strain gauges of a case on its blades."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.gauges import Gauge, Gauges
from turbine_fenicsx.system.surface_rays import Skin
from turbine_fenicsx.turbine.blades.blade_plan import BladeSurface
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.tables.output import PLACES, GaugeCase

_STEP = 1e-3
"""Contour and span fractions between which tangents of the surface are taken."""

_SAMPLES = np.arange(64) / 64.0
"""Contour fractions whose mean point is inside a section."""


def make_gauges(turbine: Turbine, body: DeformableBody) -> Gauges | None:
    """The gauges of a case; None if it has none. Collective."""
    rotor, cases = turbine.rotor, turbine.case.output.gauges
    if not cases:
        return None
    shape, skin = rotor.blades.shape, None
    if shape is None:
        model = next(model for model in turbine.system.flexible_models if model.body is body)
        skin = Skin(model)
    found = []
    for name, case in cases.items():
        station, frame = case.find_station(rotor.blades.length), rotor.layout.frame(case.blade)
        if shape is not None:
            point, outward = find_place(shape, station, case.around)
            start = rotor.layout.place(point[None], case.blade)[0]
            outward = outward @ frame
        else:
            assert skin is not None
            height = rotor.blades.hub_radius + station * rotor.blades.length
            R, t = body.placements[case.blade - 1 if len(body.placements) > 1 else 0].frame()
            centre = (np.asarray(rotor.layout.centre) - t) @ R
            start, outward = _look_from_middle(name, case, skin, centre, height, frame @ R)
            start, outward = t + R @ start, R @ outward
        found.append(
            Gauge(name, body, point=start, outward=outward, along=frame[0], angle=case.angle)
        )
    return Gauges(turbine.system, found)


def find_place(shape: BladeSurface, station: float, around: float | str) -> tuple[Array, Array]:
    """A point below a place of the surface, and the direction from there outwards.

    Args:
        station: Span fraction [-].
        around: Contour fraction [-], or a name.

    Returns:
        Both along a1, a2, a3, shape (3,); the point in m from the rotor centre.
    """
    s = np.full(1, station)
    a = np.full(1, find_fraction(shape, s, around))
    low, high = np.clip([station - _STEP, station + _STEP], 0.0, 1.0)
    along = shape.surface(np.array([high]), a) - shape.surface(np.array([low]), a)
    across = shape.surface(s, np.mod(a + _STEP, 1.0)) - shape.surface(s, np.mod(a - _STEP, 1.0))
    normal = np.cross(along[0], across[0])
    normal /= np.linalg.norm(normal)
    point, middle = shape.surface(s, a)[0], shape.surface(s, _SAMPLES).mean(axis=0)
    return point - 0.5 * float(np.linalg.norm(point - middle)) * normal, normal


def find_fraction(shape: BladeSurface, s: Array, around: float | str) -> float:
    """The contour fraction of a place at a span fraction: sides and panels by their middles.

    Args:
        s: Span fraction, shape (1,) [-].
        around: Contour fraction [-], or a name.
    """
    if not isinstance(around, str):
        return around
    leading = float(shape.leading(s)[0])
    places = dict(zip(PLACES, (0.0, 0.5 * leading, leading, 0.5 * (1.0 + leading)), strict=True))
    if around in places:
        return places[around]
    panel = shape.panels.index(around)
    return float(shape.lines(s)[0, panel : panel + 2].mean())


def _look_from_middle(
    name: str, case: GaugeCase, skin: Skin, centre: Array, height: float, frame: Array
) -> tuple[Array, Array]:
    """Middle of a section that only the mesh knows, and a direction across the span from there.

    The fraction of the contour counts as that of a circle.
    """
    around = case.around
    fraction = PLACES.index(around) / len(PLACES) if isinstance(around, str) else around
    a1, a2, a3 = frame
    middle = skin.middle(a1, float(centre @ a1) + height, frame[1:])
    if middle is None:
        raise ModelError(f"gauge {name!r}: blade {case.blade} has no section at {height:g} m")
    along = centre + height * a1
    start = along + sum((m - along @ a) * a for m, a in zip(middle, (a2, a3), strict=True))
    turn = 2.0 * pi * fraction
    return np.asarray(start), sin(turn) * a3 - cos(turn) * a2

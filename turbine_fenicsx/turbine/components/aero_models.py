"""Aerodynamic models of a case beside blade elements and their wake."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from turbine_fenicsx.turbine.components.tower import tower_geometry
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.wind.skew import SkewedWake
from turbine_fenicsx.wind.stall import OeyeStall
from turbine_fenicsx.wind.tower_shadow import TowerShadow


class AeroModels(TypedDict):
    """Arguments of `RotorAerodynamics`; None for what a case leaves out."""

    stall: OeyeStall | None
    skew: SkewedWake | None
    tower: TowerShadow | None


def make_aero_models(case: Tables) -> AeroModels:
    """Dynamic stall, skewed wake and tower of a case."""
    aero = case.aero
    return {
        "stall": OeyeStall() if aero.dynamic_stall == "oeye" else None,
        "skew": SkewedWake() if aero.skewed_wake else None,
        "tower": None if aero.tower_shadow == "none" else _make_tower(case),
    }


def _make_tower(case: Tables) -> TowerShadow:
    """The undeformed tower, which ends at the yaw bearing in the origin."""
    shape, aero = tower_geometry(case.tower), case.aero
    drag = aero.tower_drag if aero.tower_shadow == "powles" else 0.0
    heights, radii = shape.height * np.array(shape.stations), 0.5 * np.array(shape.diameters)
    return TowerShadow((0.0, -shape.height, 0.0), (0.0, 0.0, 0.0), heights, radii, drag=drag)

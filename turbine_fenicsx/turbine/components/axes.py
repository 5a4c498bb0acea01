"""Axes of OpenFAST in the initial configuration, as rows x, y, z."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.turbine.case.inflow import AXES

TOWER_AXES = AXES
"""Of tower and nacelle: downwind, to the left, up."""


def shaft_axes(layout: RotorLayout) -> Array:
    """Of the shaft: along it downwind, to the left, up, shape (3, 3)."""
    side, up, shaft = layout.axes
    return np.array([shaft, side, up])


def hub_axes(layout: RotorLayout) -> Array:
    """Of the hub: along the shaft, z across it towards blade 1, shape (3, 3)."""
    shaft, span = layout.axes[2], layout.frame(1)[0]
    z = span - (span @ shaft) * shaft
    z /= np.linalg.norm(z)
    return np.array([shaft, np.cross(z, shaft), z])


def blade_axes(layout: RotorLayout, blade: int) -> Array:
    """Of a blade: downwind, to the trailing edge, along the span to the tip, shape (3, 3).

    Args:
        blade: Number of the blade, from 1.
    """
    a1, a2, a3 = layout.frame(blade)
    return np.array([a3, -a2, a1])

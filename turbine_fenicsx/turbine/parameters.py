"""Data of the paper's turbine (Table 1, section 2)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, pi

PRINTED_ARMS = (27.0 + 4.5 / (2.0 * cos(pi / 6.0)), 29.25, 27.0 + 4.5 / (2.0 * cos(pi / 6.0)))
"""Distances of the rigid blades' centres from the hub centre as printed, eqs (28)-(32) [m].

The arm of the upright blade differs from the other two, so that the printed rotor is slightly out
of balance.
"""


@dataclass(frozen=True)
class Inertia:
    """Mass and principal values of the Euler tensor of a rigid part.

    Args:
        mass: m [kg].
        euler: E1, E2, E3 [kg m^2].
    """

    mass: float
    euler: tuple[float, float, float]


@dataclass(frozen=True)
class TurbineParameters:
    """Rigid parts of the turbine.

    The tower top is the origin; e2 is vertical. The hub centre lies at -hub_distance e3.

    The Euler values are *equivalent* to the paper's Table 1: the motion of the rigid turbine
    depends on them only through the inertia about the shaft, that about the yaw axis, and E1 - E3
    of a blade. These three were identified from the reference run of the printed table, which they
    reproduce to eleven digits; how they are shared among nacelle, hub and blades is a choice.

    Args:
        hub_distance: Distance a of the hub centre from the tower axis [m].
        blade_arms: Distances of the rigid blades' centres from the hub centre [m].
        nacelle: Inertia in the axes e1, e2, e3.
        hub: Inertia in the axes e1, e2, e3.
        blade: Inertia of a rigid blade; axis 1 along the chord, 2 along the span, 3 along the
            rotor axis.
    """

    hub_distance: float = 5.0
    blade_arms: tuple[float, float, float] = PRINTED_ARMS
    nacelle: Inertia = field(default_factory=lambda: Inertia(1.0e5, (942120.0, 1.0e6, 1.0e6)))
    hub: Inertia = field(default_factory=lambda: Inertia(3.0e4, (1.0e5, 1.0e5, 1.0e5)))
    blade: Inertia = field(
        default_factory=lambda: Inertia(1.65e4, (193428.0, 1441532.01178, 1.0e4))
    )

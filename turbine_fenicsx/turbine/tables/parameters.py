"""Data of the paper's turbine (Table 1, section 2)."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

PRINTED_ARMS = (27.0 + 4.5 / (2.0 * cos(pi / 6.0)), 29.25, 27.0 + 4.5 / (2.0 * cos(pi / 6.0)))
"""Distances of the rigid blades' centres from the hub centre as printed, eqs (28)-(32) [m].

The arm of the upright blade differs from the other two, so that the printed rotor is slightly out
of balance.
"""


Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Inertia:
    """Mass, centre of mass and inertia of a rigid part.

    Args:
        mass: m [kg].
        euler: E1, E2, E3, the principal values of the Euler tensor [kg m^2].
        centre: Centre of mass from the origin of the part [m].
        tensor: Tensor of inertia about the centre of mass, rows [kg m^2]; in place of ``euler``.
    """

    mass: float
    euler: Vector
    centre: Vector = (0.0, 0.0, 0.0)
    tensor: tuple[Vector, Vector, Vector] | None = None


@dataclass(frozen=True)
class TurbineParameters:
    """Rigid parts of the turbine.

    The tower top is the origin; e2 is vertical.

    Masses and Euler values are those of the paper's Table 1, rows 1, 2 and 3-5. Its columns E1, E2,
    E3 belong to the body axes d1, d2, d3 of the initial configuration, eqs (30)-(32). With them the
    rigid turbine meets every reference number of ``docs/paper.md``.

    Args:
        blade_arms: Distances of the rigid blades' centres from the hub centre [m].
        nacelle: Inertia in the axes e1, e2, e3 (d1, d2, d3), from the tower top.
        hub: Inertia in the axes d1, d2, d3 of the rotor, the last of which is the shaft, from the
            rotor centre.
        blade: Inertia of a rigid blade; d1 along the chord, d2 along the span, d3 normal to both.
    """

    blade_arms: tuple[float, float, float] = PRINTED_ARMS
    nacelle: Inertia = Inertia(2.0e5, (6.0e5, 6.0e5, 6.0e5))
    hub: Inertia = Inertia(6.1e4, (102940.0, 102940.0, 81330.0))
    blade: Inertia = Inertia(1.65e4, (183500.0, 1449500.0, 18900.0))

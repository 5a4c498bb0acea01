"""The rigid turbine: nacelle, hub and three rigid blades (section 2 of the paper)."""

from __future__ import annotations

from typing import Any

import numpy as np

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.joints import Revolute
from turbine_fenicsx.turbine.case.parameters import TurbineParameters

AZIMUTHS = (-2.0 * np.pi / 3.0, 0.0, 2.0 * np.pi / 3.0)
"""Azimuths of blades 1, 2, 3 (bodies 3, 4, 5) about e3 from e2 [rad]."""

PITCH_SIGNS = (1.0, -1.0, 1.0)
"""The paper counts the pitch of the upright blade negative about its outward axis."""


def nacelle_and_hub(
    p: TurbineParameters, support: RigidBody | None = None
) -> tuple[RigidBody, RigidBody, list[Revolute]]:
    """Nacelle, hub, and the yaw and rotor bearings, eqs (27), (28).

    Args:
        p: Parameters.
        support: What carries the yaw bearing; None for the ground.

    Returns:
        Nacelle, hub, and the joints ``yaw`` and ``rotor``.
    """
    nacelle = RigidBody("nacelle", p.nacelle.mass, p.nacelle.euler)
    hub = RigidBody("hub", p.hub.mass, p.hub.euler, position=-p.hub_distance * E3)
    yaw = Revolute("yaw", support, nacelle, point=(0.0, 0.0, 0.0), axis=-E2, reference=E3)
    rotor = Revolute("rotor", nacelle, hub, point=hub.position, axis=E3, reference=E2)
    return nacelle, hub, [yaw, rotor]


def rigid_turbine(p: TurbineParameters, support: RigidBody | None = None) -> list[Any]:
    """Parts of the rigid turbine: five bodies, five revolute joints with angles, eqs (27)-(32).

    Args:
        p: Parameters.
        support: What carries the yaw bearing; None for the ground.

    Returns:
        Bodies and joints, in the paper's order; loads are the caller's.
    """
    nacelle, hub, bearings = nacelle_and_hub(p, support)
    blades, pitch_bearings = [], []
    for k, (azimuth, arm, sign) in enumerate(
        zip(AZIMUTHS, p.blade_arms, PITCH_SIGNS, strict=True), start=1
    ):
        R = rotation_about(E3, azimuth)
        span = R @ E2
        blades.append(
            RigidBody(
                f"blade_{k}",
                p.blade.mass,
                p.blade.euler,
                position=np.asarray(hub.position) + arm * span,
                directors=R,
            )
        )
        pitch_bearings.append(
            Revolute(
                f"pitch_{k}", hub, blades[-1], point=hub.position, axis=sign * span, reference=E3
            )
        )
    return [nacelle, hub, *blades, *bearings, *pitch_bearings]

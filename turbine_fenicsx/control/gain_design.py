"""Gains of the pitch, and the best gain of the torque, from the aerodynamics of a rotor.

Jonkman et al., NREL/TP-500-38060 (2009), section 7. With the inertia I of the rotor about the shaft
a small change of its speed follows an oscillator of frequency omega and damping ratio zeta if

    K_P = 2 I Omega zeta omega / (N (-dP/dtheta)),    K_I = I Omega omega^2 / (N (-dP/dtheta)),

where the power P changes with the pitch theta while the induced velocities stay as they are (frozen
wake). At rated speed -dP/dtheta grows about linearly with the pitch that each wind needs; a line
through it gives its value at the fine pitch, and the angle theta_K where that has doubled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_performance, find_pitch

FREQUENCY, DAMPING = 0.2, 1.0
"""Of the rotor's speed above rated [rad/s], [-]: slow enough for rotors of 15 MW and more, whose
first frequencies of tower and floater are near the 0.6 rad/s of the NREL 5 MW turbine."""

STEEPEST = np.radians(40.0)
"""No wind of a run needs more pitch beyond the fine one [rad]."""

LEAST_ANGLE = np.radians(2.0)
"""Smallest theta_K; where the line ends below, the gains fit the points with this one [rad]."""

CUT_OUT, POINTS = 25.0, 6
"""Highest wind of the line [m/s], and its points."""

STEP = 1e-4
"""Of the pitch in differences, and its accuracy [rad]."""


class PitchGains(NamedTuple):
    """K_P [s] and K_I [-] at the fine pitch, and theta_K [rad]."""

    proportional: float
    integral: float
    angle: float


@dataclass(frozen=True)
class RatedPoint:
    """Where a rotor runs above rated wind.

    Args:
        speed: Of the rotor [rad/s].
        power: Out of the wind [W].
        fine: Pitch below rated wind [rad].
    """

    speed: float
    power: float
    fine: float


def find_torque_gain(rotor: Rotor, rated: RatedPoint, tip_speed_ratio: float) -> float:
    """Torque over the squared speed of the rotor that keeps a tip-speed ratio [N m s^2/rad^2]."""
    wind = rated.speed * rotor.tip_distance / tip_speed_ratio
    found = find_performance(rotor, Operation(wind, rated.speed, rated.fine), sectors=1)
    return found.torque / rated.speed**2


def find_pitch_gains(
    rotor: Rotor,
    rated: RatedPoint,
    inertia: float,
    ratio: float = 1.0,
    frequency: float = FREQUENCY,
    damping: float = DAMPING,
) -> PitchGains:
    """Gains of the pitch for the speed of the generator.

    Args:
        inertia: Of all that turns, about the shaft [kg m^2].
        ratio: Speed of the generator over that of the rotor.
        frequency: Natural frequency of the speed [rad/s].
    """
    theta, slope = find_sensitivity(rotor, rated)
    if not np.all(slope < 0.0):
        raise ModelError("power above rated wind does not fall with the pitch")
    x = theta - rated.fine
    rise, at_fine = np.polyfit(x, -slope, 1)
    angle = at_fine / rise if rise > 0.0 else float(STEEPEST)
    angle = float(np.clip(angle, LEAST_ANGLE, STEEPEST))
    shape = 1.0 + x / angle
    factor = inertia * rated.speed / (ratio * float(shape @ -slope / (shape @ shape)))
    return PitchGains(2.0 * damping * frequency * factor, frequency**2 * factor, angle)


def find_sensitivity(rotor: Rotor, rated: RatedPoint) -> tuple[Array, Array]:
    """Pitch angles at winds above rated, and change of power with the pitch there.

    Returns:
        The angles, shape (n,) [rad], and dP/dtheta with a frozen wake, shape (n,) [W/rad].
    """
    from scipy.optimize import brentq

    def lacking(wind: float) -> float:
        operation = Operation(wind, rated.speed, rated.fine)
        return find_performance(rotor, operation, sectors=1).power - rated.power

    calm = 0.25 * CUT_OUT
    if not lacking(calm) < 0.0 < lacking(0.8 * CUT_OUT):
        raise ModelError(
            f"the rotor does not reach {1e-6 * rated.power:.4g} MW at {rated.speed:.4g} rad/s and "
            f"a pitch of {np.degrees(rated.fine):.3g} degrees between {calm:g} and "
            f"{0.8 * CUT_OUT:g} m/s"
        )
    first = float(brentq(lacking, calm, 0.8 * CUT_OUT, xtol=1e-3))
    angles, slopes = [], []
    for wind in np.linspace(1.02 * first, CUT_OUT, POINTS):
        operation = Operation(float(wind), rated.speed)
        ends = (rated.fine, rated.fine + STEEPEST)
        pitch = find_pitch(rotor, operation, rated.power, ends, accuracy=STEP)
        at = replace(operation, pitch=pitch)
        powers = [
            find_performance(rotor, replace(at, pitch=pitch + step), 1, wake=at).power
            for step in (STEP, -STEP)
        ]
        angles.append(pitch)
        slopes.append((powers[0] - powers[1]) / (2.0 * STEP))
    return np.array(angles), np.array(slopes)

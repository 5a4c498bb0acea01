"""Warnings of values that are allowed but probably not meant."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, pi

from turbine_fenicsx.turbine.case.file_doubts import doubt_files
from turbine_fenicsx.turbine.tables.tables import Tables

_BUILT_MASS, _BUILT_LENGTH, _BUILT_POWER = 17.7e3, 61.5, 2.3
"""Mass [kg] and length [m] of a blade of the NREL 5 MW turbine; how masses grow with length."""

_FAR_OFF = 15.0
"""Times lighter or heavier than a built blade; the paper's solid blades are 10 times heavier."""

LARGEST_TURN = 0.3
"""Angle of the rotor in a step, of which the midpoint rule misses nearly one per cent [rad]."""


CUT_OUT_SPEED = 25.0
"""Wind speed above which most turbines stop [m/s]."""

LEAST_FEATHER = pi / 4.0
"""Pitch from which on blades count as feathered [rad]."""

STOPS = ("shut_down", "emergency_stop")
"""Kinds of events that turn the blades out of the wind."""


def find_warnings(case: Tables) -> list[str]:
    """One sentence for everything that looks like a slip.

    Args:
        case: A valid case.
    """
    return [
        *_doubt_ground(case),
        *_doubt_lean(case),
        *_doubt_mass(case),
        *_doubt_steps(case),
        *_doubt_start(case),
        *_doubt_events(case),
        *_doubt_storm(case),
        *doubt_files(case),
    ]


def find_mass_warning(mass: float, length: float) -> list[str]:
    """A sentence if a blade is far lighter or heavier than built ones.

    Args:
        mass: Of one blade [kg].
        length: Its length [m].
    """
    built = _BUILT_MASS * (length / _BUILT_LENGTH) ** _BUILT_POWER
    if built / _FAR_OFF <= mass <= built * _FAR_OFF:
        return []
    return [
        f"a blade of {length:.4g} m has {mass / 1e3:.3g} t, built ones have about "
        f"{built / 1e3:.2g} t; they are hollow, so a solid one needs a density to match"
    ]


def _doubt_ground(case: Tables) -> Iterator[str]:
    """The blades stay above the ground."""
    t = case.turbine
    radius = case.blade.hub_radius + case.blade.length
    depth = radius * cos(t.precone + t.tilt) - case.tower.height - t.hub_rise
    if case.tower.flexible and depth > 0.0:
        yield (
            f"the blades reach {depth:.4g} m into the ground: they end at a "
            f"radius of {radius:.4g} m and tower.height is {case.tower.height:.4g} m"
        )


def _doubt_lean(case: Tables) -> Iterator[str]:
    """The rotor stands in front of the tower, so shaft and blades lean away from it."""
    for key, angle in (("tilt", case.turbine.tilt), ("precone", case.turbine.precone)):
        if angle > 0.0:
            yield (
                f"turbine.{key} = {angle * 180.0 / pi:.4g} degrees leans the blades towards the "
                "tower; the angle counts as in OpenFAST, negative for a rotor in front of it"
            )


def _doubt_mass(case: Tables) -> Iterator[str]:
    """The blades weigh about what blades do; those of a file are looked at with their mesh."""
    if case.turbine.file is not None:
        return
    if case.turbine.model == "rigid":
        yield from find_mass_warning(case.turbine.blade.mass, case.blade.length)
    elif case.mesh.file is None:
        blade = case.blade.geometry()
        yield from find_mass_warning(blade.volume * case.material.density, blade.length)


def _doubt_steps(case: Tables) -> Iterator[str]:
    """Several steps must resolve a load, and each looks at it in its middle."""
    loads, pitch = case.loads, case.pitch
    acting = []
    if any((loads.rotor_torque, loads.yaw_torque, loads.pitch_torque)):
        acting.append(("loads.duration", loads.duration))
    if pitch.drive == "prescribed" and pitch.angle and pitch.file is None:
        acting.append(("pitch.duration", pitch.duration))
    for key, duration in acting:
        if 2.0 * case.time.step > duration:
            yield (
                f"time.step = {case.time.step:g} s is too long to follow {key} = {duration:g} s; "
                "loads are taken in the middle of each step"
            )


def _doubt_start(case: Tables) -> Iterator[str]:
    """The run starts as it should."""
    start, speed, step = case.time.start, case.turbine.rotor_speed, case.time.step
    if start == "turning" and speed == 0.0:
        yield 'time.start = "turning" is the same as "equilibrium" with turbine.rotor_speed = 0'
    if start == "undeformed" and speed and case.turbine.model == "hybrid":
        yield (
            f"turbine.rotor_speed = {speed:g} rad/s: the blades are not yet stretched by the "
            'rotation and begin to vibrate; time.start = "turning" starts without'
        )
    hollow = case.blade.wall is not None or case.turbine.file is not None
    if start == "undeformed" and case.loads.gravity and case.turbine.model == "hybrid" and hollow:
        yield (
            f'time.start = "undeformed": loads.gravity = {case.loads.gravity:g} m/s^2 acts on thin '
            "walls suddenly; they then move by their thickness in a step and take many "
            'iterations; time.start = "equilibrium" or "turning" starts without'
        )
    if start != "undeformed" and case.has_pitch_bearings and case.pitch.drive == "free":
        yield (
            f'time.start = "{start}": the pitch bearings are held while the start is found and let '
            'go then; pitch.drive = "prescribed" with pitch.angle = 0 keeps them locked'
        )
    if abs(speed) * step > LARGEST_TURN:
        yield (
            f"time.step = {step:g} s is long: the rotor turns by "
            f"{abs(speed) * step * 180.0 / pi:.3g} degrees in a step"
        )


def _doubt_storm(case: Tables) -> Iterator[str]:
    """No turbine works above its cut-out speed, and its blades are feathered there."""
    speed = case.wind.speed
    if speed is None or speed <= CUT_OUT_SPEED or case.wind.file is not None:
        return
    stops = any(event.kind in STOPS for event in case.event.values())
    words = f"wind.speed = {speed:g} m/s is above {CUT_OUT_SPEED:g} m/s, where turbines stop"
    if case.control.kind != "none":
        if not stops:
            yield f"{words}: the controller works on"
        return
    moves = case.pitch.drive == "prescribed" and (case.pitch.angle or case.pitch.file)
    pitch = case.pitch.initial if case.has_pitch_bearings else 0.0
    if abs(pitch) < LEAST_FEATHER and not moves:
        yield (
            f"{words} with their blades at some 90 deg of pitch; here they have "
            f"{pitch * 180.0 / pi:.3g} deg"
        )


def _doubt_events(case: Tables) -> Iterator[str]:
    """Events happen."""
    for name, event in case.event.items():
        if event.time > case.time.end:
            yield (
                f"event.{name}.time = {event.time:g} s is after time.end = {case.time.end:g} s, so "
                "it does not happen"
            )

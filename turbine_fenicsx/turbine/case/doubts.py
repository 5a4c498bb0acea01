"""Warnings of values that are allowed but probably not meant."""

from __future__ import annotations

from collections.abc import Iterator

from turbine_fenicsx.turbine.case.tables import Tables

_BUILT_MASS, _BUILT_LENGTH, _BUILT_POWER = 17.7e3, 61.5, 2.3
"""Mass [kg] and length [m] of a blade of the NREL 5 MW turbine; how masses grow with length."""

_FAR_OFF = 15.0
"""Times lighter or heavier than a built blade; the paper's solid blades are 10 times heavier."""


def doubts(case: Tables) -> list[str]:
    """One sentence for everything that looks like a slip.

    Args:
        case: A valid case.
    """
    return [*_ground(case), *_mass(case), *_steps(case)]


def mass_doubt(mass: float, length: float) -> list[str]:
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


def _ground(case: Tables) -> Iterator[str]:
    """The blades stay above the ground."""
    radius = case.blade.hub_radius + case.blade.length
    if case.tower.flexible and radius > case.tower.height:
        yield (
            f"the blades reach {radius - case.tower.height:.4g} m into the ground: they end at a "
            f"radius of {radius:.4g} m and tower.height is {case.tower.height:.4g} m"
        )


def _mass(case: Tables) -> Iterator[str]:
    """The blades weigh about what blades do; those of a file are looked at with their mesh."""
    if case.turbine.model == "rigid":
        yield from mass_doubt(case.turbine.blade.mass, case.blade.length)
    elif case.mesh.file is None:
        from turbine_fenicsx.meshing import BladeGeometry

        blade = BladeGeometry(**case.blade.model_dump())
        yield from mass_doubt(blade.volume * case.material.density, blade.length)


def _steps(case: Tables) -> Iterator[str]:
    """What acts for a while is seen by several steps, which look at it in their middle."""
    loads, pitch = case.loads, case.pitch
    acting = []
    if any((loads.rotor_torque, loads.yaw_torque, loads.pitch_torque)):
        acting.append(("loads.duration", loads.duration))
    if pitch.drive == "prescribed" and pitch.angle:
        acting.append(("pitch.duration", pitch.duration))
    for key, duration in acting:
        if 2.0 * case.time.step > duration:
            yield (
                f"time.step = {case.time.step:g} s is too long to follow {key} = {duration:g} s; "
                "loads are taken in the middle of each step"
            )

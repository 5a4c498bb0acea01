"""Derivatives of loads on sections by increments of a step: what the loads know, or differences."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion, SlopedLoad
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.types import Array

STEP = 1e-3
"""Increments in differences of loads: of rotations [rad]; of translations, relative to the way in a
step at the largest velocity, or at 1 m/s."""


def find_slopes(source: LineLoad, motion: SectionMotion, times: StepTimes) -> Array:
    """Derivatives of the loads of a source, shape (n, 6, 6); see `SlopedLoad.find_slopes`."""
    if isinstance(source, SlopedLoad):
        return source.find_slopes(motion, times)
    F, M = source.loads(motion, times.middle)
    way = STEP * times.dt * max(float(np.max(np.abs(motion.velocity))), 1.0)
    slopes = np.empty((len(F), 6, 6))
    for k in range(6):
        size, e = (way, np.eye(3)[k]) if k < 3 else (STEP, np.eye(3)[k - 3])
        moved = _move(motion, k < 3, size * e, times.dt)
        F_k, M_k = source.loads(moved, times.middle)
        slopes[:, :3, k], slopes[:, 3:, k] = (F_k - F) / size, (M_k - M) / size
    return slopes


def _move(motion: SectionMotion, straight: bool, increment: Array, dt: float) -> SectionMotion:
    """The motion with another increment of the step, of all sections, shape (3,) [m or rad]."""
    if straight:
        return motion._replace(
            position=motion.position + 0.5 * increment, velocity=motion.velocity + increment / dt
        )
    turn = rotation_about(increment, 0.5 * float(np.linalg.norm(increment)))
    spin = motion.angular_velocity + increment / dt
    return motion._replace(axes=turn @ motion.axes, angular_velocity=spin)

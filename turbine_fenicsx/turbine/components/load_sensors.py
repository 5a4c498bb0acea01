"""Strain gauges at the roots of the blades and an accelerometer at the top of the tower."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.control.interface import Angles
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import E2
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.joint_reactions import JointReaction, JointReactions
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.observers.step_loads import StepLoads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.flexible_blades import blade_axes
from turbine_fenicsx.turbine.components.nacelle import SUPPORT
from turbine_fenicsx.turbine.components.pitch import BEARINGS


class RootMoments:
    """Moments that the blades exert on the hub at their roots, means of two steps."""

    def __init__(self, turbine: Turbine) -> None:
        layout, case = turbine.rotor.layout, turbine.case
        numbers = range(1, layout.n_blades + 1)
        points = [layout.point_on_span(k, case.blade.hub_radius) for k in numbers]
        axes = [blade_axes(layout, k) for k in numbers]
        self._sign, self._pitches = 1.0, case.has_pitch_bearings
        self._loads: StepLoads
        if case.turbine.model == "rigid":  # what the hub exerts on them, in the opposite sense
            joints = [turbine.part(name) for name in BEARINGS]
            given = zip(joints, points, axes, strict=True)
            self._loads = JointReactions(turbine.system, [JointReaction(*x) for x in given])
            self._sign = -1.0
        else:
            roots = [turbine.part(name) for name in ROOTS]
            self._loads = Reactions(
                turbine.system, [Reaction(*x) for x in zip(roots, points, axes, strict=True)]
            )

    def at(self, snapshot: Snapshot, pitch: Angles) -> tuple[Angles, Angles]:
        """Moments out of the plane of the rotor and in it [N m]. Collective.

        The axes of the gauges pitch with the blade, about its span from tip to root:

            M_y = cos(theta) M_y,b - sin(theta) M_x,b,    M_x = cos(theta) M_x,b + sin(theta) M_y,b.
        """
        x, y = (self._sign * self._loads.mean_at(snapshot)[:, 1, :2]).T
        c, s = np.cos(pitch), np.sin(pitch)
        flap, edge = (c * y - s * x, c * x + s * y) if self._pitches else (y, x)
        return tuple(flap.tolist()), tuple(edge.tolist())  # type: ignore[return-value]

    def save(self) -> RestartData:
        """Loads of the last step."""
        return self._loads.save()

    def restore(self, data: RestartData) -> None:
        """Resume after the saved step."""
        self._loads.restore(data)


class TopAcceleration:
    """Acceleration of the top of a flexible tower, from its places at the ends of steps.

    Mean velocities of two steps belong to their middles; velocities at the ends of steps carry an
    alternating part that no sensor would have.
    """

    def __init__(self, turbine: Turbine) -> None:
        support = turbine.find(SUPPORT)
        self._first = None if support is None else turbine.system.first_coordinate[support]
        self._place: Array | None = None
        self._before: tuple[Array, float] | None = None  # mean velocity of a step, its length

    def at(self, q: Array, dt: float, forward: Array) -> tuple[float, float]:
        """Acceleration downwind and to the left, as the nacelle looks [m/s^2].

        Args:
            dt: Time since the last call [s].
            forward: Direction of the shaft of the nacelle, downwind, shape (3,).
        """
        if self._first is None:
            return 0.0, 0.0
        place, found = q[self._first : self._first + 3].copy(), np.zeros(3)
        if self._place is not None:
            velocity = (place - self._place) / dt
            if self._before is not None:
                before, length = self._before
                found = (velocity - before) / (0.5 * (dt + length))
            self._before = velocity, dt
        self._place = place
        ahead = forward - (forward @ E2) * E2
        ahead /= np.linalg.norm(ahead)
        return float(found @ ahead), float(found @ np.cross(E2, ahead))

    def resume(self, q: Array) -> None:
        """A run resumes from these coordinates."""
        if self._first is not None:
            self._place = q[self._first : self._first + 3].copy()

    def save(self) -> RestartData:
        """Mean velocity and length of the last step, if there was one."""
        if self._before is None:
            return RestartData()
        return RestartData({"length": self._before[1]}, {"velocity": self._before[0].copy()})

    def restore(self, data: RestartData) -> None:
        """Resume after the saved step."""
        self._before = (data.arrays["velocity"].copy(), data.numbers["length"]) if data else None

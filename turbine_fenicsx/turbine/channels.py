"""Time series of a turbine: which columns ``history.csv`` and ``history.out`` have.

The frame of a blade is that of OpenFAST, with the origin at the centre of the root: x points
downwind along the shaft, z along the span to the tip, and y = z x x to the trailing edge of a rotor
that turns clockwise, seen from upwind. It is fixed to what carries the root: to the hub, or with
pitch bearings to the ring, so that it pitches with the blade. Root loads are those that the blade
exerts on its carrier.

The frame of the tower is that of OpenFAST too, and does not move: x points downwind, z up, and
y = z x x to the left, looking downwind. Base loads are those that the tower exerts on the ground,
about the centre of its foot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.postprocessing.conventions import OPENFAST_SIGNS
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.observers.shared_sum import SharedSum
from turbine_fenicsx.simulation.observers.tips import Tips, tip_channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.model import Turbine, rotor_layout
from turbine_fenicsx.turbine.pitch import BEARINGS

CONVENTIONS = (
    "Azimuth is 0 when blade 2 points up, 120 deg when blade 1 does (AzimB1Up = 120 deg); RotSpeed "
    "and Root loads are means of the step that ends at the time of the row"
)
"""Line in the head of ``history.out``."""


TOWER_AXES = np.array([E3, E1, E2])
"""Axes x, y, z of the frame of the tower as rows."""


class BladeSensors:
    """Root loads and tip deflections of the flexible blades; none on the rigid turbine.

    Args:
        case: The case.
        turbine: Its turbine.

    Attributes:
        names: Number of each blade that is measured, from "1".

    Note:
        Collective.
    """

    def __init__(self, case: Case, turbine: Turbine) -> None:
        """Place the sensors."""
        system, layout = turbine.system, rotor_layout(case)
        roots, tips = [], []
        for k, (coupling, tip) in enumerate(zip(turbine.roots, turbine.tips, strict=True), start=1):
            axes = blade_axes(layout.frame(k)[0], np.asarray(layout.axis))
            root = np.asarray(layout.centre) + case.blade.hub_radius * axes[2]
            roots.append(Reaction(coupling, root, axes))
            tips.append(replace(tip, axes=axes))
        self.names = tuple(tip.name for tip in tips)
        sums = SharedSum(system.comm)
        self._roots, self._tips = Reactions(system, roots, sums), Tips(system, tips, sums)

    def history_channels(self) -> list[Channel]:
        """Tip deflections, their flapwise and edgewise parts, root forces and moments."""
        columns = tuple(
            family(blade=k, axis=axis)
            for k in self.names
            for family in (names.ROOT_FORCE, names.ROOT_MOMENT)
            for axis in "xyz"
        )
        parts = tuple(
            family(tip=k) for k in self.names for family in (names.TIP_FLAP, names.TIP_EDGE)
        )
        return [
            tip_channel(self._tips),
            Channel(parts, lambda s: self._tips.at(s)[:, :2].ravel().tolist()),
            Channel(columns, lambda s: self._roots.at(s).ravel().tolist()),
        ]

    def openfast_channels(self) -> list[Channel]:
        """TipD?b (blade coordinates), RootF?b and RootM?b of each blade."""
        tips = tuple(f"TipD{axis}b{k}_[m]" for k in self.names for axis in "xyz")
        roots = tuple(
            f"Root{kind}{axis}b{k}_[{unit}]"
            for k in self.names
            for kind, unit in (("F", "kN"), ("M", "kN-m"))
            for axis in "xyz"
        )
        return [
            Channel(tips, lambda s: self._tips.at(s).ravel().tolist()),
            Channel(roots, lambda s: (1e-3 * self._roots.at(s)).ravel().tolist()),
        ]


class TowerSensors:
    """Motion of the top and loads at the base of the flexible tower; none without one.

    Args:
        case: The case.
        turbine: Its turbine.

    Note:
        Collective.
    """

    def __init__(self, case: Case, turbine: Turbine) -> None:
        """Place the sensors."""
        self._base: Reactions | None = None
        if turbine.tower is not None:
            system, tower = turbine.system, turbine.tower
            first = system.first_coordinate[tower.top]
            self._top = slice(first, first + 3)
            self._start = np.asarray(tower.top.position, dtype=float)
            foot = Reaction(tower.foot, (0.0, -case.tower.height, 0.0), TOWER_AXES)
            self._base = Reactions(system, [foot])

    def history_channels(self) -> list[Channel]:
        """Displacement of the yaw bearing, force and moment at the base, in the tower's frame."""
        columns = [names.TOWER_TOP_DISPLACEMENT(axis=axis) for axis in "xyz"]
        loads = [
            family(axis=axis)
            for family in (names.TOWER_BASE_FORCE, names.TOWER_BASE_MOMENT)
            for axis in "xyz"
        ]
        return self._channels(columns, loads, 1.0)

    def openfast_channels(self) -> list[Channel]:
        """TTDsp (fore-aft, side-to-side, axial), TwrBsF?t and TwrBsM?t."""
        columns = [f"TTDsp{name}_[m]" for name in ("FA", "SS", "Ax")]
        loads = [
            f"TwrBs{kind}{axis}t_[{unit}]"
            for kind, unit in (("F", "kN"), ("M", "kN-m"))
            for axis in "xyz"
        ]
        return self._channels(columns, loads, 1e-3)

    def _channels(self, columns: list[str], loads: list[str], factor: float) -> list[Channel]:
        """The two channels under these names, the loads times a factor."""
        if self._base is None:
            return []
        base = self._base
        return [
            Channel(
                tuple(columns),
                lambda s: (TOWER_AXES @ (s.state.q[self._top] - self._start)).tolist(),
            ),
            Channel(tuple(loads), lambda s: (factor * base.at(s)).ravel().tolist()),
        ]


def blade_axes(span: Array, axis: Array) -> Array:
    """Axes x, y, z of the frame of a blade as rows, shape (3, 3).

    Args:
        span: Direction of the span, shape (3,).
        axis: Direction of the shaft, downwind, shape (3,).
    """
    x = axis / np.linalg.norm(axis)
    return np.array([x, np.cross(span, x), span])


def openfast_channels(turbine: Turbine, *sensors: BladeSensors | TowerSensors) -> list[Channel]:
    """Columns of ``history.out`` after the time from left to right.

    Azimuth [0, 360) and rotor speed count positive about the shaft, downwind; the nacelle's yaw
    about the upward vertical, opposite to the paper's; pitch, as in OpenFAST, about the span from
    tip to root (0 without pitch bearings). The columns of the sensors follow.
    """
    joints = turbine.system.angle_names
    rotor, yaw = joints.index("rotor"), joints.index("yaw")
    bearings = [joints.index(name) for name in BEARINGS if name in joints]
    signs = np.array([OPENFAST_SIGNS[name] for name in joints])

    def values(s: Snapshot) -> Sequence[float]:
        degrees = signs * np.degrees(s.state.angles)
        pitches = [float(degrees[k]) for k in bearings] or [0.0] * len(BEARINGS)
        rpm = float(s.state.angle_rates[rotor]) * 30.0 / np.pi
        return [float(degrees[rotor]) % 360.0, rpm, float(degrees[yaw]), *pitches]

    columns = ("Azimuth_[deg]", "RotSpeed_[rpm]", "NacYaw_[deg]")
    pitches = tuple(f"BldPitch{k}_[deg]" for k in range(1, len(BEARINGS) + 1))
    found = [Channel((*columns, *pitches), values)]
    return [*found, *(channel for sensor in sensors for channel in sensor.openfast_channels())]

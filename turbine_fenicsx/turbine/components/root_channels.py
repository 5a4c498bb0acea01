"""Columns with the loads at the roots of blades, of rigid and flexible ones alike."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.joint_reactions import JointReaction, JointReactions
from turbine_fenicsx.simulation.observers.reactions import Reaction, Reactions
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.components.axes import blade_axes
from turbine_fenicsx.turbine.components.component import Channels, Turbine
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.components.pitch import BEARINGS, find_angles

_NUMBERS = range(1, len(BLADES) + 1)


class RootLoads:
    """Forces and moments of rigid or flexible blades on what carries them, about their roots.

    Axes are those of the blades, which pitch with them.

    Attributes:
        loads: What couplings or bearings have, with the memory of means.
    """

    def __init__(self, turbine: Turbine) -> None:
        layout, radius = turbine.rotor.layout, turbine.rotor.blades.hub_radius
        points = [layout.point_on_span(k, radius) for k in _NUMBERS]
        axes = [blade_axes(layout, k) for k in _NUMBERS]
        self.loads: Reactions | JointReactions
        if turbine.case.turbine.model == "rigid":  # a bearing has what the hub exerts on the blade
            bearings = [turbine.part(name) for name in BEARINGS]
            joints = zip(bearings, points, axes, strict=True)
            self.loads = JointReactions(turbine.system, [JointReaction(*x) for x in joints])
            self._sign = -1.0
        else:
            roots = [turbine.part(name) for name in ROOTS]
            couplings = zip(roots, points, axes, strict=True)
            self.loads = Reactions(turbine.system, [Reaction(*x) for x in couplings])
            self._sign = 1.0

    def mean_at(self, snapshot: Snapshot) -> Array:
        """Means of the last two steps, shape (blades, 2, 3). Collective."""
        return self._sign * self.loads.mean_at(snapshot)

    def at_rest(self, state: State) -> Array:
        """Loads in an equilibrium, shape (blades, 2, 3). Collective."""
        return self._sign * self.loads.at_rest(state)


def root_channels(turbine: Turbine) -> Channels:
    """Forces and moments of the blades on what carries them. Collective."""
    angles, roots = find_angles(turbine), RootLoads(turbine)
    loads, memory = roots.mean_at, roots.loads
    history = [
        family(blade=k, axis=axis)
        for k in _NUMBERS
        for family in (names.ROOT_FORCE, names.ROOT_MOMENT)
        for axis in "xyz"
    ]
    pitching, fixed = (
        [f"Root{kind}{axis}{frame}{k}" for k in _NUMBERS for kind in "FM" for axis in "xyz"]
        for frame in "bc"
    )
    return Channels(
        history=[Channel(tuple(history), lambda s: loads(s).ravel().tolist(), memory)],
        openfast=[
            in_openfast(pitching, loads, memory),
            in_openfast(fixed, lambda s: unpitch(loads(s), angles(s.state)), memory),
        ],
    )


def unpitch(vectors: Array, pitch: Sequence[float]) -> Array:
    """Components fixed to the hub of vectors in axes that pitch with the blades.

    The axes of the blade turn with the pitch theta about the span from tip to root:

        v_x,c = cos(theta) v_x,b + sin(theta) v_y,b,    v_y,c = cos(theta) v_y,b - sin(theta) v_x,b.

    Args:
        vectors: One blade after another, shape (blades, ..., 3).
        pitch: Pitch of each blade [rad].
    """
    shape = (-1, *([1] * (vectors.ndim - 2)))
    c, s = (f(pitch).reshape(shape) for f in (np.cos, np.sin))
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)

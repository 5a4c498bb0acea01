"""Columns with the loads at the roots of blades, of rigid and flexible ones alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.simulation.observers.history import Channel, Restartable
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.components.component import Channels, Turbine
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.components.pitch import find_angles

_NUMBERS = range(1, len(BLADES) + 1)


def root_channels(
    turbine: Turbine, loads: Callable[[Snapshot], Array], memory: Restartable
) -> Channels:
    """Forces and moments of the blades on what carries them.

    Args:
        loads: Function of the snapshot that returns them in axes that pitch, shape (blades, 2, 3).
        memory: What the loads remember.
    """
    angles = find_angles(turbine)
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

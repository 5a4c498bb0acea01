"""Camera positions: parallel projection, e2 upwards, everything in view."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

VIEWS = {
    "oblique": (0.5, 0.12, 0.86),
    "corner": (0.75, 0.16, 0.64),
    "front": (0.0, 0.0, 1.0),
    "side": (1.0, 0.0, 0.0),
}
"""Direction from the model to the observer; of a turbine if its rotor is on the side of +e3."""

_MARGIN = 1.06
_LEGEND = 0.2
"""Part of the width on the right that is left to the legend."""


@dataclass(frozen=True)
class Frame:
    """Points that must be in the picture.

    Args:
        low: Least coordinates, shape (3,) [m].
        high: Greatest coordinates, shape (3,) [m].
        side: 1 or -1, the direction along e3 that is the front.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    side: float = 1.0


def look_at(camera: Any, frame: Frame, view: str, size: tuple[int, int], legend: bool) -> None:
    """Point a camera at a model.

    Args:
        size: Width and height of the picture [pixels].
        legend: Whether there is one on the right.
    """
    direction = np.array(VIEWS[view]) * (frame.side, 1.0, frame.side)
    direction /= np.linalg.norm(direction)
    right = np.cross((0.0, 1.0, 0.0), direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    pick = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=bool)
    corners = np.where(pick, frame.high, frame.low)
    across, along = np.asarray(corners @ right), np.asarray(corners @ up)
    used = 1.0 - _LEGEND if legend else 1.0
    ratio = size[0] / size[1]
    width, height = float(np.ptp(across)), float(np.ptp(along))
    half = 0.5 * _MARGIN * max(height, width / (used * ratio), 1e-9)
    depth = float(np.linalg.norm(frame.high - frame.low)) + half
    # the middle of the model is in the middle of what the legend leaves, if there is little room
    room = half * ratio - 0.5 * _MARGIN * width
    shift = min((1.0 - used) * half * ratio, max(0.0, 2.0 * (1.0 - used) * half * ratio - room))
    focus = (
        (0.5 * (across.min() + across.max()) + shift) * right
        + 0.5 * (along.min() + along.max()) * up
        + (0.5 * (frame.low + frame.high) @ direction) * direction
    )
    camera.focal_point = focus
    camera.position = focus + 2.0 * depth * direction
    camera.up = (0.0, 1.0, 0.0)
    camera.enable_parallel_projection()
    camera.parallel_scale = float(half)
    camera.clipping_range = (0.1 * depth, 4.0 * depth)

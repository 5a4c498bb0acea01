"""Lines of a hollow blade along the span: as many as asked for, closer at the root.

A clamped tube bends its wall within some sqrt(R t) of the root, which long elements miss; that is
all that they cost in bending. So the first elements are about twice that long.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow_shape import HollowShape

_STEEPEST = 6.0  # the first element is at least this part of the mean
_REACH = 0.04  # part of the span over which elements grow to their full length
_CLOSEST = 0.4  # two lines stay apart by this part of the elements that were wanted between them
_TOLERANCE = 1e-6  # span fractions that differ by less are one
_BLUNT = 0.02  # a blade ends where its outline is this part of the longest one


def span_lines(shape: HollowShape, n_span: int) -> Array:
    """Return where the elements of a hollow blade meet along the span.

    Both ends of every web are lines; so are the other breaks of the shape where there are elements
    enough. A blade that runs out into a point ends just before it, without slivers.

    Args:
        shape: The blade.
        n_span: Number of elements along the span.

    Returns:
        Rising span fractions from 0, shape (n_span + 1,) [-].

    Raises:
        MeshError: if there are more ends of webs than lines.
    """
    end = _blunt_end(shape)
    ends = sorted(
        {round(x / _TOLERANCE) * _TOLERANCE: x for w in shape.webs for x in (w.start, w.end)}
    )
    ends = [x for x in ends if _TOLERANCE < x < end - _TOLERANCE]
    fine = np.linspace(0.0, end, 4001)
    progress = _element_count(shape, fine, n_span)
    pinned = _pin_ends(np.interp(ends, fine, progress), ends, n_span)
    pinned = {0: 0.0, n_span: end} | pinned
    for at in shape.breaks:
        _pin_break(pinned, at, float(np.interp(at, fine, progress)), fine, progress)
    number = sorted(pinned)
    ideal = np.interp([pinned[k] for k in number], fine, progress)
    return np.interp(np.interp(np.arange(n_span + 1), number, ideal), progress, fine)


def _blunt_end(shape: HollowShape) -> float:
    """Span fraction where the blade ends: 1, or where its outline has become tiny."""
    s = np.linspace(0.0, 1.0, 2001)
    contour = shape.surface(s[:, None], np.linspace(0.0, 1.0, 33))
    perimeter = np.linalg.norm(np.diff(contour, axis=1), axis=2).sum(axis=1)
    wide = np.flatnonzero(perimeter >= _BLUNT * perimeter.max())
    return float(s[wide[-1]])


def _element_count(shape: HollowShape, s: Array, n_span: int) -> Array:
    """Number of elements between the root and span fractions s, not rounded, shape of s."""
    arcs = np.linspace(0.0, 1.0, 129)
    root = shape.surface(np.zeros(1), arcs)
    radius = np.linalg.norm(np.diff(root, axis=0), axis=1).sum() / (2.0 * np.pi)
    layer = np.sqrt(radius * float(np.mean(shape.wall(np.zeros(1), arcs)))) / shape.length
    steepness = np.clip(1.0 / (2.0 * layer * n_span), 1.0, _STEEPEST)
    count = s + (steepness - 1.0) * _REACH * (1.0 - np.exp(-s / _REACH))
    scaled: Array = n_span * count / count[-1]
    return scaled


def _pin_ends(progress: Array, ends: Sequence[float], n_span: int) -> dict[int, float]:
    """Give each end of a web the nearest line that is free."""
    if len(ends) > n_span - 1:
        raise MeshError(
            f"mesh.span = {n_span}: webs begin and end at {len(ends)} places inside the span, "
            f"which takes at least {len(ends) + 1} elements"
        )
    numbers: list[int] = []
    for i, count in enumerate(progress):
        lowest = numbers[-1] + 1 if numbers else 1
        numbers.append(max(lowest, min(round(count), n_span - len(ends) + i)))
    return dict(zip(numbers, ends, strict=True))


def _pin_break(
    pinned: dict[int, float], at: float, count: float, fine: Array, progress: Array
) -> None:
    """Move the nearest line to a break, unless that would make an element too short."""
    number = round(count)
    if number in pinned:
        return
    below = max(k for k in pinned if k < number)
    above = min(k for k in pinned if k > number)
    first, last = np.interp([pinned[below], pinned[above]], fine, progress)
    if count - first > _CLOSEST * (number - below) and last - count > _CLOSEST * (above - number):
        pinned[number] = at

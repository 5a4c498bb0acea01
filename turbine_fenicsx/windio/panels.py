"""Panels of a blade: where lines of a mesh run, after the edges of caps and reinforcements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.curves import Curve
from turbine_fenicsx.windio.layers import Layer

STATIONS = np.linspace(0.0, 1.0, 201)
"""Span fractions where lines are laid; straight between them."""

GAPS = 0.005 + 0.01 * STATIONS**8
"""Lines keep this fraction of the contour from each other and from the trailing edge's corners, at
each of the stations: more towards the tip, where the contour is short and its layers are thin."""

WEB_GAP = 0.003
"""And this fraction from webs."""

_FILLER_MODULUS = 5e9
"""Layers with a Young's modulus below this fill, and have no separate lines [Pa]."""

_NEAR = 0.005
"""Reinforcements that begin or end within this fraction are at the trailing edge."""

_WIDE = 0.75
"""Layers wider than this fraction of the contour are skins, and have no lines either."""

_MIN_THICKNESS_RATIO = 0.1
"""Thickness of a layer, relative to its maximum, below which its edges do not count."""

LEADING = "leading edge"
SIDES = ("suction side", "pressure side")
CAPS = tuple(f"spar cap, {side}" for side in SIDES)
TRAILING = tuple(f"trailing-edge reinforcement, {side}" for side in SIDES)


@dataclass(frozen=True, eq=False)
class PanelLines:
    """Lines between the panels, without the trailing edge's corners.

    Args:
        names: Names of the n panels between the two corners.
        lines: Contour fractions at `STATIONS`, shape (201, n - 1) [-].
    """

    names: tuple[str, ...]
    lines: Array

    def __call__(self, s: Array) -> Array:
        """Contour fractions at span fractions s of shape (m,), (m, n - 1) [-]."""
        return np.column_stack([np.interp(s, STATIONS, line) for line in self.lines.T])


@dataclass(frozen=True, eq=False)
class WebLine:
    """Where a web meets one side of the shell.

    Args:
        arc: Contour fraction along the span [-].
        start: Span fraction where the web begins [-].
        end: Where it ends [-].
    """

    arc: Curve
    start: float
    end: float


def lay_lines(
    layers: Sequence[Layer], leading: Array, corners: Array, webs: Sequence[WebLine]
) -> PanelLines:
    """Lines along the leading edge and along the edges of caps and reinforcements.

    Where a layer is thin or absent, its edges do not matter: files put anything there.

    Args:
        leading: Contour fraction of the leading edge at `STATIONS`, (201,) [-].
        corners: Those of the trailing edge's corners, (201, 2) [-].
    """
    found = _find_reinforcements(layers, leading)
    halves = [
        [(TRAILING[0], "end"), (CAPS[0], "start"), (CAPS[0], "end"), (LEADING, "start")],
        [(LEADING, "end"), (CAPS[1], "start"), (CAPS[1], "end"), (TRAILING[1], "start")],
    ]
    before, after = (
        [
            _follow_edge(found[name], getattr(found[name], edge))
            for name, edge in half
            if name in found
        ]
        for half in halves
    )
    lines = np.column_stack([*before, leading, *after])
    _keep_from_webs(lines, webs)
    middle = len(before)
    _keep_apart(lines[:, :middle], corners[:, 0], lines[:, middle])
    _keep_apart(lines[:, middle + 1 :], lines[:, middle], corners[:, 1])
    return PanelLines(_name_panels(set(found)), lines)


def _find_reinforcements(layers: Sequence[Layer], leading: Array) -> dict[str, Layer]:
    """The stiffest layer of each kind, by where it lies."""
    found: dict[str, tuple[float, Layer]] = {}
    for layer in layers:
        t, start, end = (f(STATIONS) for f in (layer.thickness_at, layer.start, layer.end))
        area = t * (end - start)
        if not area.any() or layer.material.young[0] < _FILLER_MODULUS:
            continue
        first, last, edge = (np.average(arc, weights=area) for arc in (start, end, leading))
        if last - first > _WIDE:
            continue
        if first < edge < last:
            name = LEADING
        else:
            side = 0 if last <= edge else 1
            at_corner = first < _NEAR if side == 0 else last > 1.0 - _NEAR
            name = (TRAILING if at_corner else CAPS)[side]
        stiffness = float(area.sum()) * layer.material.young[0]
        if name not in found or stiffness > found[name][0]:
            found[name] = (stiffness, layer)
    return {name: layer for name, (_, layer) in found.items()}


def _name_panels(found: set[str]) -> tuple[str, ...]:
    """Names of the panels from corner to corner."""
    halves = []
    for side, cap, trailing in zip(SIDES, CAPS, TRAILING, strict=True):
        half = [trailing] if trailing in found else []
        half += [f"rear panel, {side}", cap, f"front panel, {side}"] if cap in found else [side]
        halves.append(half + [LEADING] * (LEADING in found))
    return (*halves[0], *reversed(halves[1]))


def _follow_edge(layer: Layer, edge: Curve) -> Array:
    """The start or end of a layer at `STATIONS`, constant from where the layer becomes thin."""
    s = np.union1d(layer.thickness.grid, edge.grid)
    t = layer.thickness_at(s)
    s = s[t > _MIN_THICKNESS_RATIO * t.max()]
    return np.asarray(np.interp(STATIONS, s, edge(s)))


def _keep_from_webs(lines: Array, webs: Sequence[WebLine]) -> None:
    """Move lines that come too near to a web away from it, to the side where they are mostly."""
    for web in webs:
        there = (STATIONS >= web.start - 0.005) & (STATIONS <= web.end + 0.005)
        arc = web.arc(STATIONS[there])
        for line in lines.T:
            if np.sum(line[there] - arc) > 0.0:
                line[there] = np.maximum(line[there], arc + WEB_GAP)
            else:
                line[there] = np.minimum(line[there], arc - WEB_GAP)


def _keep_apart(lines: Array, before: Array, after: Array) -> None:
    """Move lines that come too near to the one before, or else to the one after."""
    for k in range(lines.shape[1]):
        lines[:, k] = np.maximum(lines[:, k], before + GAPS)
        before = lines[:, k]
    for k in reversed(range(lines.shape[1])):
        lines[:, k] = np.minimum(lines[:, k], after - GAPS)
        after = lines[:, k]

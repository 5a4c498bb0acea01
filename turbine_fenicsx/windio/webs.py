"""Shear webs of a windIO file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.hollow_shape import Web
from turbine_fenicsx.windio.anchors import Anchors
from turbine_fenicsx.windio.curves import Curve
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.layers import Layer


@dataclass(frozen=True, eq=False)
class WindIOWeb:
    """A shear web with its layers.

    Args:
        layers: Its layers from the leading-edge to the trailing-edge face.
        suction: Contour fraction where it meets the suction side [-].
        pressure: Where it meets the pressure side [-].
    """

    web: Web
    layers: tuple[Layer, ...]
    suction: Curve
    pressure: Curve

    def wall(self, s: Array) -> Array:
        """Its thickness at span fractions, averaged over its height [m]."""
        return np.asarray(sum(x.thickness_at(s) * x.share(s, 0.0, 1.0) for x in self.layers))


def read_web_anchors(structure: Entry, shell: Anchors) -> dict[str, Anchors]:
    """The anchors of each web by its name; other names are those of the shell."""
    if "webs" not in structure:
        return {}
    return {
        web["name"].text(): Anchors(web.get("anchors"), shell)
        for web in structure["webs"].entries()
    }


def read_webs(
    structure: Entry, layers: Sequence[Layer], anchors: Mapping[str, Anchors], leading: Curve
) -> tuple[WindIOWeb, ...]:
    """The webs of a blade."""
    webs = []
    for entry in structure["webs"].entries() if anchors else ():
        name = entry["name"].text()
        mine = tuple(x for x in layers if x.web == name and x.thickness.values.any())
        if not mine:
            entry.fail("has no layer with a thickness")
        start = min(x.thickness.start for x in mine)
        end = max(x.thickness.end for x in mine)
        sides = [
            _hold_straight(anchors[name].resolve(entry[key]), start, end, entry, key)
            for key in ("start_nd_arc", "end_nd_arc")
        ]
        web = WindIOWeb(Web(name, start, end), mine, *sides)
        _check_place(entry, web, leading)
        webs.append(web)
    _check_order(structure, webs)
    return tuple(webs)


def _hold_straight(curve: Curve, start: float, end: float, entry: Entry, key: str) -> Curve:
    """A curve without stations outside of a web's extent, straight on to its ends.

    Files put anything there, and half an interval of it lies within the extent where a web begins
    or ends between two stations.
    """
    inside = (curve.grid >= start - 1e-9) & (curve.grid <= end + 1e-9)
    if np.count_nonzero(inside) < 2:
        return curve
    s, a = curve.grid[inside], curve.values[inside]
    spacing = np.diff(curve.grid).max()
    if s[0] - start > spacing or end - s[-1] > spacing:
        entry.fail(
            f"reaches from {start:g} to {end:g}, but its {key} is resolved only from {s[0]:g} to "
            f"{s[-1]:g}"
        )
    if s[0] > start:
        a = np.append(a[0] - (a[1] - a[0]) / (s[1] - s[0]) * (s[0] - start), a)
        s = np.append(start, s)
    if s[-1] < end:
        a = np.append(a, a[-1] + (a[-1] - a[-2]) / (s[-1] - s[-2]) * (end - s[-1]))
        s = np.append(s, end)
    return Curve(s, a)


def _check_place(entry: Entry, web: WindIOWeb, leading: Curve) -> None:
    s = np.unique(np.concatenate([web.suction.grid, web.pressure.grid]))
    s = s[(s >= web.web.start) & (s <= web.web.end)]
    suction, pressure, edge = web.suction(s), web.pressure(s), leading(s)
    outside = (suction <= 0.0) | (suction >= edge) | (pressure <= edge) | (pressure >= 1.0)
    if outside.any():
        k = int(np.flatnonzero(outside)[0])
        entry.fail(
            f"lies outside of the section at station {s[k]:g}: it must run from the suction side "
            f"(0 to {edge[k]:.3g}) to the pressure side (to 1), got {suction[k]:g} to "
            f"{pressure[k]:g}"
        )


def _check_order(structure: Entry, webs: list[WindIOWeb]) -> None:
    for k, one in enumerate(webs):
        for other in webs[:k]:
            start = max(one.web.start, other.web.start)
            s = np.linspace(start, min(one.web.end, other.web.end), 101)
            if s[-1] <= start:
                continue
            signs = np.sign(
                [one.suction(s) - other.suction(s), other.pressure(s) - one.pressure(s)]
            )
            wrong = np.flatnonzero((signs != signs[0, 0]).any(axis=0) | (signs == 0.0).any(axis=0))
            if len(wrong):
                structure["webs"].fail(
                    f"{other.web.name!r} and {one.web.name!r} cross at station {s[wrong[0]]:.3g}"
                )

"""Layers of shell and webs: where they lie, how thick they are, and of what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply import PlyMaterial
from turbine_fenicsx.windio.anchors import Anchors
from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.places import FINE

_TOLERANCE = 1e-9
"""Stations that differ by less are the same."""

_ROUND_OFF = 1e-12
"""Thicknesses down to minus this are zero [m]."""

MAX_OVERHANG = 0.05
"""Part of the span by which layers of a web may reach beyond its anchors, an interval of a grid."""

THICKEST = 1.0
"""A layer is no thicker [m]."""


@dataclass(frozen=True, eq=False)
class Layer:
    """A layer of one material.

    Args:
        web: The web it is a part of; None in the shell.
        thickness: Thickness along the span, none outside of the curve's stations [m].
        angle: Angle of the fibres as the file has it [deg].
        start: Fraction of the contour, or of a web's height from the suction side, where it
            begins [-].
        end: Where it ends [-].
        remark: What was changed, a sentence; empty for nothing.
    """

    name: str
    material: PlyMaterial
    web: str | None
    thickness: Curve
    angle: Curve
    start: Curve
    end: Curve
    remark: str = ""

    def thickness_at(self, s: Array | float) -> Array:
        """Thickness at span fractions [m]."""
        t = self.thickness
        there = (s >= t.start - _TOLERANCE) & (s <= t.end + _TOLERANCE)
        return np.asarray(np.where(there, t(s), 0.0))

    def share(self, s: Array | float, a0: Array | float, a1: Array | float) -> Array:
        """How much of the arc from a0 to a1 it covers at span fractions s, from 0 to 1 [-]."""
        covered = np.minimum(a1, self.end(s)) - np.maximum(a0, self.start(s))
        return np.asarray(np.maximum(covered, 0.0) / (np.asarray(a1) - a0))

    def line_mass(self, s: Array, width: Array) -> Array:
        """Its mass per length, (m,) [kg/m], in a wall of a width, (m,) [m]."""
        share = self.share(s, 0.0, 1.0)
        return np.asarray(self.material.density * self.thickness_at(s) * share * width)

    @property
    def jumps(self) -> list[float]:
        """Span fractions where it begins or ends suddenly with some thickness."""
        t = self.thickness
        return [s for s, value in ((t.start, t.values[0]), (t.end, t.values[-1])) if value > 0.0]


def read_layers(
    structure: Entry,
    materials: Mapping[str, PlyMaterial],
    shell: Anchors,
    webs: Mapping[str, Anchors],
) -> list[Layer]:
    """Layers of a blade in the order of the file, from the outer to the inner face."""
    layers = []
    for entry in structure["layers"].entries():
        web = entry["web"].text() if "web" in entry else None
        if web is not None and web not in webs:
            entry.fail(f"belongs to the web {web!r}, which is not among the webs")
        anchors = shell if web is None else webs[web]
        layers.append(_read_layer(entry, web, materials, anchors))
    if not layers:
        structure["layers"].fail("must have at least one layer")
    return layers


def _read_layer(
    entry: Entry, web: str | None, materials: Mapping[str, PlyMaterial], anchors: Anchors
) -> Layer:
    material = entry["material"].text()
    if material not in materials:
        entry.fail(f"is of {material!r}, which is not among the materials of the file")
    thickness = read_curve(entry["thickness"], 0.0, THICKEST, round_off=_ROUND_OFF)
    if not thickness.values.any():
        thickness = Curve(thickness.grid[[0, -1]], np.zeros(2))
    angle = entry.get("fiber_orientation")
    start, end = (anchors.resolve(entry[key]) for key in ("start_nd_arc", "end_nd_arc"))
    layer = Layer(
        name=entry["name"].text(),
        material=materials[material],
        web=web,
        thickness=thickness if web is None else _cut_ramps(thickness),
        angle=read_curve(angle) if angle else Curve(np.array([0.0, 1.0]), np.zeros(2)),
        start=start,
        end=end,
    )
    layer = _cut_overhang(entry, layer)
    _check_place(entry, layer)
    s = np.unique(np.concatenate([start.grid, end.grid, FINE]))
    if np.any(start(s) > end(s)):
        layer = replace(layer, end=Curve(s, np.maximum(start(s), end(s))))
    return layer


def _cut_ramps(thickness: Curve) -> Curve:
    """Begin and end a layer of a web suddenly, in the middle of the ramps from and to 0.

    Sampled curves rise over one interval where the web begins; its mass stays the same.
    """
    s, t = thickness.grid, thickness.values
    there = np.flatnonzero(t > 0.0)
    if not len(there):
        return thickness
    first, last = int(there[0]), int(there[-1])
    grid, values = s[first : last + 1], t[first : last + 1]
    if first > 0:
        grid, values = np.append(0.5 * (s[first - 1] + s[first]), grid), np.append(t[first], values)
    if last + 1 < len(s):
        grid, values = np.append(grid, 0.5 * (s[last] + s[last + 1])), np.append(values, t[last])
    return Curve(grid, values) if len(grid) > 1 else thickness


def _cut_overhang(entry: Entry, layer: Layer) -> Layer:
    """A layer of a web as far as its anchors go, if it reaches a little further."""
    t = layer.thickness
    low, high = max(layer.start.start, layer.end.start), min(layer.start.end, layer.end.end)
    beyond = max(low - t.start, t.end - high)
    if layer.web is None or not 1e-6 < beyond < MAX_OVERHANG or not t.values.any():
        return layer
    start, end = max(t.start, low), min(t.end, high)
    inner = t.grid[(t.grid > start) & (t.grid < end)]
    s = np.concatenate([[start], inner, [end]])
    remark = (
        f"{entry.file}: {entry.place} reaches from {t.start:.4g} to {t.end:.4g}, its anchors from "
        f"{low:.4g} to {high:.4g}; it is read as far as they go"
    )
    return replace(layer, thickness=Curve(s, t(s)), remark=remark)


def _is_filler(entry: Entry) -> bool:
    """Whether a layer lies between two parts; it covers nothing where these overlap."""
    names = [
        entry[key]["anchor"]["name"].text()
        for key in ("start_nd_arc", "end_nd_arc")
        if "anchor" in entry[key]
    ]
    return len(set(names)) == 2


def _check_place(entry: Entry, layer: Layer) -> None:
    """Anchors must be known, and in order, wherever the layer has a thickness."""
    s = np.unique(np.concatenate([layer.thickness.grid, layer.start.grid, layer.end.grid]))
    s = s[layer.thickness_at(s) > 0.0]
    for key, curve in (("start_nd_arc", layer.start), ("end_nd_arc", layer.end)):
        outside = s[(s < curve.start - 1e-6) | (s > curve.end + 1e-6)]
        if len(outside):
            entry.fail(
                f"has a thickness at station {outside[0]:g}, where the anchor of its {key} is not "
                f"resolved: it reaches from {curve.start:g} to {curve.end:g}"
            )
    wrong = s[layer.start(s) > layer.end(s) + 1e-6]
    if len(wrong) and not _is_filler(entry):
        entry.fail(
            f"begins behind its end at station {wrong[0]:g}: from {layer.start(wrong[0]):g} to "
            f"{layer.end(wrong[0]):g}"
        )

"""The blade of a windIO file as a mesher and a material ask for it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply import Ply, PlyMaterial
from turbine_fenicsx.meshing.hollow_shape import Web
from turbine_fenicsx.windio.anchors import Anchors
from turbine_fenicsx.windio.curves import Curve
from turbine_fenicsx.windio.entry import Entry
from turbine_fenicsx.windio.layers import Layer, read_layers
from turbine_fenicsx.windio.outer_shape import OuterShape, read_outer_shape
from turbine_fenicsx.windio.panels import STATIONS, PanelLines, WebLine, lay_lines


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


FACE_NAME = "trailing edge"
"""Name of the two panels that are the halves of the trailing edge's face."""

_WINDOW = 0.004
"""Walls are averaged over twice this fraction of the contour, so that they have no jumps."""

_THINNEST = 1e-7
"""Thinner plies are left out [m]."""

_SLIVER = 0.02
"""A layer that covers less of a cell than this is left out, one that leaves less covers it all: its
edge is a line of the mesh, and what one cell gains its neighbour loses. Foam that lies beside a cap
must not lie below it, even if it were thin."""

_GAUSS = (0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)), (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)
"""Points and weights between 0 and 1."""


@dataclass(frozen=True, eq=False)
class WindIOBlade:
    """A hollow blade with its layup, a `turbine_fenicsx.meshing.hollow_shape.HollowShape`.

    Args:
        layers: Layers of the shell from the outer to the inner face; none if the file has none.
        leading: Contour fraction of the leading edge along the span [-].
        hub_radius: Distance of the root from the rotor centre [m].
        closed_tip: Whether it ends in a plate, which files do not describe.
        warnings: What in the file disagrees, a sentence each.
    """

    outer_shape: OuterShape
    layers: tuple[Layer, ...]
    inner_webs: tuple[WindIOWeb, ...]
    leading: Curve
    panel_lines: PanelLines
    hub_radius: float
    closed_tip: bool = True
    warnings: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Length of the reference axis [m]."""
        return self.outer_shape.length

    @property
    def has_layup(self) -> bool:
        """Whether the file says what the walls are made of."""
        return bool(self.layers)

    @property
    def breaks(self) -> tuple[float, ...]:
        """Span fractions where webs and layers begin or end."""
        found = [0.0, 1.0]
        for layer in (*self.layers, *(x for web in self.inner_webs for x in web.layers)):
            found += layer.jumps
        rising = sorted(found)
        return tuple(s for k, s in enumerate(rising) if k == 0 or s - rising[k - 1] > 1e-6)

    @property
    def panels(self) -> tuple[str, ...]:
        """Names of the panels around a section."""
        return (FACE_NAME, *self.panel_lines.names, FACE_NAME)

    @property
    def webs(self) -> tuple[Web, ...]:
        """The shear webs."""
        return tuple(web.web for web in self.inner_webs)

    @property
    def materials(self) -> tuple[PlyMaterial, ...]:
        """Materials of shell and webs, each once, in the order of the file's layers."""
        every = (*self.layers, *(x for web in self.inner_webs for x in web.layers))
        return tuple(dict.fromkeys(layer.material for layer in every))

    def lines(self, s: Array) -> Array:
        """Contour fractions that bound the panels at span fractions s, (m, n + 1) [-]."""
        s = np.asarray(s, float)
        corners = self.outer_shape.corners(s)
        return np.column_stack(
            [np.zeros_like(s), corners[:, 0], self.panel_lines(s), corners[:, 1], np.ones_like(s)]
        )

    def web_arcs(self, web: int, s: Array) -> Array:
        """Contour fractions where a web meets suction and pressure side, (m, 2) [-]."""
        inner = self.inner_webs[web]
        return np.column_stack([inner.suction(s), inner.pressure(s)])

    def axis_at(self, s: Array) -> Array:
        """Points of the reference axis along a1, a2, a3, shape (m, 3) [m]."""
        return self._place(self.outer_shape.reference_points(s))

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the outer surface along a1, a2, a3, one axis more than the arguments [m]."""
        return self._place(self.outer_shape.points(s, a))

    def _place(self, points: Array) -> Array:
        """Points of the file, from the rotor centre along a1, a2, a3."""
        x, y, z = np.moveaxis(points, -1, 0)
        return np.stack([z + self.hub_radius, -y, x], axis=-1)

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall there [m]; where a layer begins or ends it changes gradually."""
        s, a = np.broadcast_arrays(np.asarray(s, float), np.asarray(a, float))
        a0, a1 = np.maximum(a - _WINDOW, 0.0), np.minimum(a + _WINDOW, 1.0)
        return np.asarray(sum(x.thickness_at(s) * x.share(s, a0, a1) for x in self.layers))

    def web_wall(self, web: int, s: Array) -> Array:
        """Thickness of a web, shape (m,) [m]."""
        return self.inner_webs[web].wall(np.asarray(s, float))

    @property
    def line_mass(self) -> Curve:
        """Mass per length of the layup as thin walls [kg/m]."""
        s = np.linspace(0.0, 1.0, 101)
        girth = self.outer_shape.girth(s)
        parts = [layer.line_mass(s, girth) for layer in self.layers]
        for web in self.inner_webs:
            ends = self.surface(s[:, None], np.column_stack([web.suction(s), web.pressure(s)]))
            there = (web.web.start <= s) & (s <= web.web.end)
            height = there * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
            parts += [layer.line_mass(s, height) for layer in web.layers]
        return Curve(s, np.asarray(sum(parts)))

    def layup(
        self, part: str, span: tuple[float, float], arc: tuple[float, float]
    ) -> tuple[Ply, ...]:
        """Plies of a cell from its outer to its inner face, in a web from the leading-edge side.

        Layers that cover the cell in part count by that part and the thickness is the mean over the
        cell's span, so that the mass of each layer stays what it is.

        Args:
            part: Name of a web, or of any panel.
            span: First and last span fraction of the cell [-].
            arc: First and last fraction of the contour in the middle of the cell's span, or of a
                web's height [-].
        """
        web = next((web for web in self.inner_webs if web.web.name == part), None)
        s = span[0] + (span[1] - span[0]) * np.array(_GAUSS[0])
        weights = np.array(_GAUSS[1])
        # Angles are positive towards the leading edge, which is against the normal's sense below.
        middle = 0.5 * sum(span)
        below = web is None and 0.5 * sum(arc) > self.leading(middle)
        plies = []
        for layer in self.layers if web is None else web.layers:
            thickness = weights * layer.thickness_at(s)
            share = float(layer.share(middle, *arc))
            if share > 1.0 - _SLIVER:
                share = 1.0
            mean = float(thickness.sum())
            if share > _SLIVER and share * mean > _THINNEST:
                angle = np.radians(float(thickness @ layer.angle(s)) / mean)
                plies.append(Ply(layer.material, share * mean, -angle if below else angle))
        if not plies:
            raise ModelError(
                f"no layer covers {part!r} between {span[0]:.4g} and {span[1]:.4g} of the span and "
                f"{arc[0]:.4g} and {arc[1]:.4g} of its contour"
            )
        return tuple(plies)


def read_blade(
    blade: Entry, airfoils: Entry, materials: dict[str, PlyMaterial], hub_radius: float
) -> WindIOBlade:
    """The blade of a file.

    Args:
        hub_radius: Distance of the root from the rotor centre [m].
    """
    shape = read_outer_shape(blade, airfoils)
    leading = Curve(STATIONS, shape.leading_edge(STATIONS))
    structure = blade["structure"]
    if "layers" not in structure:
        bare = lay_lines((), leading.values, shape.corners(STATIONS), ())
        return WindIOBlade(shape, (), (), leading, bare, hub_radius)
    places = Anchors(structure["anchors"], shape=shape)
    anchors = read_web_anchors(structure, places)
    layers = read_layers(structure, materials, places, anchors)
    webs = read_webs(structure, layers, anchors, leading)
    shell = tuple(layer for layer in layers if layer.web is None)
    ends = [
        WebLine(arc, web.web.start, web.web.end)
        for web in webs
        for arc in (web.suction, web.pressure)
    ]
    lines = lay_lines(shell, leading.values, shape.corners(STATIONS), ends)
    cut = (layer.remark for layer in layers if layer.remark)
    warnings = (*places.list_disagreements(), *cut, *_list_left_out(structure))
    found = WindIOBlade(shape, shell, webs, leading, lines, hub_radius, warnings=warnings)
    _check_walls(structure, found)
    return found


def _list_left_out(structure: Entry) -> Iterator[str]:
    """A sentence for each part of a blade that has mass or stiffness and is not read."""
    webs = structure["webs"].entries() if "webs" in structure else ()
    found = [web.place for web in webs if web.get("flanges") is not None]
    if "trailing_edge_adhesive" in structure:
        found.append(structure["trailing_edge_adhesive"].place)
    joint = structure.get("joint")
    if joint is not None and "mass" in joint and joint["mass"].number() > 0.0:
        found.append(f"{joint.place} of {joint['mass'].number():.4g} kg")
    for place in found:
        what = f"flanges of {place} are" if ".webs[" in place else f"{place} is"
        yield f"{structure.file}: {what} left out, with mass and stiffness"


def _check_walls(structure: Entry, blade: WindIOBlade) -> None:
    """There must be a wall everywhere."""
    lines = blade.lines(STATIONS)
    middles = 0.5 * (lines[:, 1:] + lines[:, :-1])
    walls = blade.wall(STATIONS[:, None], middles)
    for k, panel in np.argwhere(walls < _THINNEST):
        structure["layers"].fail(
            f"leave the {blade.panels[panel]!r} without a wall at station {STATIONS[k]:g}"
        )

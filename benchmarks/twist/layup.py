"""Outer shape and layers of a blade in a windIO file, read with yaml, numpy and scipy alone.

This reader shares no line with ``turbine_fenicsx.windio``, so that what both find does not depend
on either. It takes the arcs of layers that the file lists, and no planes.

Axes are those of the file: x to the suction side, y to the trailing edge, z along the span. An
outline begins and ends in the middle of the trailing edge's face, and has the suction side first.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
import yaml
from scipy.interpolate import PchipInterpolator

SAMPLES = 200
"""Points of each side of a profile."""

NARROWEST = {"trailing": 0.012, "nose": 0.008}
"""Least part of the outline that a reinforcement takes; narrower ones are at root and tip."""

MIDDLE = 0.3
"""Span fraction where the order of panels is read."""

FACE = 0.006
"""Least thickness of the trailing edge over the chord."""


@dataclass(frozen=True)
class Layer:
    """A layer of the shell, or of a web.

    Attributes:
        material: Name of its material.
        web: Name of its web; none in the shell.
        start: Name of the anchor and handle where it begins around the section.
        end: Where it ends.
        thickness: Grid and values [m]; there is no layer beyond the grid.
    """

    material: str
    web: str | None
    start: tuple[str, str]
    end: tuple[str, str]
    thickness: tuple[list, list]

    def thick(self, s):
        """Thickness at a span fraction [m]."""
        grid, values = self.thickness
        return float(np.interp(s, grid, values, left=0.0, right=0.0))


class Blade:
    """A blade of a windIO 2 file.

    Args:
        path: The file.
    """

    inset = True
    """The outline is the outer surface, half a wall outside the middle of the wall."""

    def __init__(self, path):
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        self.path = path
        with Path(path).open() as file:
            root = yaml.load(file, Loader=loader)
        blade = root["components"]["blade"]
        self.materials = {m["name"]: m for m in root["materials"]}
        self.shape, self.structure = blade["outer_shape"], blade["structure"]
        self.axis = [_smooth(blade["reference_axis"][k]) for k in "xyz"]
        self.twist, self.chord, self.offset, self.rthick = (
            _smooth(self.shape[k]) for k in ("twist", "chord", "section_offset_y", "rthick")
        )
        self.airfoils = {airfoil["name"]: airfoil for airfoil in root["airfoils"]}
        self.layers = [self._layer(entry) for entry in self.structure["layers"]]
        self.anchors = {a["name"]: a for a in self.structure["anchors"]}

    def _layer(self, entry):
        ends = [
            (entry[k]["anchor"]["name"], entry[k]["anchor"]["handle"])
            for k in ("start_nd_arc", "end_nd_arc")
        ]
        turned = entry.get("fiber_orientation", {"values": [0.0]})["values"]
        if any(turned):
            raise ValueError(f"{entry['name']}: fibres that are turned are not read")
        curve = entry["thickness"]
        thickness = curve["grid"], curve["values"]
        return Layer(entry["material"], entry.get("web"), *ends, thickness)

    # -- shape --------------------------------------------------------------------------------

    @cached_property
    def _profiles(self):
        """Both sides of a profile, y over x with cosine spacing, over its relative thickness."""
        x = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, SAMPLES))
        found = {}
        for airfoil in (self.airfoils[a["name"]] for a in self.shape["airfoils"]):
            px, py = (np.array(airfoil["coordinates"][k], dtype=float) for k in "xy")
            px = (px - px.min()) / np.ptp(px)
            nose = int(px.argmin())
            sides = [
                PchipInterpolator(*_rising(px[: nose + 1][::-1], py[: nose + 1][::-1]))(x),
                PchipInterpolator(*_rising(px[nose:], py[nose:]))(x),
            ]
            if sides[0].mean() < sides[1].mean():
                sides.reverse()
            found[float(airfoil["rthick"])] = np.array(sides)
        thick = sorted(found)
        return x, PchipInterpolator(thick, np.array([found[t] for t in thick]))

    def outline(self, s):
        """Points of an outline over the chord, (n, 2), and their arcs, (n,).

        Returns:
            Points (x to the suction side, y to the trailing edge from the leading one) over the
            chord, from suction to pressure corner of the trailing edge; and their fractions of
            the outline, which begins in the middle of the face.
        """
        x, blend = self._profiles
        suction, pressure = blend(np.clip(self.rthick(s), blend.x[0], blend.x[-1]))
        gap = max(0.0, FACE - (suction[-1] - pressure[-1]))
        suction, pressure = suction + 0.5 * gap * x, pressure - 0.5 * gap * x
        points = np.column_stack(
            [np.append(suction[::-1], pressure[1:]), np.append(x[::-1], x[1:])]
        )
        half = 0.5 * np.linalg.norm(points[0] - points[-1])
        along = half + np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        return points, along / (along[-1] + half)

    def axes(self, s):
        """Point of the reference axis, and axes x, y, z of the section as rows, (3, 3)."""
        slope = np.array([curve(s, 1) for curve in self.axis])
        z = slope / np.linalg.norm(slope)
        flat = np.cross(z, [1.0, 0.0, 0.0])
        flat /= np.linalg.norm(flat)
        turn = np.radians(self.twist(s))
        y = np.cos(turn) * flat + np.sin(turn) * np.cross(flat, z)
        return np.array([curve(s) for curve in self.axis]), np.array([np.cross(y, z), y, z])

    def place(self, s, points):
        """Points over the chord, (n, 2), in the axes of the root, (n, 3) [m]."""
        origin, axes = self.axes(s)
        flat = self.chord(s) * points
        flat[:, 1] -= self.offset(s)
        return origin + flat @ axes[:2]

    # -- layers -------------------------------------------------------------------------------

    def arc(self, anchor, s):
        """Fraction of the outline at an anchor (its name and handle), held beyond its grid."""
        curve = self._anchor(anchor)
        return float(np.interp(s, curve["grid"], curve["values"]))

    def _anchor(self, anchor):
        entry = self.anchors[anchor[0]][anchor[1]]
        return self._anchor(tuple(entry["anchor"].values())) if "anchor" in entry else entry

    @cached_property
    def edges(self):
        """Anchors between panels, from the suction to the pressure corner of the trailing edge.

        They are those that have a width: edges of caps and reinforcements.
        """
        found = {}
        for layer in self.layers:
            for a in (layer.start, layer.end) if layer.web is None else ():
                if "width" in self.anchors[a[0]]:
                    found[a] = self.arc(a, MIDDLE)
        return sorted((a for a, at in found.items() if 0.002 < at < 0.998), key=found.__getitem__)

    @cached_property
    def _nose(self):
        """Number of the edge behind which the panel at the leading edge begins."""
        points, arcs = self.outline(MIDDLE)
        at = [self.arc(anchor, MIDDLE) for anchor in self.edges]
        return int(np.searchsorted(at, arcs[points[:, 1].argmin()])) - 1

    @lru_cache  # noqa: B019, a blade lives as long as the script
    def panels(self, s):
        """Arcs between which panels lie, in order: corners of the trailing edge and edges."""
        corner = self.outline(s)[1][[0, -1]]
        at = np.array([self.arc(anchor, s) for anchor in self.edges])
        at[0] = max(at[0], corner[0] + NARROWEST["trailing"])
        at[-1] = min(at[-1], corner[1] - NARROWEST["trailing"])
        nose = slice(self._nose, self._nose + 2)
        half = 0.5 * max(np.ptp(at[nose]), NARROWEST["nose"])
        at[nose] = at[nose].mean() + np.array([-half, half])
        return np.concatenate([corner[:1], at, corner[1:]])

    def plies(self, s, arc):
        """Materials and thicknesses [m] of the shell's layers at an arc, from outside inwards.

        The face of the trailing edge, beyond the last panel, has those of the first panel.
        """
        panels = self.panels(s)
        arc = arc if arc < panels[-1] else 0.5 * (panels[0] + panels[1])
        shell = [layer for layer in self.layers if layer.web is None]
        return _stack(s, [x for x in shell if self._at(x.start, s) <= arc <= self._at(x.end, s)])

    def _at(self, anchor, s):
        if anchor in self.edges:
            return self.panels(s)[1 + self.edges.index(anchor)]
        return self.arc(anchor, s)

    def web_plies(self, s, web):
        """The same of a web, a number."""
        name = self.structure["webs"][web]["name"]
        return _stack(s, [layer for layer in self.layers if layer.web == name])

    @cached_property
    def webs(self):
        """Webs.

        Each has its first and last span fraction, and for both its edges the number of a panel and
        a curve of how far the web stands within the panel, held beyond the web's layers.
        """
        found = []
        for number, web in enumerate(self.structure["webs"]):
            ends = [tuple(web[k]["anchor"].values()) for k in ("start_nd_arc", "end_nd_arc")]
            grid = np.array(self._anchor(ends[0])["grid"])
            grid = grid[[bool(self.web_plies(s, number)) for s in grid]]
            places = []
            for end in ends:
                middle = 0.5 * (grid[0] + grid[-1])
                panel = int(np.searchsorted(self.panels(middle), self.arc(end, middle))) - 1
                lines = np.array([self.panels(s)[panel : panel + 2] for s in grid])
                at = np.array([self.arc(end, s) for s in grid])
                part = (at - lines[:, 0]) / np.ptp(lines, axis=1)
                places.append((panel, grid, np.clip(part, 0.05, 0.95)))
            found.append((grid[0], grid[-1], places))
        return found


def _stack(s, layers):
    thick = [(layer.material, layer.thick(s)) for layer in layers]
    return [(material, t) for material, t in thick if t > 1e-6]


def _smooth(curve):
    return PchipInterpolator(
        *_rising(np.array(curve["grid"]), np.array(curve["values"], dtype=float))
    )


def _rising(x, y):
    keep = np.append(True, np.diff(np.maximum.accumulate(x)) > 1e-12)
    return x[keep], y[keep]

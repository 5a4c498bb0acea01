"""The outer surface of a blade: sections along a curved axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.windio.airfoils import BODY, FACE, Sections, read_sections
from turbine_fenicsx.windio.curves import Curve, read_curve
from turbine_fenicsx.windio.entry import Entry

MAX_LENGTH = 500.0
"""A blade is no longer [m]."""


@dataclass(frozen=True, eq=False)
class OuterShape:
    """Sections at right angles to the reference axis.

    Coordinates are those of windIO: x to the suction side, y to the trailing edge, z along the
    span from the root. s is what all grids of the file mean: a fraction along the reference axis.

    Args:
        axis: x, y and z of the reference axis [m].
        chord: Length of the chord [m].
        twist: Angle by which the leading edge is turned towards the pressure side [deg].
        offset_x: From the reference axis to the chord, towards the suction side [m].
        offset_y: From the leading edge to the reference axis, along the chord [m].
        thickness: Relative thickness [-].
        sections: Sections by relative thickness.
    """

    axis: tuple[Curve, Curve, Curve]
    chord: Curve
    twist: Curve
    offset_x: Curve
    offset_y: Curve
    thickness: Curve
    sections: Sections

    @property
    def length(self) -> float:
        """Length of the reference axis [m]."""
        points = self.reference_points(np.linspace(0.0, 1.0, 2001))
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    def reference_points(self, s: Array) -> Array:
        """Points of the reference axis, (m, 3) [m]."""
        return np.column_stack([curve.smooth(s) for curve in self.axis])

    def contour(self, s: float) -> tuple[Array, Array]:
        """Points of a section in units of chord and their contour fractions; see `Sections`."""
        return self.sections.contour(float(self.thickness.smooth(np.asarray(s))))

    def girth(self, s: Array) -> Array:
        """Length of the contour of sections, (m,) [m]."""
        around = [np.hypot(*np.diff(self.contour(one)[0], axis=0).T).sum() for one in s.tolist()]
        return np.asarray(around) * self.chord.smooth(s)

    def corners(self, s: Array) -> Array:
        """Contour fractions of the corners of the trailing edge, (m, 2) [-]."""
        return np.array([self.contour(float(one))[1][[FACE, FACE + BODY]] for one in s])

    def leading_edge(self, s: Array) -> Array:
        """Contour fraction of the foremost point, (m,) [-]."""
        found = []
        for one in s:
            points, arcs = self.contour(float(one))
            found.append(arcs[points[:, 0].argmin()])
        return np.array(found)

    def points(self, s: Array, a: Array) -> Array:
        """Points of the surface.

        Args:
            s: Span fractions [-].
            a: Contour fractions, of a shape that broadcasts with s [-].

        Returns:
            x, y and z, one axis more than the arguments [m].
        """
        s, a = np.broadcast_arrays(s, a)
        stations, which, counts = np.unique(s, return_inverse=True, return_counts=True)
        order = np.argsort(which.ravel(), kind="stable")
        flat, a = np.empty((s.size, 2)), a.ravel()  # to the trailing edge, to the suction side
        for station, here in zip(stations, np.split(order, np.cumsum(counts)[:-1]), strict=True):
            section, arcs = self.contour(float(station))
            for column in (0, 1):
                flat[here, column] = np.interp(a[here], arcs, section[:, column])
        which, local = which.reshape(s.shape), flat.reshape(*s.shape, 2)
        chord, offset_x, offset_y = (
            curve.smooth(stations)[which] for curve in (self.chord, self.offset_x, self.offset_y)
        )
        along = local[..., 0] * chord - offset_y
        across = local[..., 1] * chord + offset_x
        to_trailing, to_suction = (axes[which] for axes in self.frames(stations))
        origins = self.reference_points(stations)[which]
        return np.asarray(origins + along[..., None] * to_trailing + across[..., None] * to_suction)

    def frames(self, s: Array) -> tuple[Array, Array]:
        """Directions of the chord and of its normal to the suction side, (m, 3) each [-].

        Untwisted, the normal lies in the plane of x and z, as the definition of windIO has it.
        Towards the root the sections turn until the root itself stands at right angles to z, within
        one chord, so that it is plane where it is bolted on.
        """
        chord = float(self.chord.smooth(np.zeros(1))[0])
        upright = np.clip(s * self.length / chord, 0.0, 1.0)
        upright = upright**2 * (3.0 - 2.0 * upright)
        tangent = np.column_stack([curve.slope(s) for curve in self.axis])
        tangent[:, :2] *= upright[:, None]
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        normal = np.column_stack([tangent[:, 2], np.zeros(len(s)), -tangent[:, 0]])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        chordwise = np.cross(tangent, normal)
        twist = np.radians(self.twist.smooth(s))[:, None]
        return (
            chordwise * np.cos(twist) + normal * np.sin(twist),
            normal * np.cos(twist) - chordwise * np.sin(twist),
        )


def read_outer_shape(blade: Entry, airfoils: Entry) -> OuterShape:
    """The outer surface of a blade."""
    shape = blade["outer_shape"]
    x, y, z = (
        read_curve(blade["reference_axis"][key], -MAX_LENGTH, MAX_LENGTH, whole=True)
        for key in "xyz"
    )
    falling = np.flatnonzero(np.diff(z.values) <= 0.0)
    if len(falling):
        blade["reference_axis"]["z"].fail(
            f"must rise from the root to the tip, it does not behind station {z.grid[falling[0]]:g}"
        )
    chord = read_curve(shape["chord"], 1e-3, 50.0, whole=True)
    thickness = read_curve(shape["rthick"], 1e-3, 1.1, whole=True)
    none = Curve(np.array([0.0, 1.0]), np.zeros(2))
    offset_x = shape.get("section_offset_x")
    return OuterShape(
        axis=(x, y, Curve(z.grid, z.values - z.values[0])),
        chord=chord,
        twist=read_curve(shape["twist"], -90.0, 90.0, whole=True),
        offset_x=read_curve(offset_x, -10.0, 10.0, whole=True) if offset_x else none,
        offset_y=read_curve(shape["section_offset_y"], -50.0, 50.0, whole=True),
        thickness=thickness,
        sections=read_sections(airfoils, shape["airfoils"], thickness.values, thickness.grid),
    )

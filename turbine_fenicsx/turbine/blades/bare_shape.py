"""The outer surface of a blade with thin walls that only carry nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.hollow_shape import Web
from turbine_fenicsx.windio.blade import FACE_NAME, WindIOBlade
from turbine_fenicsx.windio.panels import SIDES

WALL = 0.02
"""Thickness of the walls over the chord."""


@dataclass(frozen=True, eq=False)
class BareShape:
    """A blade without webs, a `turbine_fenicsx.meshing.hollow_shape.HollowShape`.

    Args:
        blade: The blade whose surface it has.
    """

    blade: WindIOBlade

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""
        return self.blade.hub_radius

    @property
    def length(self) -> float:
        """Length of the reference axis [m]."""
        return self.blade.length

    @property
    def breaks(self) -> tuple[float, ...]:
        """Nothing begins or ends along the span."""
        return (0.0, 1.0)

    @property
    def panels(self) -> tuple[str, ...]:
        """Names of the panels around a section."""
        return (FACE_NAME, *SIDES, FACE_NAME)

    @property
    def webs(self) -> tuple[Web, ...]:
        """None."""
        return ()

    @property
    def closed_tip(self) -> bool:
        """The tip is open."""
        return False

    def lines(self, s: Array) -> Array:
        """Contour fractions that bound the panels at span fractions s, (m, 5) [-]."""
        corners, ends = self.blade.outer_shape.corners(s), np.zeros((2, len(s)))
        ends[1] = 1.0
        middle = self.blade.leading(s)
        return np.column_stack([ends[0], corners[:, 0], middle, corners[:, 1], ends[1]])

    def web_arcs(self, web: int, s: Array) -> Array:
        """There are no webs."""
        raise IndexError(web)

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the outer surface along a1, a2, a3, one axis more than the arguments [m]."""
        return self.blade.surface(s, a)

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall [m]."""
        s, _ = np.broadcast_arrays(np.asarray(s, float), np.asarray(a, float))
        return WALL * self.blade.outer_shape.chord.smooth(s)

    def web_wall(self, web: int, s: Array) -> Array:
        """There are no webs."""
        raise IndexError(web)

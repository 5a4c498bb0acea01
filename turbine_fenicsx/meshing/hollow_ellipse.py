"""A hollow blade with elliptic sections as a shape that can be meshed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.blade import BladeGeometry
from turbine_fenicsx.meshing.hollow_shape import Web


@dataclass(frozen=True)
class EllipticShape:
    """Tapered, twisted ellipses without webs, a `turbine_fenicsx.meshing.hollow_shape.HollowShape`.

    The contour fraction is the angle about the middle of the section over a full turn, in a circle
    that is stretched to the ellipse.

    Args:
        geometry: The blade; a mesher of hollow ones needs its wall.
    """

    geometry: BladeGeometry

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""
        return self.geometry.hub_radius

    @property
    def length(self) -> float:
        """Length of the span [m]."""
        return self.geometry.length

    @property
    def closed_tip(self) -> bool:
        """True."""
        return True

    @property
    def breaks(self) -> tuple[float, ...]:
        """Stations with kinks."""
        return self.geometry.kinks

    @property
    def panels(self) -> tuple[str, ...]:
        """Both sides."""
        return "suction side", "pressure side"

    @property
    def webs(self) -> tuple[Web, ...]:
        """None."""
        return ()

    def lines(self, s: Array) -> Array:
        """Trailing edge, leading edge, trailing edge, shape (m, 3) [-]."""
        return np.tile([0.0, 0.5, 1.0], (len(s), 1))

    def leading(self, s: Array) -> Array:
        """Contour fraction of the leading edge, shape (m,) [-]."""
        return np.full(len(s), 0.5)

    def web_arcs(self, web: int, s: Array) -> Array:
        """There are no webs."""
        raise IndexError(web)

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the ellipses, one axis more than the arguments [m]."""
        s, a = np.broadcast_arrays(s, a)
        g, angle = self.geometry, 2.0 * np.pi * a
        x = g.hub_radius + g.length * s
        across = -0.5 * g.chord_at(s) * np.cos(angle)
        through = 0.5 * g.thickness_at(s) * np.sin(angle)
        return g.turn(np.stack([x, across, through], axis=-1))

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall [m]."""
        return self.geometry.wall_at(np.broadcast_arrays(s, a)[0])

    def web_wall(self, web: int, s: Array) -> Array:
        """There are no webs."""
        raise IndexError(web)

"""The skin of a beam without a file of its outer shape: ellipses around its axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.hollow_shape import EllipticShape
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.turbine.blades.bare_shape import WALL


@dataclass(frozen=True)
class BeamSkin(EllipticShape):
    """Ellipses whose axes are the directors of a beam, with thin walls that only carry nodes.

    Args:
        line: Axis from the rotor centre along a1, a2, a3; directors to the suction side and to the
            trailing edge.
    """

    line: BeamLine

    @property
    def closed_tip(self) -> bool:
        """The tip is open."""
        return False

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the ellipses, one axis more than the arguments [m]."""
        s, a = np.broadcast_arrays(s, a)
        g, angle = self.geometry, 2.0 * np.pi * a
        to_trailing = 0.5 * g.chord_at(s) * np.cos(angle)
        to_suction = 0.5 * g.thickness_at(s) * np.sin(angle)
        at, place = np.unique(s, return_inverse=True)
        r, d = (x[place.reshape(s.shape)] for x in self.line.at(at * self.line.length))
        along = np.stack([to_suction, to_trailing], axis=-1)
        return np.asarray(r + np.einsum("...a,...ai->...i", along, d))

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall [m]."""
        g, s = self.geometry, np.broadcast_arrays(s, a)[0]
        return np.asarray(WALL * np.minimum(g.chord_at(s), g.thickness_at(s)))

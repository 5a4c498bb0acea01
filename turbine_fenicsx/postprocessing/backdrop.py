"""Background of pictures: the ground, a plain tower, and how far both reach.

A turbine without a tower gets a pale one, so that the picture shows a wind turbine, and every
turbine gets a piece of ground. Other models are shown as they are.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.postprocessing.camera import Frame
from turbine_fenicsx.postprocessing.field_reader import FieldReader
from turbine_fenicsx.records.conventions import HUB, NACELLE, TOWER
from turbine_fenicsx.records.parts import Parts

_ABOVE_GROUND = 1.45
"""Height of the hub of a turbine without a tower, in radii of the rotor."""


class Backdrop:
    """Ghost tower and ground of a turbine; of other models only how far they reach.

    Args:
        parts: The parts of the model; a turbine has a hub and a nacelle.
    """

    def __init__(self, parts: Parts) -> None:
        names = {part.name for part in parts.parts}
        self._turbine, self._tower = {HUB, NACELLE} <= names, TOWER in names
        self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)
        self._radius, self._side = 0.0, 1.0

    def include(self, grid: Any, reader: FieldReader) -> None:
        """Make room for a grid."""
        points = np.asarray(grid.points, dtype=float)
        self._low = np.minimum(self._low, points.min(axis=0))
        self._high = np.maximum(self._high, points.max(axis=0))
        if self._turbine and not self._radius:
            hub, nacelle = (_middle(reader.bounds(grid, name) or ()) for name in (HUB, NACELLE))
            upper = points[points[:, 1] >= hub[1]]
            self._radius = float(np.linalg.norm(upper - hub, axis=1).max())
            self._side = 1.0 if hub[2] >= nacelle[2] else -1.0
            self._hub = hub

    def frame(self) -> Frame:
        """Points that must be in the picture: all that was included, and the circle of a rotor."""
        low, high = self._low.copy(), self._high.copy()
        if self._turbine:
            reach = self._radius * np.array([1.0, 1.0, 0.0])
            low, high = np.minimum(low, self._hub - reach), np.maximum(high, self._hub + reach)
            if not self._tower:
                low[1] = self._find_ground()
        return Frame(low, high, self._side)

    def add_to(self, plotter: Any, nacelle: Sequence[float] | None) -> None:
        """Add tower and ground of a turbine.

        Args:
            nacelle: Present bounds of the nacelle [m].
        """
        if not self._turbine or nacelle is None:
            return
        import pyvista

        x, y, z = _middle(nacelle)
        ground = self._low[1] if self._tower else self._find_ground()
        if not self._tower:
            tower = _make_cone((x, y, z), ground, self._radius)
            plotter.add_mesh(tower, color="#e3e8ee", ambient=0.35, smooth_shading=True)
        disc = pyvista.Disc(
            center=(0.0, ground, 0.0),
            inner=0.0,
            outer=0.55 * self._radius,
            normal=(0.0, 1.0, 0.0),
            c_res=128,
        )
        plotter.add_mesh(disc, color="#e6ebe2", ambient=0.9, diffuse=0.1)

    def _find_ground(self) -> float:
        """Height of the ground of a turbine without a tower [m]."""
        return float(self._hub[1] - _ABOVE_GROUND * self._radius)


def _middle(bounds: Sequence[float]) -> NDArray[np.float64]:
    """Centre of bounds (x_min, x_max, y_min, ...), shape (3,)."""
    middle: NDArray[np.float64] = np.asarray(bounds, dtype=float).reshape(3, 2).mean(axis=1)
    return middle


def _make_cone(top: Sequence[float], ground: float, radius: float) -> Any:
    """Tower from ``top`` [m] down to the ground, in proportion to the radius of the rotor [m]."""
    import pyvista

    angle, depth = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 65), np.linspace(0.0, 1.0, 2))
    thickness = (0.03 + 0.02 * depth) * radius
    return pyvista.StructuredGrid(
        top[0] + thickness * np.cos(angle),
        top[1] + (ground - top[1]) * depth,
        top[2] + thickness * np.sin(angle),
    )

"""The wind near a tower: potential flow around a cylinder, and the wake behind it.

With x along the wind and y across it from the axis of the tower, both in units of its radius, and
r^2 = x^2 + y^2, the wind across the tower, of speed V, changes by

    u/V = (y^2 - x^2)/r^4 - C_d/sqrt(r) cos^2(pi/2 y/sqrt(r)),    v/V = -2 x y/r^4,

the first the doublet of potential flow, the second the wake after S. R. J. Powles ("The effects of
tower shadow on the dynamics of a horizontal-axis wind turbine", Wind Engineering 7, 1983), where
x > 0 and |y| < sqrt(r), at most half of the wind. Beyond the ends of the tower both fade over one
radius by x/c and y/c with c = cos(pi/2 z), z the distance from the end in radii. All of this is as
in AeroDyn (its documentation, section "Tower influence models").
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.argument_checks import check_array, check_not_negative
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import frame_with_axis
from turbine_fenicsx.foundation.types import Array

DEEPEST = 0.5
"""Maximum share of the wind that the wake takes [-]."""


@dataclass(frozen=True, eq=False)
class TowerShadow:
    """A straight tower that stands still.

    Args:
        base: Lower end of its axis, shape (3,) [m].
        top: Upper end, shape (3,) [m].
        heights: Stations above the base along the axis, rising, shape (k,) [m].
        radii: Radii there, shape (k,) [m].
        potential: Whether the wind gives way to the tower.
        drag: C_d of the tower, for the wake; 0 for none [-].
    """

    base: npt.ArrayLike
    top: npt.ArrayLike
    heights: npt.ArrayLike
    radii: npt.ArrayLike
    potential: bool = True
    drag: float = 0.0

    def __post_init__(self) -> None:
        for what in ("base", "top"):
            check_array(f"{what} of the tower", getattr(self, what), (3,), "three numbers")
        heights, radii = self._profile
        if not len(heights) or not np.all(np.diff(heights) > 0.0):
            raise ModelError(f"heights of the tower must rise, got {self.heights!r}")
        if not np.all(radii > 0.0):
            raise ModelError(f"radii of the tower must be positive, got {radii.min():g} m")
        check_not_negative("drag of the tower", self.drag)
        if not np.linalg.norm(np.subtract(self.top, self.base)) > 0.0:
            raise ModelError("base and top of the tower must be two points")

    @cached_property
    def _frame(self) -> tuple[Array, float]:
        """Two directions across the axis and its own as rows, and its length."""
        axis = np.subtract(self.top, self.base).astype(float)
        return frame_with_axis(axis).T, float(np.linalg.norm(axis))

    @cached_property
    def _profile(self) -> tuple[Array, Array]:
        """Heights and radii."""
        n = (np.size(self.heights),)
        heights = check_array("heights of the tower", self.heights, n, "a list of numbers")
        words = f"{n[0]} numbers, one for each height"
        return heights, check_array("radii of the tower", self.radii, n, words)

    def disturb(self, wind: Array, position: Array) -> Array:
        """The wind with the tower in it.

        Args:
            wind: Without it, shape (n, 3) [m/s].
            position: Places, shape (n, 3) [m].

        Returns:
            Shape (n, 3); inside of the tower that at its surface [m/s].
        """
        E, length = self._frame
        p_1, p_2, s = E @ (position - np.asarray(self.base, dtype=float)).T
        w_1, w_2 = E[:2] @ wind.T
        nearest = np.minimum(np.maximum(s, 0.0), length)
        radius = np.interp(nearest, *self._profile)
        z = np.abs(s - nearest) / radius
        # x and y of the place in radii; c keeps them finite where both effects have ended
        V = np.maximum(np.hypot(w_1, w_2), 1e-9)
        scale = 1.0 / (radius * V * np.maximum(np.cos(0.5 * np.pi * np.minimum(z, 1.0)), 1e-6))
        x, y = scale * (p_1 * w_1 + p_2 * w_2), scale * (p_2 * w_1 - p_1 * w_2)
        inside = 1.0 / np.minimum(np.maximum(np.hypot(x, y), 1e-9), 1.0)
        u, v = self._find_changes(x * inside, y * inside) * (z < 1.0)
        change = np.array([u * w_1 - v * w_2, u * w_2 + v * w_1])
        return np.asarray(wind + change.T @ E[:2])

    def _find_changes(self, x: Array, y: Array) -> Array:
        """u/V and v/V at places outside of the tower, in its radii, shape (2, n) [-]."""
        change = np.zeros((2, len(x)))
        x_2, y_2 = x * x, y * y
        r_2 = np.maximum(x_2 + y_2, 1.0)
        if self.potential:
            r_4 = r_2 * r_2
            change[0] = (y_2 - x_2) / r_4
            change[1] = -2.0 * x * y / r_4
        if self.drag > 0.0:
            width = np.sqrt(np.sqrt(r_2))
            wake = self.drag / width * np.cos(0.5 * np.pi / width * y) ** 2
            behind = (x > 0.0) & (np.abs(y) < width)
            change[0] -= np.minimum(wake, DEEPEST) * behind
        return change

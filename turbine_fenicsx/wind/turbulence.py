"""Frozen turbulence on a grid, moved through the rotor by the mean wind.

Taylor's hypothesis: the field is frozen and moves with the mean wind at the hub, so that time in
the file is time at x = 0 and earlier at places downwind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.inflow import FASTEST

MAX_BYTES = 2**32
"""Larger fields than 4 GiB are refused before they are read."""

SPACING = (1e-3, 1e5, "m")
"""Least and largest distance of the points of a field that is not damaged, and its unit."""

PLAUSIBLE = {
    "dz": SPACING,
    "dy": SPACING,
    "dt": (1e-6, 1e6, "s"),
    "u_hub": (1e-2, FASTEST, "m/s"),
    "z_hub": (0.0, 1e4, "m"),
    "z_bottom": (-1e4, 1e4, "m"),
}
"""The same for the other numbers of a field, under TurbSim's names."""


@dataclass(frozen=True, eq=False)
class TurbulenceField:
    """Velocities on a grid of times and places of a plane across the wind.

    Attributes:
        values: Numbers as in the file, shape (times, heights, widths, 3), along x, y, z.
        slope: Velocities are (values - intercept)/slope, shape (3,) [s/m].
        intercept: Shape (3,) [-].
        dt: Time between two planes [s].
        y: Widths, rising, symmetric to the hub, shape (n_y,) [m].
        z: Heights above ground, rising, shape (n_z,) [m].
        speed: Mean wind at the hub, with which the field moves [m/s].
        periodic: Whether the first plane follows the last.
        lead: Time in the field at x = 0 and t = 0 [s].
    """

    values: npt.NDArray[np.int16 | np.float32]
    slope: Array
    intercept: Array
    dt: float
    y: Array
    z: Array
    speed: float
    periodic: bool
    lead: float = 0.0

    @property
    def duration(self) -> float:
        """Time after which the field repeats itself or ends [s]."""
        n = len(self.values)
        return (n if self.periodic else n - 1) * self.dt

    def list_mistakes(self, end: float, centre: Array, radius: float) -> list[str]:
        """Mistakes of the field as the wind of a run, one sentence each.

        Args:
            end: End of the run [s].
            centre: Centre of the rotor, x downwind of the tower, z above ground, shape (3,) [m].
            radius: Of the swept area [m].
        """
        mistakes = []
        lacking = end + self.lead - (centre[0] - radius) / self.speed - self.duration
        if not self.periodic and lacking > 0.0:
            mistakes.append(
                f"the wind field lasts {self.duration:g} s, {lacking:.6g} s less than the run with "
                "the depth of the rotor needs"
            )
        low, high = centre[2] - radius, centre[2] + radius
        if low < self.z[0] or high > self.z[-1]:
            mistakes.append(
                f"the wind field goes from {self.z[0]:g} to {self.z[-1]:g} m above ground, the "
                f"rotor from {low:g} to {high:g} m"
            )
        if radius + abs(centre[1]) > self.y[-1]:
            mistakes.append(
                f"the wind field is {2.0 * self.y[-1]:g} m wide, the rotor {2.0 * radius:g} m"
            )
        return mistakes

    def velocity(self, position: Array, time: float) -> Array:
        """As `Inflow.velocity`, linear between the points of the grid.

        Above the grid and beside it the wind is that of its edge. Below, it falls to zero at the
        ground.
        """
        places = np.asarray(position, dtype=float)
        x, y, z = places.reshape(-1, 3).T
        s = (time + self.lead - x / self.speed) / self.dt
        n = len(self.values)
        if self.periodic:
            s = np.mod(s, n)
        elif s.size and (s.min() < 0.0 or s.max() > n - 1):
            raise InputError(
                f"the wind field lasts from {-self.lead:g} to {self.duration - self.lead:g} s; "
                f"at {time:g} s the turbine needs it from {s.min() * self.dt - self.lead:.4g} to "
                f"{s.max() * self.dt - self.lead:.4g} s"
            )
        i = np.minimum(np.maximum(s.astype(int), 0), n - 1)
        after = (i + 1) % n if self.periodic else np.minimum(i + 1, n - 1)
        j, v = _locate(z, self.z)
        k, u = _locate(y, self.y)
        # weights and numbers of the eight corners, along two axes each: planes, heights, widths
        w, v, u = (np.array([1.0 - part, part]) for part in (s - i, v, u))
        weights = w[:, None, None] * (v[:, None] * u)
        height, width = len(self.z), len(self.y)
        corner = np.array([i, after]) * (height * width) + (j * width + k)
        corner = corner[:, None] + np.array([[0], [1], [width], [width + 1]])
        corners = self.values.reshape(-1, 3).take(corner.reshape(8, -1), axis=0)
        found = np.einsum("cn,cni->ni", weights.reshape(8, -1), corners.astype(float))
        found = (found - self.intercept) / self.slope
        if self.z[0] > 0.0:
            found *= np.minimum(np.maximum(z / self.z[0], 0.0), 1.0)[:, None]
        return np.asarray(found.reshape(places.shape))


def _locate(places: Array, grid: Array) -> tuple[Array, Array]:
    """Interval of an equally spaced grid that holds each place, and the part of it before."""
    first, second = grid[:2].tolist()
    s = (places - first) / (second - first)
    s = np.minimum(np.maximum(s, 0.0), len(grid) - 1.0)
    index = np.minimum(np.maximum(s.astype(int), 0), len(grid) - 2)  # of nan, too
    return index, s - index

"""Lift, drag and moment of aerofoils at every angle of attack, linear between table values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array

FULL_CIRCLE = 1e-3
"""Maximum distance of the first and last angle from -pi and pi; tables end at 179.99 degrees, and
coefficients are straight on from there [rad]."""

SAME_ENDS = 1e-2
"""How far coefficients at -pi and pi may differ: it is one angle. Those of the thick airfoils of
the IEA 22 MW turbine differ by 5e-3."""

MAX_COEFFICIENT = 100.0
"""No aerofoil has larger coefficients [-]."""

MAX_ATTACHED = np.radians(20.0)
"""Maximum distance from the angle without lift at which the flow may be attached [rad]."""

SMALL_ANGLE = 1e-6
"""Minimum distance from the angle without lift at which lift has a direction [rad]."""


@dataclass(frozen=True, eq=False)
class Polar:
    """Coefficients of an aerofoil from -pi to pi.

    Args:
        name: For messages.
        angle: Angles of attack, rising from -pi to pi, shape (n,) [rad].
        lift: Lift coefficients C_l, shape (n,) [-].
        drag: Drag coefficients C_d, shape (n,) [-].
        moment: Moment coefficients C_m about the aerodynamic centre, positive nose up,
            shape (n,) [-].

    Raises:
        ModelError: if the table does not close the circle, angles do not rise, numbers are not
            finite or too large, or their counts differ.
    """

    name: str
    angle: Array
    lift: Array
    drag: Array
    moment: Array

    def __post_init__(self) -> None:
        n = len(self.angle)
        for what in ("lift", "drag", "moment"):
            values = getattr(self, what)
            if np.shape(values) != (n,):
                raise ModelError(
                    f"polar {self.name!r} has {n} angles and values of {what} of shape "
                    f"{np.shape(values)}"
                )
            if not np.all(np.isfinite(values)):
                raise ModelError(f"polar {self.name!r} has values of {what} that are not finite")
            largest = np.max(np.abs(values), initial=0.0)
            if largest > MAX_COEFFICIENT:
                raise ModelError(
                    f"{what} of polar {self.name!r} reaches {largest:g}, more than "
                    f"{MAX_COEFFICIENT:g}"
                )
        if n < 2 or not np.all(np.diff(self.angle) > 0.0):
            raise ModelError(f"angles of polar {self.name!r} must rise from -180 to 180 degrees")
        if (
            np.max(np.abs(np.array([self.angle[0], self.angle[-1]]) - [-np.pi, np.pi]))
            > FULL_CIRCLE
        ):
            first, last = np.degrees(self.angle[[0, -1]])
            raise ModelError(
                f"polar {self.name!r} must go from -180 to 180 degrees, got {first:g} to {last:g}"
            )
        for what in ("lift", "drag", "moment"):
            first, last = getattr(self, what)[[0, -1]]
            if abs(first - last) > SAME_ENDS:
                raise ModelError(
                    f"{what} of polar {self.name!r} must be the same at -180 and 180 degrees, got "
                    f"{first:g} and {last:g}"
                )

    def coefficients(self, angle: Array) -> Array:
        """C_l, C_d and C_m at angles within (-pi, pi), along a new first axis, shape (3, ...)."""
        tables = (self.lift, self.drag, self.moment)
        return np.stack([np.interp(angle, self.angle, values) for values in tables])


class Coefficients(NamedTuple):
    """Coefficients of all stations, each of the shape of the angles [-]."""

    lift: Array
    drag: Array
    moment: Array


class AngleTable:
    """Values over the angle of attack, for each station those of its row, linear in between.

    Args:
        angles: Rising, shape (m,) [rad].
        values: Shape (k, m, c).
        rows: Which of the k each station has, shape (stations,).

    Attributes:
        columns: c.
        starts: Where intervals start, shape (m - 1,) [rad].
        widths: Their widths, shape (m - 1,) [rad].
        first: Row of the first interval of each station in what follows, shape (stations,).
        lower: Values at the starts of intervals, shape (k (m - 1), c).
        change: Their changes over the intervals, of the same shape.
    """

    def __init__(self, angles: Array, values: Array, rows: npt.NDArray[np.intp]) -> None:
        m, self.columns = values.shape[1:]
        self.starts, self._inner = angles[:-1], angles[1:-1]
        self.widths = np.diff(angles)
        self.first = rows * (m - 1)
        # what is at the start of an interval of a row, and how it changes over the interval
        self.lower = values[:, :-1].reshape(-1, self.columns)
        self.change = np.diff(values, axis=1).reshape(-1, self.columns)

    def __call__(self, angle: Array) -> Array:
        """Values at angles within those of the table.

        Args:
            angle: Shape (..., stations) [rad].

        Returns:
            Shape (..., stations, c).
        """
        i = self._inner.searchsorted(angle, side="right")
        weight = (angle - self.starts.take(i)) / self.widths.take(i)
        i = i + self.first
        found = self.change.take(i, axis=0)
        found *= weight[..., None]
        found += self.lower.take(i, axis=0)
        return found


class PolarTable:
    """Polars of the stations of a blade, looked up together.

    Attributes:
        angles: Those of all polars together, shape (m,) [rad].
        values: C_l, C_d and C_m of the polars that differ, shape (k, m, 3) [-].
        rows: Which of these each station has, shape (stations,).
    """

    def __init__(self, polars: Sequence[Polar]) -> None:
        distinct = list({id(p): p for p in polars}.values())
        # all tables on the angles of all of them: what is linear stays as it is
        self.angles = np.unique(np.concatenate([p.angle for p in distinct]))
        self.values = np.stack([p.coefficients(self.angles).T for p in distinct])
        places = {id(p): k for k, p in enumerate(distinct)}
        self.rows = np.array([places[id(p)] for p in polars])
        self._table = self.tabulate(self.values)

    def __call__(self, angle: Array) -> Coefficients:
        """Coefficients at angles of attack.

        Args:
            angle: Any angles, shape (..., stations) [rad].
        """
        C = self._table(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)
        return Coefficients(C[..., 0], C[..., 1], C[..., 2])

    def tabulate(self, values: Array, blades: int = 1) -> AngleTable:
        """A table of values over the same angles, shape (k, m, c), for the stations of blades."""
        return AngleTable(self.angles, values, np.tile(self.rows, blades))


def measure_from(alpha_0: float, angle: Array) -> Array:
    """Angles from one of them on, within [-pi, pi)."""
    x: Array = np.mod(angle - alpha_0 + np.pi, 2.0 * np.pi) - np.pi
    return x


def find_plate_share(table: PolarTable) -> Array:
    """Lift slope of stations as a part of that of a flat plate, sigma, shape (stations,) [-].

    Returns:
        C_l,alpha/(2 pi), at most one; 0 for a cylinder.
    """
    found = [find_lift_slope(table.angles, lift) for lift in table.values[:, :, 0]]
    slopes = np.array([0.0 if x is None else x[1] for x in found])[table.rows]
    return np.asarray(np.minimum(slopes / (2.0 * np.pi), 1.0))


def find_lift_slope(angle: Array, lift: Array) -> tuple[float, float] | None:
    """The angle without lift alpha_0 [rad], and the slope C_l,alpha of attached flow [1/rad].

    Args:
        angle: Angles of attack, rising from -pi to pi, shape (m,) [rad].
        lift: C_l, shape (m,) [-].

    Returns:
        The largest C_l/sin(alpha - alpha_0) as the slope; None if lift does not rise through zero
        near the angle zero, as that of a cylinder.
    """
    rising = np.flatnonzero((lift[:-1] <= 0.0) & (lift[1:] > 0.0))
    width = angle[rising + 1] - angle[rising]
    zeros = angle[rising] - lift[rising] * width / (lift[rising + 1] - lift[rising])
    zeros = zeros[np.abs(zeros) <= MAX_ATTACHED]
    if not len(zeros):
        return None
    alpha_0 = float(zeros[np.argmin(np.abs(zeros))])
    x = measure_from(alpha_0, angle)
    near = (np.abs(x) <= MAX_ATTACHED) & (np.abs(x) > SMALL_ANGLE)
    return alpha_0, float(np.max(lift[near] / np.sin(x[near]), initial=0.0))

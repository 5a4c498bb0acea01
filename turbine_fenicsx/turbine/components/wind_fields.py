"""Loads of the air on the blades as vectors, and the wind on a plane, for ParaView."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from turbine_fenicsx.forces.line_source import StepLoads
from turbine_fenicsx.foundation.rotations import E1, E2
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.records.field_files import open_series
from turbine_fenicsx.records.grid_series import GridSeries
from turbine_fenicsx.simulation.observers.field_series import FieldSeries
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.wind.aero_blade import AeroBlade

PLANE = 0
"""Part of the plane; those of the blades are their numbers."""

POINTS = 21
"""Points along each side of the plane."""

WIDTH = 1.2
"""Half width of the plane in radii of the rotor."""

CLEARANCE = 1.0
"""The plane ends so far above the ground [m]."""


class WindFields(FieldSeries):
    """Writes a line of stations for each blade, and an upright plane at the hub: ``wind.xdmf``.

    Stations are where they are at the time; their loads are those of the step that ends there.

    Args:
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].
        find_loads: Loads on the stations in the step that led to a state; called on all ranks.
    """

    def __init__(
        self,
        turbine: Turbine,
        path: str | os.PathLike[str],
        every: float,
        end: float,
        find_loads: Callable[[State], StepLoads],
        blade: AeroBlade,
    ) -> None:
        super().__init__(path, every, end)
        assert turbine.inflow is not None
        self._comm, self._inflow, self._find_loads = turbine.comm, turbine.inflow, find_loads
        self._blades, self._n = turbine.rotor.layout.n_blades, len(blade.radius)
        self._lengths = np.tile(blade.parts, self._blades)[:, None]
        centre = np.asarray(turbine.rotor.layout.centre, dtype=float)
        self._plane = _make_plane(centre, WIDTH * blade.tip_radius, turbine.case.hub_height)

    def open(self, path: Path, append: float | None, room: int) -> GridSeries:
        """Open the series; all points are rank 0's."""
        first, here = self._blades * self._n, self._comm.rank == 0
        stations = np.arange(first).reshape(self._blades, self._n)
        lines = np.stack([stations[:, :-1], stations[:, 1:]], axis=2).reshape(-1, 2)
        cells = [("line", lines), ("quadrilateral", first + _make_squares())]
        numbers = np.repeat(np.arange(1, self._blades + 1), self._n - 1)
        part = np.concatenate([numbers, np.full((POINTS - 1) ** 2, PLANE)])
        return open_series(
            self._comm,
            path,
            cells=cells if here else [],
            n_points=first + POINTS**2 if here else 0,
            room=room,
            cell_data={"part": part if here else part[:0]},
            append=append,
        )

    def write(self, series: GridSeries, state: State) -> None:
        """Write line loads and wind."""
        motion, F, _, times = self._find_loads(state)
        since = 0.5 * times.dt if np.isfinite(times.dt) else 0.0  # from the middle of the step
        points = np.concatenate([motion.position + since * motion.velocity, self._plane])
        force = np.concatenate([F / self._lengths, np.zeros_like(self._plane)])
        wind = self._inflow.velocity(points, state.time)
        here = slice(None if self._comm.rank == 0 else 0)
        fields = {"force_per_length": force[here], "wind": wind[here]}
        series.write(state.time, points[here], point_data=fields)


def _make_plane(centre: Array, half: float, height: float) -> Array:
    """Points across the wind around a centre at a height above ground, row by row, (n, 3) [m]."""
    side = np.linspace(-half, half, POINTS)
    up = np.linspace(max(-half, CLEARANCE - height), half, POINTS)
    return np.asarray((centre + up[:, None, None] * E2 + side[None, :, None] * E1).reshape(-1, 3))


def _make_squares() -> IntArray:
    """Vertices of the squares of a plane, counted from its first point."""
    n = np.arange(POINTS**2).reshape(POINTS, POINTS)
    corners = (n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1])
    return np.asarray(np.stack(corners, axis=2).reshape(-1, 4))

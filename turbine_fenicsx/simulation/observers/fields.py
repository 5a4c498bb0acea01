"""Field output: all flexible bodies and the surfaces of rigid ones in one moving grid."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.grid_series import GridSeries
from turbine_fenicsx.simulation.observers.cell_values import CellValues, gather_values
from turbine_fenicsx.simulation.observers.field_grid import FieldGrid
from turbine_fenicsx.simulation.observers.field_series import FieldSeries
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

MOTIONS = ("displacement", "velocity")
"""Fields that bodies without a material have too."""

STRESSES = ("cauchy_stress_norm", "von_mises_stress")
"""Fields of stress."""


def list_fields(more: Sequence[CellValues] = ()) -> list[str]:
    """Names of the fields that change, of all kinds of bodies and of more fields in the cells."""
    return list(dict.fromkeys([*MOTIONS, *STRESSES, "fibre", *(f.name for f in more)]))


class Fields(FieldSeries):
    """Writes displacement, velocity, Cauchy stress and fibre direction, usually ``fields.xdmf``.

    Points are the vertices at their current positions; stresses are those of the cell centres.

    Args:
        system: The system.
        path: The file: ``.xdmf`` or ``.vtkhdf``.
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].
        surfaces: Surfaces of rigid bodies, written by rank 0; if None, each is drawn as the
            homogeneous box of its mass and Euler values.
        parts: Number of the part of each local cell (ghosts included), one array per flexible
            body; if None, each body is one part, with the next free numbers.
        names: Names of the numbered parts that are not called like their bodies.
        more: More fields in the cells.
        wanted: Names of the fields, some of `list_fields`; None for all.

    Attributes:
        name: Name of the file, under which checkpoints know it.

    Raises:
        ModelError: if there is not one array of parts for each flexible body, or a field belongs to
            a body of another system, or there is none of a wanted name.
    """

    def __init__(
        self,
        system: MultibodySystem,
        path: str | os.PathLike[str],
        every: float,
        end: float,
        surfaces: Sequence[RigidSurface] | None = None,
        parts: Sequence[Array] | None = None,
        names: Mapping[int, str] | None = None,
        more: Sequence[CellValues] = (),
        wanted: Collection[str] | None = None,
    ) -> None:
        for field in more:
            check_among_parts("flexible body", field.body, system.flexible_bodies, field.name)
        known = list_fields(more)
        unknown = [name for name in wanted or () if name not in known]
        if unknown:
            raise ModelError(f"there is no field {unknown[0]!r}, but {', '.join(known)}")
        self._wanted = set(known if wanted is None else wanted)
        self._more = tuple(field for field in more if field.name in self._wanted)
        super().__init__(path, every, end)
        self._grid = FieldGrid(system, surfaces, parts, names)
        self._bodies = tuple((grid.body, grid.n_cells) for grid in self._grid.bodies)

    def open(self, path: Path, append: float | None, room: int) -> GridSeries:
        """Open the series on the grid of all parts."""
        return self._grid.open(path, append, room=room)

    def write(self, series: GridSeries, state: State) -> None:
        """Write all fields that are wanted."""
        grid, wanted = self._grid, self._wanted
        displacement = grid.displacement(state.q, state.u)
        of_points = {"displacement": displacement}
        if "velocity" in wanted:
            of_points["velocity"] = grid.motion(state.q_dot, state.v)
        of_cells: dict[str, Array] = {}
        if wanted & set(STRESSES):
            stresses = [body.stresses(state.u[body.number]) for body in grid.bodies]
            for k, name in enumerate(STRESSES):
                of_cells[name] = np.concatenate([np.zeros(0), *(values[k] for values in stresses)])
        if "fibre" in wanted:
            fibres = [body.fibre(state.u[body.number]) for body in grid.bodies]
            of_cells["fibre"] = np.concatenate([np.zeros((0, 3)), *fibres])
        of_cells |= gather_values(self._more, self._bodies, state)
        series.write(
            state.time,
            grid.positions + displacement,
            point_data=of_points,
            cell_data={
                name: np.concatenate([values, np.zeros((grid.n_faces, *values.shape[1:]))])
                for name, values in of_cells.items()
                if name in wanted
            },
        )

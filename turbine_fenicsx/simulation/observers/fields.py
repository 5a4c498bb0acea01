"""Field output: all flexible bodies and the surfaces of rigid ones in one moving grid."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from turbine_fenicsx.bodies.rigid_surface import RigidSurface
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.xdmf import XdmfSeries
from turbine_fenicsx.simulation.observers.cell_values import CellValues, gather_values
from turbine_fenicsx.simulation.observers.field_grid import FieldGrid
from turbine_fenicsx.simulation.observers.field_series import FieldSeries
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


class Fields(FieldSeries):
    """Writes ``fields.xdmf``: displacement, velocity, Cauchy stress and fibre direction.

    Points are the vertices at their current positions; stresses are those of the cell centres.

    Args:
        system: The system.
        path: The XDMF file.
        every: Simulated time between two outputs [s], positive; the end is always written.
        end: End time [s].
        surfaces: Surfaces of rigid bodies, written by rank 0; if None, each is drawn as the
            homogeneous box of its mass and Euler values.
        parts: Number of the part of each local cell (ghosts included), one array per flexible
            body; if None, each body is one part, with the next free numbers.
        names: Names of the numbered parts that are not called like their bodies.
        more: More fields in the cells.

    Attributes:
        name: Name of the XDMF file, under which checkpoints know it.

    Raises:
        ModelError: if there is not one array of parts for each flexible body, or a field belongs to
            a body of another system.
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
    ) -> None:
        for field in more:
            check_among_parts("flexible body", field.body, system.flexible_bodies, field.name)
        self._more = tuple(more)
        super().__init__(path, every, end)
        self._grid = FieldGrid(system, surfaces, parts, names)
        self._bodies = tuple((grid.body, grid.n_cells) for grid in self._grid.bodies)

    def _open(self, path: Path, append: float | None) -> XdmfSeries:
        """Open the series on the grid of all parts."""
        return self._grid.open(path, append=append)

    def _write(self, series: XdmfSeries, state: State) -> None:
        """Write all fields."""
        grid = self._grid
        displacement = grid.displacement(state.q, state.u)
        norm, von_mises, fibre = [], [], []
        for body, u in zip(grid.bodies, state.u, strict=True):
            stress = body.stresses(u)
            norm.append(stress[0])
            von_mises.append(stress[1])
            fibre.append(body.fibre(u))
        for values in (norm, von_mises):
            values.append(np.zeros(grid.n_faces))
        fibre.append(np.zeros((grid.n_faces, 3)))
        more = gather_values(self._more, self._bodies, state)
        series.write(
            state.time,
            grid.positions + displacement,
            point_data={
                "displacement": displacement,
                "velocity": grid.motion(state.q_dot, state.v),
            },
            cell_data={
                "cauchy_stress_norm": np.concatenate(norm),
                "von_mises_stress": np.concatenate(von_mises),
                "fibre": np.concatenate(fibre),
                **{name: np.append(v, np.zeros(grid.n_faces)) for name, v in more.items()},
            },
        )

"""Failure indices of plies in the field output and in the time series."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.materials.ply_table import Criterion
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.cell_values import CellValues
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.ply_stresses import PlyStresses
from turbine_fenicsx.system.state import State


def failure_field(
    plies: PlyStresses, criterion: str = "tsai_wu", leave_out: IntArray | None = None
) -> CellValues:
    """The largest failure index of all plies of each cell, for `Fields`.

    Args:
        plies: Plies of a body.
        criterion: One of `turbine_fenicsx.materials.ply_failure.CRITERIA`; the field has its name.
        leave_out: Numbers of cells that this rank owns whose index is written as 0; None for none.

    Raises:
        ModelError: for another criterion.
    """
    index = _find_criterion(criterion)

    def values(state: State) -> Array:
        plies.update(state)
        found = plies.largest(index)[0]
        if leave_out is not None:
            found[leave_out] = 0.0
        return found

    return CellValues(criterion, plies.body, values)


def failure_channel(
    plies: PlyStresses,
    panels: Mapping[str, IntArray],
    place: Array,
    criteria: Sequence[str] = ("tsai_wu",),
) -> Channel:
    """Columns of the largest failure index in some panels, and of where it is.

    Args:
        plies: Plies of a body.
        panels: Numbers of the cells of each panel that this rank owns; the same names, in the same
            order, on all ranks.
        place: What is written for a cell where the index is largest, for example its distance from
            the root, shape (cells,) [m].
        criteria: Some of `turbine_fenicsx.materials.ply_failure.CRITERIA`.

    Raises:
        ModelError: for another criterion, for a panel without cells on any rank, or for cells that
            are not there.

    Note:
        Collective. All columns together cost about as much as one evaluation of the strain energy
        and ten operations per ply.
    """
    comm, indices = plies.body.mesh.comm, [_find_criterion(name) for name in criteria]
    n, error = len(plies.table.first), None
    if place.shape != (n,) or any(np.any((c < 0) | (c >= n)) for c in panels.values()):
        error = ModelError(
            f"panels and places of {plies.body.name!r} must be those of the {n} cells of this rank"
        )
    raise_together(comm, error)
    counts = np.sum(comm.allgather([len(cells) for cells in panels.values()]), axis=0)
    empty = [name for name, count in zip(panels, np.atleast_1d(counts), strict=True) if not count]
    if empty:
        raise ModelError(f"panel {empty[0]!r} of {plies.body.name!r} has no cells")

    def values(snapshot: Snapshot) -> list[float]:
        of_copies = []
        for copy in range(plies.copies):
            plies.update(snapshot.state, copy)
            of_copies.append([plies.largest(index)[0] for index in indices])
        of_cells = np.max(of_copies, axis=0)
        mine = [
            _largest(found[cells], place[cells]) for cells in panels.values() for found in of_cells
        ]
        every = comm.allgather(mine)
        return [number for one in zip(*every, strict=True) for number in max(one)]

    return Channel(
        tuple(
            column(panel=panel, criterion=criterion)
            for panel in panels
            for criterion in criteria
            for column in (names.PLY_INDEX, names.PLY_INDEX_AT)
        ),
        values,
    )


def _largest(indices: Array, place: Array) -> tuple[float, float]:
    """The largest index and its place; less than any index without cells."""
    if not len(indices):
        return -1.0, 0.0
    k = int(np.argmax(indices))
    return float(indices[k]), float(place[k])


def _find_criterion(name: str) -> Criterion:
    if name not in CRITERIA:
        raise ModelError(
            f"failure criterion of plies must be one of {', '.join(CRITERIA)}, got {name!r}"
        )
    return CRITERIA[name]

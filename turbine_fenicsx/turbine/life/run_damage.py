"""Damage of the plies of a blade by a recorded run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_damage import DamageCode, PlyDamage
from turbine_fenicsx.materials.ply_fatigue import MEASURES, FatigueTable, PlyFatigue
from turbine_fenicsx.records.motion_file import Motion
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery

NUMBERS = 2**22
"""Strains that are in memory at a time, some 32 MB; temporary ones need five times as much."""

ROWS = 512
"""Rows of a motion that are read together."""

FEWEST = 3
"""Rows of a motion below which there is no cycle."""


@dataclass(frozen=True, eq=False)
class HistoryBlock:
    """Some places, few enough for their stress at all times to be in memory.

    Args:
        find: Stress at both sides of the places for displacements of the vectors of a blade, from
            shape (n, m, 3) to (places, 2, 3, m) [Pa].
        fatigue: How they fail, two histories for each.
        places: Their numbers among all of this rank.
    """

    find: Callable[[Array], Array]
    fatigue: FatigueTable
    places: IntArray


class Histories(Protocol):
    """Places of blades whose stress is counted."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Blades, places of this rank, sides, stresses by `MEASURES`."""

    def split(self, rows: int) -> list[HistoryBlock]:
        """All places that count, in blocks for a number of rows."""


class PlyHistories:
    """Plies at their outer and inner faces.

    Cells that stand for no layup, and plies of materials that do not count, have none.

    Args:
        recovery: The plies.
        materials: How materials fail, by their names.
    """

    def __init__(self, recovery: PlyRecovery, materials: Mapping[str, PlyFatigue]) -> None:
        self._recovered, self._materials = recovery.recovered, materials
        table = self._recovered.table
        counts = [ply.material.name in materials for ply in table.plies]
        own = [x for x in recovery.plies.panels.values() if len(x)]
        cells = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *own]))
        counted = np.zeros(len(table.first), dtype=bool)
        counted[table.wall[np.flatnonzero(counts)]] = True
        self._cells = cells[counted[cells]]
        self.shape = (recovery.vectors.shape[1], len(table.plies), 2, len(MEASURES))

    def split(self, rows: int) -> list[HistoryBlock]:
        """Blocks of cells, see `HistoryBlock`."""
        table, blocks = self._recovered.table, []
        for part in list_slices(len(self._cells), rows):
            cells = self._cells[part]
            recovered = self._recovered.take(cells)
            numbers = np.concatenate([np.flatnonzero(table.wall == cell) for cell in cells])
            fatigue = FatigueTable(recovered.table, self._materials, 2)
            blocks.append(HistoryBlock(recovered.find_mean_stresses, fatigue, numbers))
        return blocks


def list_slices(n: int, rows: int) -> list[slice]:
    """Parts of n cells, small enough for their strains in all rows to be in memory."""
    size = max(1, NUMBERS // (24 * rows))
    return [slice(first, first + size) for first in range(0, n, size)]


class RunDamage:
    """Finds the damage of runs of one turbine. Making it is collective.

    Args:
        recovery: The plies, of one of the runs.
        kinds: Places of the blades, of all kinds.
    """

    def __init__(self, recovery: PlyRecovery, kinds: Sequence[Histories]) -> None:
        self._recovered, self._kinds = recovery.recovered, kinds
        self._code = DamageCode(recovery.run.turbine.comm)

    def find(
        self,
        motion: Motion,
        begin: float = 0.0,
        least: float = 0.0,
        progress: Callable[[float], None] = lambda part: None,
    ) -> list[PlyDamage]:
        """Damage of each kind of places by a run that happens once.

        Args:
            motion: Its motion.
            begin: Time before which nothing counts [s].
            least: Histories that surely do less damage are left out.
            progress: Called with the part that is done, from 0 to 1.

        Returns:
            Arrays of the shapes of the kinds.
        """
        rows = np.flatnonzero(motion.times >= begin)
        found = [np.zeros((3, *kind.shape)) for kind in self._kinds]
        blocks = [(k, x) for k, kind in enumerate(self._kinds) for x in kind.split(len(rows))]
        copies = motion.vectors[BODY].shape[1]
        for copy in range(copies):
            moved = self._move(motion, int(rows[0]), copy)
            for done, (k, block) in enumerate(blocks, start=1):
                stresses = block.find(moved)
                flat = stresses.reshape(-1, *stresses.shape[2:])
                values = self._code.find(block.fatigue, flat, least)
                for out, own in zip(found[k], _as_tuple(values), strict=True):
                    out[copy, block.places] = own.reshape(-1, *out.shape[2:])
                progress((copy + done / len(blocks)) / copies)
        return [PlyDamage(*values) for values in found]

    def _move(self, motion: Motion, first: int, copy: int) -> Array:
        """Displacements of the vectors of a blade from a row on, shape (n, rows, 3)."""
        vectors = motion.vectors[BODY]
        found = np.empty((vectors.shape[2], len(vectors) - first, 3))
        for row in range(first, len(vectors), ROWS):
            moved = self._recovered.move(vectors[row : row + ROWS, copy], copy)
            found[:, row - first : row - first + moved.shape[1]] = moved
        return found


def _as_tuple(found: PlyDamage) -> tuple[Array, Array, Array]:
    return found.damage, found.cycles, found.range

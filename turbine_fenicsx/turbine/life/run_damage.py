"""Damage of the plies of a blade by a recorded run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_damage import DamageCode, PlyDamage
from turbine_fenicsx.materials.ply_fatigue import MEASURES, FatigueTable, PlyFatigue
from turbine_fenicsx.records.motion_file import Motion
from turbine_fenicsx.reduction.recovered_plies import RecoveredPlies
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery

NUMBERS = 2**22
"""Strains that are in memory at a time, some 32 MB; temporary ones need five times as much."""

ROWS = 512
"""Rows of a motion that are read together."""

FEWEST = 3
"""Rows of a motion below which there is no cycle."""


@dataclass(frozen=True, eq=False)
class _Block:
    """Some cells.

    Args:
        rows: Numbers of their plies in the table of all.
    """

    recovered: RecoveredPlies
    fatigue: FatigueTable
    rows: IntArray


class RunDamage:
    """Finds the damage of runs of one turbine.

    Cells that stand for no layup, and plies of materials that do not count, have none.

    Args:
        recovery: The plies, of one of the runs.
        materials: How materials fail, by their names.

    Attributes:
        shape: Of the damage: blades, plies of this rank, faces from the outer one, stresses as in
            `turbine_fenicsx.materials.ply_fatigue.MEASURES`.

    Note:
        Making it is collective.
    """

    def __init__(self, recovery: PlyRecovery, materials: Mapping[str, PlyFatigue]) -> None:
        self._recovery, self._materials = recovery, materials
        self._code = DamageCode(recovery.run.turbine.comm)
        table = recovery.recovered.table
        counts = [ply.material.name in materials for ply in table.plies]
        own = [x for x in recovery.plies.panels.values() if len(x)]
        cells = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *own]))
        counted = np.zeros(len(table.first), dtype=bool)
        counted[table.wall[np.flatnonzero(counts)]] = True
        self._cells = cells[counted[cells]]
        self.shape = (recovery.vectors.shape[1], len(table.plies), 2, len(MEASURES))

    def find(
        self,
        motion: Motion,
        begin: float = 0.0,
        least: float = 0.0,
        progress: Callable[[float], None] = lambda part: None,
    ) -> PlyDamage:
        """Damage of a run that happens once.

        Args:
            motion: Its motion.
            begin: Time before which nothing counts [s].
            least: Histories that surely do less damage are left out.
            progress: Called with the part that is done, from 0 to 1.

        Returns:
            Arrays of `shape`.
        """
        rows = np.flatnonzero(motion.times >= begin)
        found = np.zeros((3, *self.shape))
        blocks = self._split(len(rows))
        for copy in range(self.shape[0]):
            moved = self._move(motion, int(rows[0]), copy)
            for k, block in enumerate(blocks):
                stresses = block.recovered.find_mean_stresses(moved)
                flat = stresses.reshape(-1, *stresses.shape[2:])
                of_plies = self._code.find(block.fatigue, flat, least)
                for out, values in zip(found, _as_tuple(of_plies), strict=True):
                    out[copy, block.rows] = values.reshape(-1, *self.shape[2:])
                progress((copy + (k + 1) / len(blocks)) / self.shape[0])
        return PlyDamage(*found)

    def _move(self, motion: Motion, first: int, copy: int) -> Array:
        """Displacements of the vectors of a blade from a row on, shape (n, rows, 3)."""
        vectors, recovered = motion.vectors[BODY], self._recovery.recovered
        found = np.empty((vectors.shape[2], len(vectors) - first, 3))
        for row in range(first, len(vectors), ROWS):
            moved = recovered.move(vectors[row : row + ROWS, copy], copy)
            found[:, row - first : row - first + moved.shape[1]] = moved
        return found

    def _split(self, rows: int) -> list[_Block]:
        """Blocks of cells whose strains at all times are in memory together."""
        recovered = self._recovery.recovered
        table, size = recovered.table, max(1, NUMBERS // (24 * rows))
        blocks = []
        for first in range(0, len(self._cells), size):
            cells = self._cells[first : first + size]
            part = recovered.take(cells)
            numbers = np.concatenate([np.flatnonzero(table.wall == cell) for cell in cells])
            blocks.append(_Block(part, FatigueTable(part.table, self._materials, 2), numbers))
        return blocks


def _as_tuple(found: PlyDamage) -> tuple[Array, Array, Array]:
    return found.damage, found.cycles, found.range

"""Histories of peel and shear in the bonds of blades."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.adhesive_bond import Adhesive, find_bond_stresses
from turbine_fenicsx.materials.ply import Ply, PlyMaterial
from turbine_fenicsx.materials.ply_fatigue import MEASURES, FatigueTable, PlyFatigue
from turbine_fenicsx.materials.ply_table import PlyTable
from turbine_fenicsx.reduction.recovered_plies import RecoveredPlies
from turbine_fenicsx.turbine.blades.wall_cells import TRAILING_BOND
from turbine_fenicsx.turbine.life.run_damage import HistoryBlock, list_slices
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery


class BondHistories:
    """Stress in the bonds at feet of webs and along trailing edges, as of plies across the fibre.

    Args:
        recovery: The plies.
        adhesive: The adhesive of all bonds.
        fatigue: How it fails.

    Attributes:
        cells: Cells of this rank at bonds, one bond after another.
        names: Names of their bonds.
        shape: Blades, bonds, sides, stresses.
    """

    def __init__(self, recovery: PlyRecovery, adhesive: Adhesive, fatigue: PlyFatigue) -> None:
        bonds, table = recovery.plies.bonds, recovery.recovered.table
        self._recovered, self._fatigue = recovery.recovered, fatigue
        self.names = [name for name, cells in bonds.items() for _ in cells]
        every = [np.zeros(0, dtype=np.int64), *bonds.values()]
        self.cells = np.concatenate(every).astype(np.int64)
        ends = [*table.first.tolist(), len(table.plies)]
        walls = [table.plies[ends[cell] : ends[cell + 1]] for cell in self.cells]
        edges = [name.startswith(TRAILING_BOND) for name in self.names]
        self._rows = np.array(
            [find_bond_stresses(*x, adhesive) for x in zip(walls, edges, strict=True)]
        ).reshape(-1, 2, 3, 6)
        moduli = (adhesive.young,) * 3, (adhesive.shear,) * 3
        material = PlyMaterial("adhesive", 1.0, *moduli, (0.0, 0.0, 0.0), fatigue.strengths)
        self._ply = Ply(material, adhesive.thickness)
        self.shape = (recovery.vectors.shape[1], len(self.cells), 2, len(MEASURES))

    def split(self, rows: int) -> list[HistoryBlock]:
        """Blocks of bonds, see `HistoryBlock`."""
        blocks = []
        for part in list_slices(len(self.cells), rows):
            recovered, own = self._recovered.take(self.cells[part]), self._rows[part]
            table = PlyTable([[self._ply]] * len(own))
            fatigue = FatigueTable(table, {"adhesive": self._fatigue}, 2)
            numbers = np.arange(len(self.cells))[part]
            blocks.append(HistoryBlock(_Bonds(recovered, own), fatigue, numbers))
        return blocks


class _Bonds:
    """Stress of some bonds.

    Args:
        recovered: Their walls.
        rows: Stress by strains, shape (bonds, 2, 3, 6).
    """

    def __init__(self, recovered: RecoveredPlies, rows: Array) -> None:
        self._recovered, self._rows = recovered, rows

    def __call__(self, moved: Array) -> Array:
        """Shape (bonds, 2, 3, m)."""
        return np.asarray(self._rows @ self._recovered.find_mean_strains(moved)[:, None])

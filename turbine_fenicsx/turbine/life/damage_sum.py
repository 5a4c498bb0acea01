"""Damage of runs, added up."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply_damage import PlyDamage


class DamageSum:
    """Damage over the life, by Miner's rule.

    Args:
        shape: Blades, places, sides, and stresses as in
            `turbine_fenicsx.materials.ply_fatigue.MEASURES`.

    Attributes:
        damage: Of this shape, as all arrays [-].
        of_winds: Its parts by wind speed [m/s].
        worst: Number of the run that does most.
        range: Largest range of each stress [Pa], of the exertion [-].
        counted: Which histories were counted in some run.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.damage, self.range, self._most = (np.zeros(shape) for _ in range(3))
        self.worst = np.zeros(shape, dtype=np.int64)
        self.counted = np.zeros(shape, dtype=bool)
        self.of_winds: dict[float, Array] = {}

    def add(self, run: int, times: float, wind: float, found: PlyDamage) -> None:
        """Add a run.

        Args:
            run: Its number.
            times: How often it happens.
            wind: Its wind speed [m/s].
            found: What it does once.
        """
        own = times * found.damage
        self.damage += own
        self.of_winds[wind] = self.of_winds.get(wind, 0.0) + own
        self.worst = np.where(own > self._most, run, self.worst)
        self._most = np.maximum(self._most, own)
        self.range = np.maximum(self.range, found.range)
        self.counted |= found.cycles > 0.0

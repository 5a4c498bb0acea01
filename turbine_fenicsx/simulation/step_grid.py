"""Times of the steps: equal steps dt, halved where need be, on a grid that never drifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class StepGrid:
    """Cells of length dt from the origin to the end, each divided into halves of halves as needed.

    A step of level L is dt/2^L long and begins at a multiple of that. Positions are whole numbers,
    so that no error adds up and every multiple of dt is met exactly.

    Args:
        step: dt [s], positive.
        end: End [s]; the last cell is shortened to meet it.
        deepest: Largest level.
        cell: Number of the present cell.
        ticks: Position in it in units of its length / 2^deepest.
        level: Level of the next step.
        origin: Start of the first cell [s].
    """

    step: float
    end: float
    deepest: int = 10
    cell: int = 0
    ticks: int = 0
    level: int = 0
    origin: float = 0.0

    @property
    def done(self) -> bool:
        """Whether the end is reached."""
        return self.cell >= self._cells

    @property
    def dt(self) -> float:
        """Length of the next step [s]."""
        return self._length * 0.5**self.level

    @property
    def time(self) -> float:
        """Start of the next step [s]."""
        return self._time(self.ticks)

    @property
    def target(self) -> float:
        """End of the next step [s]."""
        return self._time(self.ticks + self._size)

    def advance(self, grow: bool = True) -> None:
        """Accept the step; double the next one if it may grow and is aligned with the grid."""
        self.ticks += self._size
        if self.ticks == 1 << self.deepest:
            self.cell, self.ticks = self.cell + 1, 0
        if grow and self.level > 0 and self.ticks % (2 * self._size) == 0:
            self.level -= 1

    def refine(self) -> bool:
        """Halve the next step; False if it is as small as allowed already."""
        if self.level == self.deepest:
            return False
        self.level += 1
        return True

    def _time(self, ticks: int) -> float:
        """Time of a position in the present cell [s]."""
        if ticks % (1 << self.deepest) == 0:
            n = self.cell + bool(ticks)
            time = self.origin + n * self.step
            return time if abs(time - self.end) < 1e-9 * self.step else min(time, self.end)
        return self.origin + self.cell * self.step + self._length * ticks * 0.5**self.deepest

    @property
    def _cells(self) -> int:
        """Number of cells."""
        return int(np.ceil((self.end - self.origin) / self.step * (1.0 - 1e-12)))

    @property
    def _size(self) -> int:
        """Ticks of the next step."""
        return 1 << (self.deepest - self.level)

    @property
    def _length(self) -> float:
        """Length of the present cell [s]; round-off must not make another dt of the last one."""
        if self.cell < self._cells - 1:
            return self.step
        length = self.end - (self.origin + self.cell * self.step)
        return self.step if abs(length - self.step) < 1e-9 * self.step else length

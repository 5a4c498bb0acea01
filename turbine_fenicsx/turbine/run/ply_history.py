"""The largest failure index of each panel and web over a recorded run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.records import names
from turbine_fenicsx.reduction.recovered_plies import RecoveredPlies
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun

BLOCK = 16
"""Number of states that are evaluated together."""


@dataclass(frozen=True, eq=False)
class PlyHistory:
    """Where plies come nearest to failure, for each row of the motion and each panel.

    Args:
        criterion: One of `turbine_fenicsx.materials.ply_failure.CRITERIA`.
        panels: Names of the panels and webs.
        times: Shape (rows,) [s].
        index: Largest failure index in all blades, shape (rows, panels) [-].
        place: Distance from the root where it is, of the same shape [m].
        ply: Number of the ply from the outer face, from 1.
        blade: Number of the blade, from 1.
    """

    criterion: str
    panels: tuple[str, ...]
    times: Array
    index: Array
    place: Array
    ply: IntArray
    blade: IntArray

    def columns(self) -> dict[str, Array]:
        """Time and four columns of each panel, by the names that they have in histories."""
        found: dict[str, Array] = {names.TIME: self.times}
        for k, panel in enumerate(self.panels):
            of = {"panel": panel, "criterion": self.criterion}
            found[names.PLY_INDEX(**of)] = self.index[:, k]
            found[names.PLY_INDEX_AT(**of)] = self.place[:, k]
            found[names.PLY_INDEX_PLY(**of)] = self.ply[:, k].astype(float)
            found[names.PLY_INDEX_BLADE(**of)] = self.blade[:, k].astype(float)
        return found


class NoPlies(InputError):
    """The blades of a run have no plies that could be recovered."""


class PlyRecovery:
    """The plies of a recorded run. Collective, also its methods.

    Attributes:
        plies: The plies of all blades, on one of them.
        recovered: Their strains, from the vectors of the blades.
        vectors: Vectors of the motion, shape (rows, blades, n, 3) [m].

    Raises:
        NoPlies: for rigid blades, beams, and blades of one material.
    """

    def __init__(self, run: RecordedRun) -> None:
        turbine, plies = run.turbine, None
        if BODY in run.reduced:
            plies = turbine.rotor.blades.make_plies(turbine.system, turbine.meshes[BODY])
        if plies is None:
            raise NoPlies(
                "rigid blades, beams, and blades of one material have no plies that could be "
                "recovered"
            )
        self.run, self.plies, self.vectors = run, plies, run.motion.vectors[BODY]
        self.recovered = RecoveredPlies(run.reduced[BODY], plies.stresses)

    def find_history(
        self, criterion: str = "tsai_wu", progress: Callable[[float], None] = lambda part: None
    ) -> PlyHistory:
        """The history of the largest failure index of each panel.

        Args:
            criterion: One of `turbine_fenicsx.materials.ply_failure.CRITERIA`.
            progress: Called with the part that is done, from 0 to 1.
        """
        plies, vectors = self.plies, self.vectors
        found = np.full((4, len(vectors), len(plies.panels)), -1.0)
        for copy, rows, part in _list_blocks(*vectors.shape[:2]):
            index, ply = self.recovered.find_largest(CRITERIA[criterion], vectors[rows, copy], copy)
            for p, cells in enumerate(plies.panels.values()):
                if len(cells):
                    where = cells[np.argmax(index[cells], axis=0)]
                    of_state = where, np.arange(len(where))
                    blade = np.full(len(where), copy)
                    new = np.array([index[of_state], plies.place[where], ply[of_state], blade])
                    better = new[0] > found[0, rows, p]
                    found[:, rows, p] = np.where(better, new, found[:, rows, p])
            progress(part)
        every = np.array(self.run.turbine.comm.allgather(found))
        winner = np.argmax(every[:, 0], axis=0)
        index, place, *numbers = np.take_along_axis(every, winner[None, None], axis=0)[0]
        ply, blade = (1 + np.array(numbers)).astype(np.int64)
        times, panels = self.run.motion.times, tuple(plies.panels)
        return PlyHistory(criterion, panels, times, index, place, ply, blade)


def _list_blocks(rows: int, copies: int) -> Iterator[tuple[int, slice, float]]:
    """Copy and rows of each block, and the part that is done with it."""
    done = 0
    for copy in range(copies):
        for first in range(0, rows, BLOCK):
            end = min(first + BLOCK, rows)
            done += end - first
            yield copy, slice(first, end), done / (rows * copies)

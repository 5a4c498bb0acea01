"""Forces and moments in a step; as mean values they need the states at both of its ends.

Multipliers of a midpoint rule alternate: where constraints turn a velocity, what one step leaves
over the next one takes back, of first order in the step. With the steps h before and h_1 now,

    f_w = (h f + h_1 f_1)/(h + h_1)

is the mean over both. It is of second order, and balances the momenta over two steps exactly. Time
series show it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State

NEXT, LAST = [1, 2, 0], [2, 0, 1]
"""Places in a dyad A of the vector sum a x b for A = sum a b^T: A[NEXT, LAST] - A[LAST, NEXT]."""

Coordinates: TypeAlias = tuple[Array, Array]
"""Those of all rigid bodies, and of all joints, in a state."""


class StepLoads(ABC):
    """Loads on rigid bodies or the ground in the steps of a run.

    They are mean values of a step where the scheme has its forces in the middle, else those at the
    end.

    Args:
        axes: Axes of the components of each load, their initial directions as rows, shape (3, 3);
            e1, e2, e3 if None.
        carriers: What the axes of each load turn with, a rigid body or a section; None is the
            ground.
    """

    def __init__(self, axes: Sequence[npt.ArrayLike | None], carriers: Sequence[object]) -> None:
        n = len(axes)
        self._axes = np.tile(np.eye(3), (n, 1, 1))
        for k, (rows, body) in enumerate(zip(axes, carriers, strict=True)):
            if rows is not None:
                R = np.asarray(body.directors, float) if isinstance(body, RigidBody) else np.eye(3)
                self._axes[k] = np.asarray(rows, dtype=float) @ R
        self._turning = np.array(
            [
                rows is not None and body is not None
                for rows, body in zip(axes, carriers, strict=True)
            ],
            dtype=bool,
        )
        self._turns = bool(self._turning.any())
        self._start: Any = None
        self._next_index = 0
        self._snapshot: Snapshot | None = None
        self._loads = self._mean = np.zeros((n, 2, 3))
        self._time = 0.0
        self._last: tuple[Array, float] | None = None  # of the last step, and its length
        self._restored = False

    def at(self, snapshot: Snapshot) -> Array:
        """Loads in the step that ended with a snapshot. Collective.

        To be called for every snapshot of a run, since the middle of a step lies between two.

        Returns:
            Force [N] and moment [N m] of each load, shape (n, 2, 3), equal on all ranks; zero in
            the first snapshot of a run, before which there was no step.
        """
        self._see(snapshot)
        return self._loads

    def mean_at(self, snapshot: Snapshot) -> Array:
        """Mean of the loads in the last two steps, as `at`; what time series show.

        It is the load of a single step after the first one, and where forces act at the end of a
        step.
        """
        self._see(snapshot)
        return self._mean

    def save(self) -> RestartData:
        """Loads and length of the last step, if there was one."""
        if self._last is None:
            return RestartData()
        return RestartData({"length": self._last[1]}, {"loads": self._last[0].copy()})

    def restore(self, data: RestartData) -> None:
        """Resume after the saved step."""
        self._last = (data.arrays["loads"].copy(), data.numbers["length"]) if data else None
        self._restored = True

    def _see(self, snapshot: Snapshot) -> None:
        """Find loads and means of a new snapshot."""
        if snapshot is self._snapshot:
            return
        end, time = self._remember(snapshot.state), snapshot.state.time
        if self._start is None or snapshot.report is None:
            self._loads = self._mean = np.zeros_like(self._loads)
            self._last, self._restored = self._last if self._restored else None, False
        else:
            assert snapshot.index == self._next_index, "reactions need every step of a run"
            at_end = snapshot.stepper.forces_at == 1.0
            self._loads = self._in_axes(
                *self._evaluate(end if at_end else self._start, end, snapshot)
            )
            self._mean, h_1 = self._loads, time - self._time
            if self._last is not None and not at_end:
                f, h = self._last
                self._mean = (h * f + h_1 * self._loads) / (h + h_1)
            self._last = self._loads, h_1
        self._start, self._time = end, time
        self._next_index, self._snapshot = snapshot.index + 1, snapshot

    def _remember(self, state: State) -> Any:
        """Copy of the coordinates: all that `_evaluate` needs of the end of a step."""
        return state.q.copy(), state.joint_coordinates.copy()

    @abstractmethod
    def _evaluate(self, start: Any, end: Any, snapshot: Snapshot) -> tuple[Array, Array]:
        """Loads in a step.

        Args:
            start: Of `_remember` at the start of the step, or at its end if forces act there.
            end: Of `_remember` at its end.

        Returns: Loads along e1, e2, e3, shape (n, 2, 3), and the mean directors of the carriers,
            shape (n, 3, 3).
        """

    def _in_axes(self, loads: Array, directors: Array) -> Array:
        """Components along the axes as they are in the middle of the step."""
        axes = self._axes
        if self._turns:
            U, _, V = np.linalg.svd(directors)  # U V is the rotation half way between the two ends
            axes = np.where(self._turning[:, None, None], axes @ U @ V, axes)
        return loads @ axes.transpose(0, 2, 1)

"""Constraints of joints that follow functions of time, Phi(q) = p(t)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.own_code import evaluate_function
from turbine_fenicsx.foundation.quadratic import Quadratic
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.relation import check_motion
from turbine_fenicsx.joints.rheonomic import Rheonomic

MOMENT = 1e-4
"""Time [s] in which the rate of a path is measured, by a polynomial through five of its values."""

SLOPES = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0


class Paths:
    """The right-hand sides p(t) of all constraints of bodies and joints.

    Args:
        comm: Communicator; rank 0 evaluates functions of a user for all.
        constraints: The constraints with a multiplier, in the order of these.
        owners: The joint of each, "" for an internal constraint of a body.
        more: Number of further right-hand sides that are zero at all times, those of the joint
            coordinates.

    Attributes:
        names: Names of the joints that follow functions of time.
        rows: Numbers of their constraints that do, shape (n,).
        size: Number of right-hand sides.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        constraints: Sequence[Quadratic | Rheonomic],
        owners: Sequence[str],
        more: int,
    ) -> None:
        self._comm = comm
        moving = [(k, c.motion) for k, c in enumerate(constraints) if isinstance(c, Rheonomic)]
        self.rows: npt.NDArray[np.int64] = np.array([k for k, _ in moving], dtype=np.int64)
        self._motions: list[Callable[[float], float]] = [p for _, p in moving]
        self.names = tuple(dict.fromkeys(owners[k] for k in self.rows))
        self._joint_of_row = np.array([self.names.index(owners[k]) for k in self.rows], np.int64)
        self.size = len(constraints) + more
        self._zero = np.zeros(self.size)
        for k, motion in moving:
            check_motion(f"motion of a constraint of {owners[k]!r}", motion)

    def values(self, time: float) -> Array:
        """The right-hand sides at one time [s], shape (size,), not to be changed. Collective."""
        if not self._motions:
            return self._zero
        values = self._zero.copy()
        values[self.rows] = [
            evaluate_function(
                self._comm, f"motion of a constraint of {self.names[k]!r}", motion, time
            )
            for k, motion in zip(self._joint_of_row, self._motions, strict=True)
        ]
        return values

    def rates(self, time: float) -> Array:
        """dp/dt from one time [s] on, as `values`."""
        return find_rates(self.values, time)

    def sum_works(self, forces: Array, gradients: Array, dq: Array) -> Array:
        """Work of each of the joints [J].

        Args:
            forces: Multipliers of the rows, shape (n,).
            gradients: Gradients of their functions in the middle of the step, shape (n, n_q).
            dq: Increment of the coordinates, shape (n_q,).
        """
        works = np.zeros(len(self.names))
        np.add.at(works, self._joint_of_row, -forces * (gradients @ dq))
        return works


def find_rates(values: Callable[[float], Array], time: float) -> Array:
    """The rates of functions of time from one time [s] on, by a polynomial through five values."""
    times = time + MOMENT * np.arange(SLOPES.size)
    rates: Array = SLOPES @ np.array([values(t) for t in times]) / MOMENT
    return rates


def refuse_dependent_paths(
    constraints: Sequence[Quadratic | Rheonomic],
    redundant: npt.NDArray[np.int64],
    owners: Sequence[str],
) -> None:
    """Raise a ModelError for a constraint that follows time and depends on the others."""
    for k in redundant.tolist():
        if isinstance(constraints[k], Rheonomic):
            raise ModelError(
                f"joint {owners[k]!r} has a constraint that follows a function of time, but "
                "depends on the other constraints, which determine that motion already"
            )

"""Error of a step, for step sizes that follow a tolerance.

The step is x_{n+1} = x_n + dt (v_n + v_{n+1})/2 for all coordinates, and its local error is that of
the trapezoidal rule,

    e = dt^3/12 x''',    x''' = (a_{n+1/2} - a_{n-1/2}) / ((dt_n + dt_{n-1})/2),

with the mean accelerations a of this step and the last one.
"""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.memory import Memory
from turbine_fenicsx.rotations import Array
from turbine_fenicsx.state import State


class StepError:
    """Estimates the error of a step relative to a tolerance.

    Args:
        comm: Communicator.
        angle: Tolerance of the directors of rigid bodies, which are angles for small errors [rad];
            None for no limit.
        displacement: Tolerance of the centres of rigid bodies and the nodes of flexible bodies
            [m]; None for no limit.

    Raises:
        ValueError: for a tolerance that is not positive.
    """

    GROW_BELOW = 1.0 / 16.0
    """Steps whose error is below this may grow: twice as long, they have eight times the error."""

    def __init__(
        self, comm: MPI.Intracomm, angle: float | None = None, displacement: float | None = None
    ) -> None:
        """Check the tolerances."""
        for name, tolerance in (("angle", angle), ("displacement", displacement)):
            if tolerance is not None and not tolerance > 0.0:
                raise ValueError(f"the {name} tolerance must be positive, got {tolerance:g}")
        self._comm = comm
        self._angle, self._displacement = angle or np.inf, displacement or np.inf
        self._dt = 0.0
        self._last: tuple[Array, ...] = ()
        self._new: tuple[Array, ...] = ()

    def estimate(self, state: State, new: State, dt: float) -> float:
        """Error of the step from ``state`` to ``new`` in units of the tolerance. Collective.

        Zero for the first step, before which there is no acceleration.
        """
        rates = [(state.q_dot, new.q_dot)]
        rates += [(v.array_r, w.array_r) for v, w in zip(state.v, new.v, strict=True)]
        self._new = tuple((w - v) / dt for v, w in rates)
        if not self._last:
            return 0.0
        factor = dt**3 / 6.0 / (dt + self._dt)
        rigid, *flexible = (
            np.abs(factor * (a - b)) for a, b in zip(self._new, self._last, strict=True)
        )
        q = rigid.reshape(-1, 4, 3)
        angle = np.max(q[:, 1:], initial=0.0)
        displacement = np.max(q[:, 0], initial=0.0)
        for e in flexible:
            displacement = max(displacement, np.max(e, initial=0.0))
        error = max(angle / self._angle, displacement / self._displacement)
        return float(self._comm.allreduce(float(error), op=MPI.MAX))

    def accept(self, dt: float) -> None:
        """The step that was estimated last was accepted."""
        self._dt, self._last = dt, self._new

    def remember(self) -> Memory:
        """Accelerations of the last step."""
        if not self._last:
            return Memory()
        rigid, *flexible = self._last
        nodal = tuple(a.reshape(-1, 3).copy() for a in flexible)
        return Memory({"dt": self._dt}, {"a": rigid.copy()}, {"a": nodal})

    def recall(self, memory: Memory) -> None:
        """Set the accelerations of the last step."""
        if memory:
            self._dt = memory.numbers["dt"]
            self._last = (memory.arrays["a"], *(a.ravel() for a in memory.nodal.get("a", ())))

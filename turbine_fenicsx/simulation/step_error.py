"""Error of a step, for step sizes that follow a tolerance.

The step is x_{n+1} = x_n + dt (v_n + v_{n+1})/2 for all coordinates, and its local error is that of
the trapezoidal rule,

    e = dt^3/12 x''',

with x''' as twice the second divided difference of the mean velocities w = (v_n + v_{n+1})/2 of the
last three steps. Accelerations (v_{n+1} - v_n)/dt would not do: velocities against a constraint
alternate from step to step, undamped, once a step was too long, and w does not see that.
"""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State


class StepError:
    """Estimates the error of a step relative to a tolerance.

    Args:
        comm: Communicator.
        angle: Tolerance of the directors of rigid bodies, which are angles for small errors [rad];
            None for no limit.
        displacement: Tolerance of the centres of rigid bodies and the nodes of flexible bodies
            [m]; None for no limit.

    Raises:
        ModelError: for a tolerance that is not positive.
    """

    GROW_BELOW = 1.0 / 16.0
    """Steps whose error is below this may grow: twice as long, they have eight times the error."""

    def __init__(
        self, comm: MPI.Intracomm, angle: float | None = None, displacement: float | None = None
    ) -> None:
        for name, tolerance in (("angle", angle), ("displacement", displacement)):
            if tolerance is not None and not tolerance > 0.0:
                raise ModelError(f"the {name} tolerance must be positive, got {tolerance:g}")
        self._comm = comm
        self._angle, self._displacement = angle or np.inf, displacement or np.inf
        self._new: tuple[Array, ...] = ()
        self._last: list[tuple[float, tuple[Array, ...]]] = []  # newest first

    def estimate(self, state: State, new: State, dt: float) -> float:
        """Error of the step from ``state`` to ``new`` in units of the tolerance. Collective.

        Zero for the first two steps, so that a run should begin with small ones.
        """
        rates = [(state.q_dot, new.q_dot)]
        rates += [(v.array_r, w.array_r) for v, w in zip(state.v, new.v, strict=True)]
        self._new = tuple(0.5 * (v + w) for v, w in rates)
        if len(self._last) < 2:
            return 0.0
        (dt_1, one), (dt_2, two) = self._last
        near, far = 0.5 * (dt + dt_1), 0.5 * (dt_1 + dt_2)
        factor = dt**3 / 6.0 / (near + far)
        rigid, *flexible = (
            np.abs(factor * ((a - b) / near - (b - c) / far))
            for a, b, c in zip(self._new, one, two, strict=True)
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
        self._last = [(dt, self._new), *self._last[:1]]

    def reset(self) -> None:
        """Discard the history."""
        self._last = []

    def save(self) -> RestartData:
        """Mean velocities of the last steps."""
        data = RestartData()
        for k, (dt, (rigid, *flexible)) in enumerate(self._last):
            nodal = tuple(a.reshape(-1, 3).copy() for a in flexible)
            data.add(str(k), RestartData({"dt": dt}, {"w": rigid.copy()}, {"w": nodal}))
        return data

    def restore(self, data: RestartData) -> None:
        """Set the mean velocities of the last steps."""
        self.reset()
        for k in range(2):
            m = data.part(str(k))
            if m:
                self._last.append(
                    (m.numbers["dt"], (m.arrays["w"], *(a.ravel() for a in m.nodal.get("w", ()))))
                )

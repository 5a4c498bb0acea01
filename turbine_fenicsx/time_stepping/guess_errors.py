"""Error of the first guess of a step, extrapolated from the last steps.

Where velocities lead is off by e_n, the increment of a step less its guess. Seen from what carries
a body, the errors of a smooth motion follow from each other,

    e_n = a_1 e_{n-1} + a_2 e_{n-2} + a_3 e_{n-3},

and the weights that suit e_{n-1} best, by least squares with masses, suit e_n too. Vibrations after
a sudden load have no such weights: what leaves too much of e_{n-1} is not used.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.parallel import from_rank0, sum_over_ranks
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.time_stepping.nested_step import NestedStep
from turbine_fenicsx.time_stepping.recent_steps import RecentSteps

TERMS = 3
"""Number of weights: a constant, a trend, and the alternating part of velocities."""

UNEXPLAINED = 0.25
"""Part of the last error that may be left, in the norm of masses."""


class GuessErrors:
    """The errors of the first guesses of the last steps of a system with flexible bodies.

    Multipliers of couplings are left out: the first linear solve finds them, wherever they start.

    Args:
        step: The step, whose X `correct` improves and `add` reads.
    """

    def __init__(self, step: NestedStep) -> None:
        """Nothing is known yet."""
        self._step = step
        weights = step.mass_weights()
        self._sizes = [3 * model.n_owned for model in step.system.flexible_models]
        n = sum(self._sizes)
        self._weights = np.concatenate([weights[:n], weights[weights.size - step.n_r :]])
        self._steps = RecentSteps(TERMS + 1)
        self._guess: Array = np.zeros(0)

    def correct(self, time: float, dt: float) -> None:
        """Add the error expected of the guess X of the step from a time by dt [s]. Collective."""
        self._guess = self._increments()
        last = self._steps.before(time, dt)
        if not last:
            return
        errors = np.array(last)
        G = sum_over_ranks(self._step.system.comm, (errors * self._weights) @ errors.T)
        a = np.linalg.lstsq(G[1:, 1:], G[1:, 0], rcond=1e-12)[0]
        if G[0, 0] - a @ G[1:, 0] < UNEXPLAINED**2 * G[0, 0]:
            self._write(self._guess + self._turn(a @ errors[:-1], back=True))

    def add(self, time: float, dt: float) -> None:
        """The step from a time by dt [s] ended at X."""
        error = self._turn(self._increments() - self._guess, back=False)
        self._steps.add(time, dt, error)

    def forget(self) -> None:
        """Forget all steps, for what comes does not look like them."""
        self._steps.forget()

    def save(self) -> RestartData:
        """The last errors; nothing if there are none. Collective."""
        steps, system = self._steps, self._step.system
        if not steps.values:
            return RestartData()
        ends, n = np.cumsum(self._sizes), len(steps.values)
        nodal, r = {}, np.zeros((n, system.rigid_model.size))
        for k, values in enumerate(steps.values):
            *bodies, rigid = np.split(values, ends)
            nodal[f"u_{k}"] = tuple(u.reshape(-1, 3) for u in bodies)
            if self._step.n_r:
                r[k] = rigid
        arrays = {"r": from_rank0(system.comm, r)}
        return RestartData({"dt": steps.dt, "end": steps.end}, arrays, nodal)

    def restore(self, data: RestartData) -> None:
        """Resume after the saved steps."""
        self.forget()
        if data:
            self._steps.dt, self._steps.end = data.numbers["dt"], data.numbers["end"]
            self._steps.values = [
                np.concatenate([*(u.ravel() for u in data.nodal[f"u_{k}"]), r[: self._step.n_r]])
                for k, r in enumerate(data.arrays["r"])
            ]

    def _increments(self) -> Array:
        """This rank's part of X without multipliers of couplings, a copy."""
        du, _, r = self._step.split(self._step.x)
        return np.concatenate([*(part.array_r for part in du), r.array_r])

    def _write(self, values: Array) -> None:
        """Set what `_increments` gives."""
        du, _, r = self._step.split(self._step.x)
        for part, new in zip((*du, r), np.split(values, np.cumsum(self._sizes)), strict=True):
            part.array[:] = new

    def _turn(self, values: Array, back: bool) -> Array:
        """Vectors into the frames that carry them at t_n, or back from there."""
        system, turned, start = self._step.system, values.copy(), 0
        directors = self._step.start.state.q.reshape(-1, 4, 3)[:, 1:]
        frames = directors if back else directors.swapaxes(1, 2)
        for size, c in zip(self._sizes, system.coupling_blocks, strict=True):
            if c.carriers:
                frame = frames[system.first_coordinate[c.carriers[0]] // 12]
                of_body = slice(start, start + size)
                turned[of_body] = (values[of_body].reshape(-1, 3) @ frame).ravel()
            start += size
        if self._step.n_r:
            q = slice(start, start + system.rigid_model.n_q)
            turned[q] = (values[q].reshape(-1, 4, 3) @ frames).ravel()
        return turned

"""First guess of a step: where velocities lead, corrected by what the last steps had beyond it.

**What turns.** The guess dq = dt v_n is wrong by (w dt)^2/2 of the radius. The midpoint rule turns
a rigid body of angular velocity w by the Cayley transform R of dt w, and from the mean of both
velocities, v_n and R v_n,

    dq = dt P v_n,    P = (1 + R)/2 = (1 + h + h h^T) / (1 + |h|^2),    h = dt w/2,

with the matrix of the cross product for h. Flexible bodies take P and R = 2 P - 1 of what carries
them; the forces that couple them turn with R. A steady rotation is then guessed exactly.

**Rigid bodies alone.** A smooth motion is near a polynomial in the number of the step, but
velocities and multipliers carry an undamped alternating part besides, since the constraints hold at
the ends of the steps only. With the shift z r_n = r_{n-1}, polynomials of degree below five and
(-1)^n are all that

    (1 - z)^5 (1 + z) r_n = 0

has as solutions; solved for r_n this is the guess. Its error is 2 dt^5 times the fifth derivative,
where five steps without the factor 1 + z would multiply the alternating part by 32.

**Flexible bodies.** Where velocities lead is off by e_n, the increment of a step less its guess.
Seen from what carries a body, the errors of a smooth motion follow from each other,

    e_n = a_1 e_{n-1} + a_2 e_{n-2} + a_3 e_{n-3},

and the weights that suit e_{n-1} best, by least squares with masses, suit e_n too. Vibrations after
a sudden load have no such weights: what leaves too much of e_{n-1} is not used.

**Reduced bodies.** Their stiffest modes turn far in a step, so that nothing damps the alternating
part that round-off leaves in their velocities. It moves nothing, but dt v_n would strain stiff
walls with it. So their increments follow from those of the last steps alone, seen from what carries
them: with the shift z again, (1 - z)^3 dz_n = 0, or lower powers after fewer steps.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.parallel import from_rank0, sum_over_ranks
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.time_stepping.nested_step import NestedStep

WEIGHTS: Array = np.array([4.0, -5.0, 0.0, 5.0, -4.0, 1.0])
"""Weights of r_{n-1}, r_{n-2}, ...: the coefficients of 1 - (1 - z)^5 (1 + z)."""

TERMS = 3
"""Number of weights of errors: a constant, a trend, and the alternating part of velocities."""

INCREMENTS = ((1.0,), (2.0, -1.0), (3.0, -3.0, 1.0))
"""Weights of the last increments of reduced bodies, of as many as are known."""

UNEXPLAINED = 0.25
"""Part of the last error that may be left, in the norm of masses."""


def mean_turns(q: Array, q_dot: Array, dt: float) -> Array:
    """P of each rigid body for a step, the unit matrix where it does not turn.

    Args:
        q: Coordinates at t_n, shape (12 bodies,).
        dt: Step [s].

    Returns:
        Shape (bodies, 3, 3).
    """
    directors, rates = (x.reshape(-1, 4, 3)[:, 1:] for x in (q, q_dot))
    products = directors.transpose(0, 2, 1) @ rates
    h = 0.25 * dt * (products.transpose(0, 2, 1) - products)  # of w = sum d_i x d_i'/2
    square = 0.5 * (h * h).sum(axis=(1, 2))  # |h|^2, and h h^T = h.h + |h|^2 for the matrix h
    return np.asarray(np.eye(3) + (h + h @ h) / (1.0 + square)[:, None, None])


class RecentSteps:
    """Values of the last steps, as long as each is as long as the one before and continues it.

    Args:
        most: Number of steps that are kept.

    Attributes:
        dt: Length of the steps [s].
        end: Time of their end [s].
    """

    def __init__(self, most: int) -> None:
        """Nothing is known yet."""
        self._most = most
        self.dt = self.end = 0.0
        self.values: list[Array] = []

    def before(self, time: float, dt: float) -> list[Array]:
        """Values of the steps that a step from a time by dt [s] continues; empty unless full."""
        full = len(self.values) == self._most
        return self.known_before(time, dt) if full else []

    def known_before(self, time: float, dt: float) -> list[Array]:
        """As `before`, but not only if full."""
        return self.values if self._follows(time, dt) else []

    def add(self, time: float, dt: float, values: Array) -> None:
        """A step from a time by dt [s] was made."""
        if not self._follows(time, dt):
            self.forget()
        self.dt, self.end = dt, time + dt
        self.values = [values, *self.values[: self._most - 1]]

    def forget(self) -> None:
        """Forget all steps, for what comes does not look like them."""
        self.values = []

    def _follows(self, time: float, dt: float) -> bool:
        """Whether a step continues the last ones, except for round-off."""
        return max(abs(time - self.end), abs(dt - self.dt)) <= 1e-6 * dt


class FirstGuess:
    """Learns from the last steps of a system where the next one starts.

    It is remembered as unknowns of rigid bodies alone, or in a system with flexible bodies as
    errors of the guesses, and as increments of reduced bodies. Multipliers of couplings are left
    out: the first linear solve finds them, wherever they start.

    Args:
        step: The step, whose X `correct` improves and `learn` reads.
    """

    def __init__(self, step: NestedStep) -> None:
        """Nothing is known yet."""
        self._step, models = step, step.system.flexible_models
        self._is_rigid = not models
        self._sizes = [3 * model.n_owned for model in models]
        weights, n = step.mass_weights(), sum(self._sizes)
        self._weights = np.concatenate([weights[:n], weights[weights.size - step.n_r :]])
        of_bodies = [np.full(s, m.is_small) for s, m in zip(self._sizes, models, strict=True)]
        self._by_increments = np.concatenate([*of_bodies, np.zeros(step.n_r, dtype=bool)])
        self._weights[self._by_increments] = 0.0
        self._steps = RecentSteps(len(WEIGHTS) if self._is_rigid else TERMS + 1)
        self._guess: Array = np.zeros(0)

    def extrapolate(self, time: float, dt: float) -> Array | None:
        """Unknowns of rigid bodies alone in the step from a time by dt [s].

        Returns:
            Shape (n_r,); None with flexible bodies, or where too little is known.
        """
        last = self._steps.before(time, dt) if self._is_rigid else []
        return WEIGHTS @ np.array(last) if last else None

    def correct(self, time: float, dt: float) -> None:
        """Add the error expected of the guess X of the step from a time by dt [s]. Collective."""
        self._guess, small = self._increments(), self._by_increments
        last = self._steps.known_before(time, dt)
        if not last:
            return
        errors = np.array(last)
        weights = INCREMENTS[min(len(last), len(INCREMENTS)) - 1]
        expected = np.where(small, np.array(weights) @ errors[: len(weights)], 0.0)
        self._guess[small] = 0.0
        if self._steps.before(time, dt):
            expected[~small] = self._expect_errors(errors)[~small]
        self._write(self._guess + self._turn(expected, back=True))

    def _expect_errors(self, errors: Array) -> Array:
        """The error expected of the guess, by those of the last steps; zero if none is. Collective.

        Args:
            errors: Newest first, shape (TERMS + 1, unknowns).
        """
        G = sum_over_ranks(self._step.system.comm, (errors * self._weights) @ errors.T)
        a = np.linalg.lstsq(G[1:, 1:], G[1:, 0], rcond=1e-12)[0]
        if G[0, 0] - a @ G[1:, 0] < UNEXPLAINED**2 * G[0, 0]:
            return np.asarray(a @ errors[:-1])
        return np.zeros_like(errors[0])

    def learn(self, time: float, dt: float) -> None:
        """The step from a time by dt [s] ended at X. Collective."""
        if self._is_rigid:
            self._steps.add(time, dt, self._step.rigid_unknowns())
        else:
            self._guess[self._by_increments] = 0.0
            error = self._turn(self._increments() - self._guess, back=False)
            self._steps.add(time, dt, error)

    def forget(self) -> None:
        """Forget all steps, for what comes does not look like them."""
        self._steps.forget()

    def save(self) -> RestartData:
        """The remembered steps; empty if there are none. Collective."""
        steps, system = self._steps, self._step.system
        if not steps.values:
            return RestartData()
        ends, n = np.cumsum(self._sizes), len(steps.values)
        nodal, r = {}, np.zeros((n, system.rigid_model.size))
        for k, values in enumerate(steps.values):
            *bodies, rigid = np.split(values, ends)
            nodal[f"u_{k}"] = tuple(u.reshape(-1, 3) for u in bodies)
            if rigid.size:  # of errors on one rank only
                r[k] = rigid
        arrays = {"r": from_rank0(system.comm, r)}
        return RestartData({"dt": steps.dt, "end": steps.end}, arrays, nodal)

    def restore(self, data: RestartData) -> None:
        """Resume after the saved steps."""
        self.forget()
        if data:
            self._steps.dt, self._steps.end = data.numbers["dt"], data.numbers["end"]
            mine = slice(None if self._is_rigid else self._step.n_r)
            self._steps.values = [
                np.concatenate([*(u.ravel() for u in data.nodal.get(f"u_{k}", ())), r[mine]])
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

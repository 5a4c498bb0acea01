"""Order of the attempts of a step, learnt from the steps before, and reports of failures.

An approximate linear solver costs a fraction of the exact one, so that it goes first, and again
with a factor of the same step if that of an earlier one fails (`NewtonStepper.advance`). Where that
fails too its iterations are lost, and those of the next steps would be too. So it waits for some
steps before it goes first again; their number doubles with every failure and halves with every
success. Between two failures in a row its factor is renewed (`QuasiNewton`).

Only iterations count here, never measured times: all ranks and all repetitions of a run decide
alike. As long as the approximate solver converges within `SolverOptions.max_iterations` it is the
cheaper one. An exact iteration costs 24 to 48 times as much (1 000 to 70 000 displacements), and a
step takes three of them or more.
"""

from __future__ import annotations

from typing import NamedTuple

from petsc4py import PETSc

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.restart_data import RestartData

LONGEST_WAIT = 31
"""Steps after which a solver that failed goes first again at the latest."""


class Attempt(NamedTuple):
    """How a step is tried.

    Args:
        moves_on: Whether Newton's method starts from where the velocities lead, else from x_n.
    """

    solver: str
    moves_on: bool

    def __str__(self) -> str:
        """In words."""
        start = "the extrapolated start" if self.moves_on else "the last state"
        return f"{self.solver!r} from {start}"


class Attempts:
    """The attempts of the next step.

    Args:
        exact: Name of the one that takes over where it fails; the same if it is exact itself.
    """

    def __init__(self, name: str, exact: str) -> None:
        """Nothing has failed yet."""
        self._first = Attempt(name, True)
        self._others = [Attempt(exact, True), Attempt(exact, False)]
        self._wait = self._next_wait = 0

    def order(self) -> list[Attempt]:
        """Attempts in order."""
        first = [] if self._wait else [self._first]
        return list(dict.fromkeys([*first, *self._others]))

    def learn(self, successful: Attempt) -> None:
        """A step was made, at the end by this attempt."""
        if self._first == self._others[0]:
            return
        if self._wait:
            self._wait -= 1
        elif successful == self._first:
            self._next_wait //= 2
        else:
            self._wait = self._next_wait
            self._next_wait = min(2 * self._next_wait + 1, LONGEST_WAIT)

    def save(self) -> RestartData:
        """The learnt state."""
        return RestartData({"wait": self._wait, "next_wait": self._next_wait})

    def restore(self, data: RestartData) -> None:
        """Copy the state of another one."""
        self._wait, self._next_wait = data.numbers["wait"], data.numbers["next_wait"]


class Failure(NamedTuple):
    """An attempt that failed.

    Args:
        reason: PETSc's reason; positive if the solution was not accepted.
    """

    attempt: Attempt
    reason: int
    iterations: int

    @property
    def cause(self) -> str:
        """Why, in words."""
        reasons = PETSc.SNES.ConvergedReason
        if self.reason > 0:
            return (
                "a joint turns by a quarter of a revolution or more in the step, or a redundant "
                "constraint does not hold"
            )
        if self.reason == reasons.DIVERGED_MAX_IT:
            n = self.iterations
            return f"the residual is still too large after {n} iteration{'s' * (n != 1)}"
        if self.reason == reasons.DIVERGED_DTOL:
            return "the residual grows"
        if self.reason == _compat.NOT_A_NUMBER:
            return "the residual is not a number"
        names = {v: k for k, v in vars(reasons).items() if isinstance(v, int)}
        return f"PETSc says {names.get(self.reason, self.reason)}"


def tell(failures: list[Failure]) -> str:
    """Each cause once, with the attempts that it ended where causes differ."""
    causes: dict[str, list[str]] = {}
    for failure in failures:
        causes.setdefault(failure.cause, []).append(str(failure.attempt))
    if len(causes) == 1:
        return next(iter(causes))
    return ", ".join(f"{cause} ({', '.join(names)})" for cause, names in causes.items())

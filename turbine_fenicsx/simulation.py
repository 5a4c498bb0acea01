"""The time loop: steps of fixed size, halved where Newton's method fails, watched by observers."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from turbine_fenicsx import timing
from turbine_fenicsx.solver import EnergyMomentumSolver, SolverOptions, StepFailure, StepReport
from turbine_fenicsx.state import State
from turbine_fenicsx.system import Balance, MultibodySystem


@dataclass(frozen=True)
class Snapshot:
    """What observers see of an accepted step, and of the initial state. Equal on all ranks.

    Args:
        index: Number of accepted steps, 0 for the initial state.
        state: The state; valid until the observer returns.
        balance: Its energies and momenta.
        external_work: Work of all loads but gravity since t = 0 [J].
        energy_error: Total energy minus initial energy minus external work [J].
        constraint_error: Largest violation of a constraint [m, -].
        report: What the step took; None for the initial state.
        wall_time: Seconds since the start of the run.
    """

    index: int
    state: State
    balance: Balance
    external_work: float
    energy_error: float
    constraint_error: float
    report: StepReport | None
    wall_time: float


class Observer(Protocol):
    """Something that watches a run: time series, fields, progress. Called on all ranks."""

    def observe(self, snapshot: Snapshot) -> None:
        """Look at the initial state and at each accepted step."""

    def finish(self) -> None:
        """The run has ended, normally or not."""


class Simulation:
    """Integrates a system from t = 0.

    Args:
        system: The system.
        step: Time step dt [s], positive.
        end: End time [s], not negative; the last step is shortened to meet it.
        observers: Whoever watches.
        options: Options of the step solver.
        smallest_step: A step that fails is halved, down to this fraction of dt.

    Attributes:
        solver: The step solver.
        halvings: How many steps had to be halved.

    Raises:
        ValueError: for a step or end time out of range.
    """

    def __init__(
        self,
        system: MultibodySystem,
        step: float,
        end: float,
        observers: Sequence[Observer] = (),
        options: SolverOptions | None = None,
        smallest_step: float = 2.0**-10,
    ) -> None:
        """Check the times and create the solver."""
        if not 0.0 < step < np.inf:
            raise ValueError(f"time.step must be positive, got {step:g} s")
        if not 0.0 <= end < np.inf:
            raise ValueError(f"time.end must not be negative, got {end:g} s")
        self.system, self.step, self.end = system, step, end
        self.observers = tuple(observers)
        self.solver = EnergyMomentumSolver(system, options)
        self.halvings = 0
        self._smallest = smallest_step * step

    def run(self) -> Snapshot:
        """Integrate to the end time.

        Returns:
            The last snapshot.

        Raises:
            StepFailure: if a step fails at the smallest size; all earlier steps were observed.
        """
        start = time.perf_counter()
        state = self.system.initial_state()
        spare = state.copy()
        balance = self.system.balance(state)
        initial, work, index = balance.total, 0.0, 0
        snapshot = self._snapshot(index, state, balance, initial, work, None, start)
        with ExitStack() as ending:
            for observer in self.observers:
                ending.callback(observer.finish)
            self._notify(snapshot)
            n_steps = int(np.ceil(self.end / self.step * (1.0 - 1e-12)))
            for k in range(1, n_steps + 1):
                target = min(k * self.step, self.end)
                dt = target - (k - 1) * self.step if k == n_steps else self.step
                if abs(dt - self.step) < 1e-9 * self.step:
                    dt = self.step  # or round-off would make another step size of the last one
                pending = [dt]
                while pending:
                    report = self._try(state, pending, spare)
                    if report is None:
                        continue
                    if not pending:
                        spare.time = target
                    state, spare = spare, state
                    work += report.work
                    index += 1
                    with timing.event("balance"):
                        balance = self.system.balance(state)
                    snapshot = self._snapshot(index, state, balance, initial, work, report, start)
                    self._notify(snapshot)
        return snapshot

    def _try(self, state: State, pending: list[float], out: State) -> StepReport | None:
        """Try the first of the pending steps; halve it and return None if it fails."""
        dt = pending.pop(0)
        try:
            return self.solver.advance(state, dt, out)
        except StepFailure as failure:
            if 0.5 * dt < self._smallest:
                raise StepFailure(f"{failure}; the step cannot be halved any further") from None
            self.halvings += 1
            pending[:0] = [0.5 * dt, 0.5 * dt]
            return None

    def _notify(self, snapshot: Snapshot) -> None:
        """Show a snapshot to all observers."""
        with timing.event("output"):
            for observer in self.observers:
                observer.observe(snapshot)

    def _snapshot(
        self,
        index: int,
        state: State,
        balance: Balance,
        initial: float,
        work: float,
        report: StepReport | None,
        start: float,
    ) -> Snapshot:
        """Collect what observers see."""
        return Snapshot(
            index=index,
            state=state,
            balance=balance,
            external_work=work,
            energy_error=balance.total - initial - work,
            constraint_error=self.system.constraint_error(state),
            report=report,
            wall_time=time.perf_counter() - start,
        )

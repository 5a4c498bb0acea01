"""The time loop: steps on a grid, refined where necessary, with observers and checkpoints."""

from __future__ import annotations

import logging
import time
import weakref
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation import timing
from turbine_fenicsx.foundation.argument_checks import (
    check_not_negative,
    check_number,
    check_positive,
)
from turbine_fenicsx.foundation.errors import ForeignError, ModelError, StepFailure
from turbine_fenicsx.foundation.own_code import end_all_on_error, name_exits
from turbine_fenicsx.foundation.parallel import raise_together, sum_over_ranks
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.checkpoint import Checkpoints, restore_state, save_state
from turbine_fenicsx.simulation.energy_check import EnergyWatch
from turbine_fenicsx.simulation.observer import (
    Observer,
    RestartableObserver,
    check_observers,
)
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.simulation.step_error import StepError
from turbine_fenicsx.simulation.step_grid import StepGrid
from turbine_fenicsx.system.start import check_motions, check_start
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.stepper import Stepper, StepReport

log = logging.getLogger(__name__)


@dataclass
class _Run:
    """Variables of a run."""

    state: State
    grid: StepGrid
    initial_energy: float
    initial_potential: float
    works: Array
    dissipated: Array
    index: int = 0
    wall_before: float = 0.0


class Simulation:
    """Integrates a system from t = 0.

    Args:
        system: The system.
        dt: Time step [s], positive.
        end: End time [s], not negative; the last step is shortened to meet it.
        observers: Whatever watches the run, called in this order.
        stepper: What makes the steps; the scheme of the paper, `EnergyMomentum`, if None.
        smallest_step: A step that fails is halved, down to this fraction of dt, and grows again
            step by step.
        step_error: Steps whose error exceeds its tolerance are halved too; None for none.
        checkpoints: Where restart data are written and where `resume` finds them; None for none.
        stop: Called after each step on all ranks; where one of them returns True, the run ends.
        start: State at t = 0, such as an equilibrium or an `initial_motion`; the initial state of
            the system if None.

    Attributes:
        stepper: What makes the steps.
        halvings: How many steps had to be halved.
        stopped: Whether the run ended because it was asked to.

    Raises:
        ModelError: for a time step or end out of range, two observers of one name, or a start state
            of another system.
        TypeError: if an observer lacks a method, or the start is not a state.
    """

    def __init__(
        self,
        system: MultibodySystem,
        dt: float,
        end: float,
        observers: Sequence[Observer] = (),
        stepper: Stepper | None = None,
        smallest_step: float = 2.0**-10,
        step_error: StepError | None = None,
        checkpoints: Checkpoints | None = None,
        stop: Callable[[], bool] | None = None,
        start: State | None = None,
    ) -> None:
        self.system = system
        self.dt = check_positive("dt", check_number("dt", dt))
        self.end = check_not_negative("end", check_number("end", end))
        self.observers = tuple(observers)
        self.stepper = stepper or EnergyMomentum(system)
        if self.stepper.system is not system:
            raise ModelError("the stepper of a simulation must be made for its system")
        self.halvings, self.stopped = 0, False
        self._deepest = max(0, int(np.floor(-np.log2(smallest_step))))
        self._error, self._checkpoints, self._stop = step_error, checkpoints, stop
        check_observers(self.observers)
        if start is not None:
            check_start(system, start)
        self._start = start

    def run(self, data: RestartData | None = None) -> Snapshot:
        """Integrate to the end time, or until it is asked to stop.

        A `ModelWarning` at the end reports if the energy balance is worse than the tolerance of the
        stepper and round-off explain.

        Args:
            data: What an earlier run saved; this one resumes from there.

        Returns:
            The last snapshot.

        Raises:
            ModelError: if a joint coordinate does not start where its prescribed motion begins.
            StepFailure: if a step fails at the smallest size; all earlier steps were observed, and
                a checkpoint was written.
            ForeignError: if code of a user fails in an observer, on all ranks; the others have
                observed the step, and a checkpoint was written.
        """
        end_all_on_error(self.system.comm)
        start = time.perf_counter()
        run = self._restore(data) if data else self._begin()
        spare = run.state.copy()
        snapshot = self._take_snapshot(run, None, start)
        self.stopped, energy = False, EnergyWatch()
        energy.take(snapshot)
        with ExitStack() as ending:
            ending.enter_context(one_thread())
            self._start_observers(snapshot, bool(data), ending)
            try:
                self._write_checkpoint(run, snapshot)
                while not (run.grid.done or self.stopped):
                    report = self._make_step(run, spare)
                    if report is None:
                        continue
                    run.state, spare = spare, run.state
                    run.works = run.works + report.works
                    run.dissipated = run.dissipated + report.dissipated
                    run.index += 1
                    snapshot = self._take_snapshot(run, report, start)
                    energy.take(snapshot)
                    self._notify(snapshot)
                    due = self._after_step(snapshot)
                    if due or self.stopped or run.grid.done:
                        self._write_checkpoint(run, snapshot)
            except (StepFailure, ForeignError):
                self._write_checkpoint(run, snapshot)
                raise
        energy.warn(self.system, self.stepper, run.index)
        return snapshot

    def resume(self) -> Snapshot:
        """Resume from the newest checkpoint that can be used, as if the run had never ended.

        Returns:
            The last snapshot.

        Raises:
            ModelError: for a simulation without checkpoints.
            InputError: if no checkpoint can be used, or it belongs to something else.
            StepFailure: as in `run`.
        """
        if self._checkpoints is None:
            raise ModelError(
                "a simulation resumes from its checkpoints, but it has none: give it "
                "checkpoints=Checkpoints(system, folder)"
            )
        return self.run(self._checkpoints.load(self.observers))

    def _begin(self) -> _Run:
        """Start at t = 0."""
        check_motions(self.system, self._start)
        self.halvings = 0
        self.stepper.restore(RestartData())
        state = self.system.initial_state() if self._start is None else self._start.copy()
        state.time = 0.0
        grid = StepGrid(self.dt, self.end, self._deepest)
        if self._error is not None:
            self._error.reset()
            grid.level = self._deepest  # nothing is known of the first steps, which are small
        works, dissipated = self.system.work_names, self.stepper.dissipation_names
        balance = self.system.balance(state)
        return _Run(
            state,
            grid,
            balance.total,
            balance.potential,
            np.zeros(len(works)),
            np.zeros(len(dissipated)),
        )

    def _make_step(self, run: _Run, out: State) -> StepReport | None:
        """Try the next step; None if it must be tried again with half its length."""
        dt, target = run.grid.dt, run.grid.target
        try:
            report = self.stepper.advance(run.state, dt, out)
        except StepFailure as failure:
            self._refine(run, str(failure), "the loads, the stiffness and the mesh there")
            return None
        error = 0.0
        if self._error is not None:
            error = self._error.estimate(run.state, out, dt)
            if error > 1.0:
                self._refine(
                    run,
                    f"the step from t = {run.state.time:.6g} s by {dt:.3g} s has {error:.3g} times "
                    "the allowed error",
                    "time.angle_tolerance and time.displacement_tolerance",
                )
                return None
            self._error.accept(dt)
        out.time = target
        run.grid.advance(grow=error <= StepError.GROW_BELOW)
        return report

    def _refine(self, run: _Run, reason: str, suspects: str) -> None:
        """Halve the next step, or raise a StepFailure with advice if it is the smallest."""
        if not run.grid.refine():
            raise StepFailure(
                f"{reason}. Steps are not halved below {run.grid.dt:.3g} s: try a smaller "
                f"time.step, and look at {suspects}"
            )
        log.info("%s; now with half of it", reason)
        self.halvings += 1

    def _after_step(self, snapshot: Snapshot) -> bool:
        """Agree on whether to stop, and on whether to write a checkpoint."""
        stop = self._stop is not None and self._stop()
        due = False
        if self._checkpoints is not None and self.system.comm.rank == 0:
            due = self._checkpoints.due(snapshot.state.time, snapshot.wall_time)
        if self._stop is not None or self._checkpoints is not None:
            stop, due = sum_over_ranks(self.system.comm, np.array([stop, due], dtype=float)) > 0.0
        self.stopped = bool(stop)
        return bool(due)

    def _write_checkpoint(self, run: _Run, snapshot: Snapshot) -> None:
        """Write what the run needs to resume."""
        if self._checkpoints is not None:
            with timing.event("output"):
                index, wall_time = run.index, snapshot.wall_time
                data = self._save(run, wall_time)
                self._checkpoints.write(index, run.state.time, wall_time, data)
            log.info("checkpoint of step %d at t = %.6g s", index, run.state.time)

    def _save(self, run: _Run, wall_time: float) -> RestartData:
        """Everything the run depends on from here."""
        grid = run.grid
        data = RestartData(
            {
                "step": self.dt,
                "origin": grid.origin,
                "cell": grid.cell,
                "ticks": grid.ticks,
                "level": grid.level,
                "deepest": grid.deepest,
                "index": run.index,
                "initial_energy": run.initial_energy,
                "initial_potential": run.initial_potential,
                "halvings": self.halvings,
                "wall_time": wall_time,
            }
        )
        data.arrays.update(works=run.works.copy(), dissipated=run.dissipated.copy())
        data.add("state", save_state(self.system, run.state))
        data.add("solver", self.stepper.save())
        if self._error is not None:
            data.add("error", self._error.save())
        for observer in self.observers:
            if isinstance(observer, RestartableObserver):
                data.add(f"observer.{observer.name}", observer.save())
        return data

    def _restore(self, data: RestartData) -> _Run:
        """Continue where an earlier run stopped."""
        n, state = data.numbers, restore_state(self.system, data.part("state"))
        position = (n["cell"], n["ticks"], n["level"], n["origin"])
        grid = StepGrid(self.dt, self.end, n["deepest"], *position)
        if n["step"] != self.dt or grid.time != state.time:  # or a former end between two steps
            grid = StepGrid(self.dt, self.end, self._deepest, origin=state.time)
        self.halvings = n["halvings"]
        self.stepper.restore(data.part("solver"))
        if self._error is not None:
            self._error.restore(data.part("error"))
        for observer in self.observers:
            if isinstance(observer, RestartableObserver) and (
                part := data.part(f"observer.{observer.name}")
            ):
                observer.restore(part)
        a = data.arrays
        return _Run(
            state,
            grid,
            n["initial_energy"],
            n["initial_potential"],
            a["works"],
            a["dissipated"],
            n["index"],
            n["wall_time"],
        )

    def _start_observers(self, snapshot: Snapshot, resumed: bool, ending: ExitStack) -> None:
        """Start all observers; each that was started is finished with the run."""
        with timing.event("output"):
            for observer in self.observers:
                observer.start(snapshot, resumed)
                ending.callback(observer.finish)

    def _notify(self, snapshot: Snapshot) -> None:
        """Show a step to all observers; the first error of one raises at the end, on all ranks.

        The others observe the step, and take part in what they do on all ranks.
        """
        failure: Exception | None = None
        with timing.event("output"):
            for observer in self.observers:
                try:
                    with name_exits(f"observer {type(observer).__name__}"):
                        observer.observe(snapshot)
                except Exception as error:
                    failure = failure or error
        raise_together(self.system.comm, failure)

    def _take_snapshot(self, run: _Run, report: StepReport | None, start: float) -> Snapshot:
        """Collect what observers see."""
        with timing.event("balance"):
            balance = self.system.balance(run.state)
            constraint_error = self.system.constraint_error(run.state)
        return Snapshot(
            index=run.index,
            state=run.state,
            balance=balance,
            works=run.works,
            dissipated=run.dissipated,
            energy_error=balance.total
            + float(run.dissipated.sum())
            - run.initial_energy
            - float(run.works.sum()),
            constraint_error=constraint_error,
            report=report,
            wall_time=run.wall_before + time.perf_counter() - start,
            # observers may keep snapshots in circles that are freed on one rank before the others
            maker=weakref.ref(self.stepper),
            initial_potential=run.initial_potential,
        )

"""A whole study: run what is missing, show progress, write the tables and the picture."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from tqdm import tqdm

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.output_folder import STUDY
from turbine_fenicsx.study.convergence import Series, choose_reference, make_series, write_series
from turbine_fenicsx.study.curve import read_reference
from turbine_fenicsx.study.execute import Outcome, execute, launcher_words
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import Run, group_series, plan
from turbine_fenicsx.study.results import (
    check_quantities,
    find_drifts,
    find_quantity,
    is_other,
    read_results,
    write_table,
)


class StudyProgress:
    """Shows how many runs are done; failures are always said immediately.

    Args:
        total: Number of runs.
        style: "bar", "log", "none", or "auto": a bar if stderr is a terminal.
    """

    def __init__(self, total: int, style: str = "auto") -> None:
        if style == "auto":
            style = "bar" if sys.stderr.isatty() else "log"
        self._style, self._total, self._done = style, total, 0
        self._start, self._before = time.perf_counter(), 0
        self._bar: tqdm | None = tqdm(total=total, unit="run") if style == "bar" else None

    def show(self, outcome: Outcome) -> None:
        """Show the outcome of a run."""
        self._done += 1
        if outcome.reason:
            said = f"failed: {outcome.reason}"
        elif outcome.seconds is None:
            said = "was finished before"
        else:
            said = f"finished in {outcome.seconds:.1f} s"
        line = f"{self._done}/{self._total} {outcome.run.name}: {said}{self._estimate(outcome)}"
        if self._bar is not None:
            self._bar.update()
            if outcome.reason:
                self._bar.write(line, file=sys.stderr)
        elif self._style == "log":
            print(line, file=sys.stderr, flush=True)

    def _estimate(self, outcome: Outcome) -> str:
        """The time left, by the runs that were finished since the start; empty if there is none."""
        self._before += outcome.seconds is None
        done = self._done - self._before
        left = self._total - self._done
        if not done or not left:
            return ""
        seconds = (time.perf_counter() - self._start) * left / done
        return f", {tqdm.format_interval(seconds)} left"

    def finish(self) -> None:
        """Close the bar."""
        if self._bar is not None:
            self._bar.close()


MAX_DRIFT = 1e-3
"""Means of two halves of a time that differ by less are those of a stationary run [-]."""


@dataclass
class StudyResult:
    """Results of a study.

    Attributes:
        results: Numbers of the finished runs, by name of the run and of the quantity.
        failed: Reasons of the failed runs by name.
        drifts: How far the means of quantities over the halves of the time over which they are
            averaged lie apart, by name of the run and of the quantity, where that is more than
            `MAX_DRIFT`.
    """

    runs: list[Run]
    results: dict[str, dict[str, float]] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    series: list[Series] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    drifts: dict[str, dict[str, float]] = field(default_factory=dict)


def run_study(
    study: Study,
    out: Path,
    overrides: Iterable[str] = (),
    progress: str = "auto",
    overwrite: bool = False,
) -> StudyResult:
    """Run a study; runs that are finished already are read only.

    Writes ``study.csv``, and ``convergence.csv`` if the study asks for orders.

    Args:
        out: Folder of the study, with one folder for each run.
        overrides: More changes of all runs, such as ``"time.end=1.0"``.
        progress: "auto", "bar", "log" or "none".
        overwrite: Whether results of other runs in the folders of these may be replaced.
    """
    runs = plan(study, overrides)
    launcher = launcher_words(study.launcher, study.ranks) if study.ranks > 1 else []
    if not overwrite:
        refuse_to_overwrite(runs, out)
    wanted = study.wanted
    if study.curve and study.curve.reference is not None:
        read_reference(study.curve.reference, study.curve.x, study.curve.y)
    check_quantities(wanted)
    make_folder(out)
    result = StudyResult(runs)
    shown = StudyProgress(len(runs), progress)

    def take(outcome: Outcome) -> None:
        name = outcome.run.name
        if outcome.reason:
            result.failed[name] = outcome.reason
        else:
            result.results[name] = read_results(out / name, study.average)
            for quantity in wanted:
                find_quantity(result.results[name], quantity)
            result.drifts[name] = _find_large_drifts(study, outcome.run, out / name)
        shown.show(outcome)

    try:
        execute(runs, out, study.processes, launcher, take)
        find_orders(study, result)
    finally:
        shown.finish()
        write_table(
            out / STUDY, runs, result.results, result.failed, study.varied, study.quantities
        )
    if study.convergence is not None:
        write_series(out / "convergence.csv", result.series)
    return result


def _find_large_drifts(study: Study, run: Run, folder: Path) -> dict[str, float]:
    """Drifts of the wanted quantities of a finished run that are more than `MAX_DRIFT`.

    No drift of a run in wind that changes says anything.
    """
    if study.average is None or not run.case.wind.is_steady:
        return {}
    drifts = find_drifts(folder, study.average, study.wanted)
    return {name: drift for name, drift in drifts.items() if drift > MAX_DRIFT}


def make_folder(out: Path) -> None:
    """Make the folder of many runs, unless it is there."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write to {str(out)!r}: {error.strerror}") from None


def refuse_to_overwrite(runs: list[Run], out: Path) -> None:
    """Refuse to replace results of other cases."""
    others = [run.name for run in runs if is_other(run, out / run.name)]
    if not others:
        return
    more = f" and {len(others) - 1} more" if len(others) > 1 else ""
    raise InputError(
        f"{str(out / others[0])!r}{more} holds the results of another case: --overwrite replaces "
        "them"
    )


def find_orders(study: Study, result: StudyResult) -> None:
    """Fill in the series of a finished study."""
    if study.convergence is None:
        return
    key, reference = study.convergence.key, study.convergence.reference
    for name in study.convergence.quantity:
        found = list(_compare(result, name, key, reference))
        if reference == "richardson" and found:
            best, notes = choose_reference(found)
            result.notes += [f"{found[0].quantity}: {note}" for note in notes]
            limit, source = (np.nan, "") if best is None else (best.reference, best.label)
            others = _compare(result, name, key, limit, source)
            found = [a if a is best else b for a, b in zip(found, others, strict=True)]
        result.series += found


def _compare(
    result: StudyResult, name: str, key: str, reference: float | str, source: str = ""
) -> Iterator[Series]:
    """Each series of a quantity beside a reference, as of `make_series`."""
    for label, members in group_series(result.runs, key).items():
        done = [run for run in members if run.name in result.results]
        if not done:
            continue
        quantity = find_quantity(result.results[done[0].name], name)
        yield make_series(
            label,
            quantity,
            [run.name for run in done],
            [run.value(key) for run in done],
            [result.results[run.name][quantity] for run in done],
            reference,
            source,
        )

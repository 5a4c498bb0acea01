"""A whole load set: run what is missing, and write the tables of its results."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.load_sets.arrays import write_set_arrays
from turbine_fenicsx.load_sets.lifetime import find_fatigue_of_set, format_fatigue_of_set
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun, plan_set
from turbine_fenicsx.load_sets.results import format_extremes, format_runs, format_winds
from turbine_fenicsx.load_sets.return_loads import find_return_loads, format_return_loads
from turbine_fenicsx.load_sets.run_loads import RunLoads, find_loads
from turbine_fenicsx.load_sets.situation import Situation
from turbine_fenicsx.postprocessing.cycles import count_cycles, format_markov
from turbine_fenicsx.records.output_folder import (
    EXTRAPOLATED,
    FATIGUE,
    MARKOV,
    SET,
    SET_ARRAYS,
    SET_RUNS,
    WINDS,
)
from turbine_fenicsx.records.statistics import ColumnStatistics, read_statistics
from turbine_fenicsx.study.execute import Outcome, execute, launcher_words
from turbine_fenicsx.study.run import StudyProgress, make_folder, refuse_to_overwrite


@dataclass
class SetResult:
    """Results of a load set.

    Attributes:
        runs: All runs of the set.
        results: Statistics of the finished runs by name.
        loads: Cycles and extremes of those that are counted.
        failed: Reasons of the failed runs by name.
        tables: Names of the files that are written.
    """

    runs: list[SetRun]
    results: dict[str, list[ColumnStatistics]] = field(default_factory=dict)
    loads: dict[str, RunLoads] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    tables: list[str] = field(default_factory=list)


def run_set(
    load_set: LoadSet,
    out: Path,
    overrides: Iterable[str] = (),
    progress: str = "auto",
    overwrite: bool = False,
) -> SetResult:
    """Run a load set; runs that are finished already are read only.

    A run that fails has a second try, see `execute`. Tables are written also if some runs
    fail or the set is interrupted.

    Args:
        out: Folder of the set, with one folder for each run.
        overrides: More changes of all runs, such as ``"time.step=0.1"``.
        progress: "auto", "bar", "log" or "none".
        overwrite: Whether results of other runs in the folders of these may be replaced.

    Raises:
        InputError: if the set has mistakes, or the folder cannot be written or holds other runs.
        ImportError: if rainflow, which counts cycles, is missing and cycles are counted.
    """
    runs, situations = plan_set(load_set, overrides), load_set.chosen
    studied = [each.run for each in runs]
    counted = {x.run.name: situations[x.situation] for x in runs if _is_counted(x, situations)}
    if counted:
        count_cycles(np.zeros(1))
    launcher = launcher_words(load_set.launcher, 1) if load_set.launcher else []
    processes = load_set.processes or len(os.sched_getaffinity(0))
    if not overwrite:
        refuse_to_overwrite(studied, out)
    make_folder(out)
    result = SetResult(runs)
    shown = StudyProgress(len(runs), progress)

    def take(outcome: Outcome) -> None:
        name = outcome.run.name
        if outcome.reason:
            result.failed[name] = outcome.reason
        else:
            result.results[name] = read_statistics(out / name)
            if name in counted:
                begin, block = counted[name].transient, load_set.extremes.block
                result.loads[name] = find_loads(out / name, begin, block)
        shown.show(outcome)

    try:
        execute(studied, out, processes, launcher, take, retry=True)
    finally:
        shown.finish()
        for name, text in _make_tables(load_set, result, out):
            if text:
                replace_file(out / name, text)
                result.tables.append(name)
    return result


def _is_counted(run: SetRun, situations: Mapping[str, Situation]) -> bool:
    """Whether cycles and extremes of blocks of a run are found."""
    users = [s for name, s in situations.items() if run.situation in (name, s.uses)]
    return any(s.evaluates in ("fatigue", "extrapolation") for s in users)


def _make_tables(load_set: LoadSet, result: SetResult, out: Path) -> Iterator[tuple[str, bytes]]:
    """All tables by the names of their files."""
    runs, results, situations = result.runs, result.results, load_set.chosen
    returns = {
        name: find_return_loads(load_set, runs, result.loads, situation.uses or name)
        for name, situation in situations.items()
        if situation.evaluates == "extrapolation"
    }
    of_set = {
        name: [load for load in loads if load.period == load_set.extremes.years]
        for name, loads in returns.items()
    }
    cycles = {name: loads.cycles for name, loads in result.loads.items()}
    fatigue = find_fatigue_of_set(load_set, runs, cycles)
    yield SET_RUNS, format_runs(load_set, runs, results, result.failed, fatigue.times, out).encode()
    yield SET, format_extremes(runs, situations, results, of_set).encode()
    yield WINDS, format_winds(runs, results).encode()
    yield EXTRAPOLATED, format_return_loads(returns).encode()
    yield FATIGUE, format_fatigue_of_set(fatigue).encode()
    yield MARKOV, format_markov(fatigue.cycles).encode()
    yield SET_ARRAYS, write_set_arrays(runs, situations, results, fatigue)

"""A whole load set: run what is missing, and write the tables of its results."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.load_sets.lifetime import format_fatigue_of_set
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun, plan_set
from turbine_fenicsx.load_sets.results import format_extremes, format_runs
from turbine_fenicsx.postprocessing.fatigue import Fatigue, find_fatigue, list_loads
from turbine_fenicsx.records.output_folder import FATIGUE, SET, SET_RUNS, read_histories
from turbine_fenicsx.records.statistics import ColumnStatistics, read_statistics
from turbine_fenicsx.study.execute import Outcome, execute
from turbine_fenicsx.study.run import StudyProgress, make_folder, refuse_to_overwrite


@dataclass
class SetResult:
    """Results of a load set.

    Attributes:
        runs: All runs of the set.
        results: Statistics of the finished runs by name.
        failed: Reasons of the failed runs by name.
        has_fatigue: Whether a table of fatigue is written.
    """

    runs: list[SetRun]
    results: dict[str, list[ColumnStatistics]] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    has_fatigue: bool = False


def run_set(
    load_set: LoadSet,
    out: Path,
    overrides: Iterable[str] = (),
    progress: str = "auto",
    overwrite: bool = False,
) -> SetResult:
    """Run a load set; runs that are finished already are read only.

    A run whose steps fail has a second try with half the step. ``set.csv`` and ``runs.csv`` are
    written, also if some runs fail or the set is interrupted, ``fatigue.csv`` at the end.

    Args:
        out: Folder of the set, with one folder for each run.
        overrides: More changes of all runs, such as ``"time.step=0.1"``.
        progress: "auto", "bar", "log" or "none".
        overwrite: Whether results of other runs in the folders of these may be replaced.

    Raises:
        InputError: if the set has mistakes, or the folder cannot be written or holds other runs.
        ImportError: if rainflow, which counts cycles, is missing; all else is written.
    """
    runs = plan_set(load_set, overrides)
    studied = [each.run for each in runs]
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
        shown.show(outcome)

    processes = load_set.processes or len(os.sched_getaffinity(0))
    try:
        execute(studied, out, processes, [], take, retry=True)
    finally:
        shown.finish()
        situations = load_set.chosen
        replace_file(out / SET_RUNS, format_runs(runs, result.results, result.failed, out).encode())
        if result.results:
            replace_file(out / SET, format_extremes(runs, situations, result.results).encode())
    text = format_fatigue_of_set(load_set, runs, result.results, _Counter(out))
    if text:
        replace_file(out / FATIGUE, text.encode())
        result.has_fatigue = True
    return result


@dataclass(frozen=True)
class _Counter:
    """Counts cycles of moments and strains of runs in a folder."""

    folder: Path

    def __call__(self, run: str, begin: float) -> list[Fatigue]:
        """Fatigue of a run from a time on; none of one without loads."""
        (series,) = read_histories([self.folder / run])
        return find_fatigue(series, start=begin) if list_loads(series) else []

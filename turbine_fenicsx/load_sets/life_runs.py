"""Runs of a load set as parts of the life of its turbine."""

from __future__ import annotations

from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.load_sets.results import BEGIN, TIMES, YEARS
from turbine_fenicsx.load_sets.stored_set import read_rows
from turbine_fenicsx.records.output_folder import SET_RUNS
from turbine_fenicsx.turbine.life.weighted_run import WeightedRun


def find_life_runs(folder: Path) -> tuple[list[WeightedRun], float]:
    """The runs of a set that count for fatigue, and the life that they add up to [years].

    Raises:
        InputError: for a table of a set that is damaged, or has no such runs.
    """
    rows = read_rows(folder / SET_RUNS, ("run", "state", BEGIN, TIMES, YEARS))
    try:
        found = [
            WeightedRun(folder / row["run"], row["run"], float(row[BEGIN]), times=float(row[TIMES]))
            for row in rows
            if row["state"] == "finished" and float(row[TIMES] or 0.0) > 0.0
        ]
        years = float(rows[0][YEARS]) if rows else 0.0
    except ValueError as error:
        raise InputError(f"the table {str(folder / SET_RUNS)!r} has an entry: {error}") from None
    if not found:
        raise InputError(
            f"the load set {str(folder)!r} has no finished run that counts for fatigue: expected "
            'situations with evaluates = "fatigue"'
        )
    return found, years

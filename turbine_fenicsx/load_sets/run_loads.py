"""Cycles and extremes of blocks of a run, found once and kept in its folder.

A run of duration T has floor(T/T_b) blocks of duration T_b. Reading histories takes seconds, which
``loads.npz`` spares where the tables of a set are made again.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.array_file import read_arrays, write_arrays
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing.cycles import Cycles
from turbine_fenicsx.postprocessing.fatigue import find_cycles, list_loads
from turbine_fenicsx.records import names
from turbine_fenicsx.records.names import TIME, split_unit
from turbine_fenicsx.records.output_folder import LOADS, TimeSeries, is_older
from turbine_fenicsx.records.statistics import read_both_histories

UNITS = ("N", "Nm", "kN", "kN-m", "m")
"""Units of loads and deflections, whose extremes grow with the duration."""


@dataclass(frozen=True, eq=False)
class RunLoads:
    """Cycles and extremes of a run.

    Args:
        cycles: By names of moments of roots and tower base, and of strain gauges.
        columns: Loads and deflections, n in number.
        least: Least values in blocks, shape (blocks, n).
        largest: Largest ones.
    """

    cycles: dict[str, Cycles]
    columns: tuple[str, ...]
    least: Array
    largest: Array


def find_loads(folder: Path, begin: float, block: float) -> RunLoads:
    """Cycles and extremes of a finished run.

    Args:
        folder: Of the run.
        begin: Time before which nothing counts [s].
        block: Duration of the blocks [s].

    Raises:
        ImportError: if rainflow, which counts cycles, is missing.
    """
    path, asked = folder / LOADS, np.array([begin, block])
    if not is_older(path, folder / "history.csv") and (stored := _read(path, asked)):
        return stored
    series = read_both_histories(folder)
    cycles = find_cycles(series, start=begin) if list_loads(series) else {}
    found = RunLoads(cycles, *_find_extremes(series, begin, block))
    write_arrays(path, _as_arrays(found, asked))
    return found


def _find_extremes(
    series: TimeSeries, begin: float, block: float
) -> tuple[tuple[str, ...], Array, Array]:
    """Columns, and their least and largest values in the blocks of a run."""
    time = series[TIME]
    strains = set(names.STRAIN.find(series.columns).values())
    columns = tuple(c for c in series.columns if c in strains or split_unit(c)[1] in UNITS)
    # a row belongs to the step that ends at its time
    place = np.ceil((time - begin) / block * (1.0 - 1e-12)).astype(int) - 1
    number = int((time[-1] - begin) / block * (1.0 + 1e-9))
    rows = [place == k for k in range(number)]
    values = np.array([series[column] for column in columns]).reshape(len(columns), -1).T
    shape = number, len(columns)
    least = np.array([values[own].min(axis=0) for own in rows]).reshape(shape)
    largest = np.array([values[own].max(axis=0) for own in rows]).reshape(shape)
    return columns, least, largest


def _as_arrays(loads: RunLoads, asked: Array) -> dict[str, npt.ArrayLike]:
    """Arrays of the file; those of cycles stand one after another."""
    parts = [np.array([x.ranges, x.means, x.counts]) for x in loads.cycles.values()]
    return {
        "asked": asked,
        "loads": np.array([*loads.cycles], dtype=str),
        "ends": np.cumsum([part.shape[1] for part in parts], dtype=int),
        "cycles": np.concatenate([np.zeros((3, 0)), *parts], axis=1),
        "columns": np.array(loads.columns, dtype=str),
        "extremes": np.array([loads.least, loads.largest]),
    }


def _read(path: Path, asked: Array) -> RunLoads | None:
    """Loads of a file; None if it was made for other times, or is damaged."""
    try:
        stored = read_arrays(path, "a file of cycles")
        if not np.array_equal(stored["asked"], asked):
            return None
        parts = np.split(stored["cycles"], stored["ends"][:-1].astype(int), axis=1)
        parts = parts[: len(stored["loads"])]
        loads = zip(map(str, stored["loads"]), parts, strict=True)
        columns = tuple(map(str, stored["columns"]))
        least, largest = stored["extremes"]
        return RunLoads({name: Cycles(*part) for name, part in loads}, columns, least, largest)
    except (FileError, InputError, KeyError, ValueError, TypeError):
        return None

"""``set.nc``: statistics and fatigue of all finished runs as arrays with names, in NetCDF.

The classic format, which SciPy writes and ``xarray.open_dataset`` opens. Arrays lie over the
coordinates ``run``, ``column`` and, with fatigue, ``load``; what a run lacks is not-a-number.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from turbine_fenicsx.load_sets.lifetime import SetFatigue
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.load_sets.results import Results
from turbine_fenicsx.load_sets.situation import Situation

OF_COLUMNS = ("mean", "deviation", "least", "time_of_least", "largest", "time_of_largest")
"""Statistics by run and column."""


def write_set_arrays(
    runs: Sequence[SetRun],
    situations: Mapping[str, Situation],
    results: Results,
    fatigue: SetFatigue,
) -> bytes:
    """Content of the file; empty before the first run is finished."""
    done = [each for each in runs if each.run.name in results]
    columns = list(dict.fromkeys(x.column for each in done for x in results[each.run.name]))
    if not columns:
        return b""
    loads, names = list(fatigue.slopes), [each.run.name for each in done]
    content = io.BytesIO()
    file = netcdf_file(content, "w", version=2)
    axes = {"run": names, "column": columns, **({"load": loads} if loads else {})}
    for dimension, words in axes.items():
        file.createDimension(dimension, len(words))
        _add_words(file, dimension, dimension, words)
    of_runs: dict[str, list[str]] = {
        "situation": [each.situation for each in done],
        "variant": [each.variant for each in done],
    }
    for name, words in of_runs.items():
        _add_words(file, name, "run", words)
    numbers: dict[str, tuple[str, list[float]]] = {
        "wind_speed": ("m/s", [each.wind for each in done]),
        "yaw_error": ("deg", [degrees(each.yaw_error) for each in done]),
        "seed": ("1", [np.nan if each.seed is None else each.seed for each in done]),
        "safety_factor": ("1", [situations[each.situation].factor for each in done]),
        "times_in_life": ("1", [fatigue.times.get(name, 0.0) for name in names]),
    }
    for name, (unit, values) in numbers.items():
        _add(file, name, ("run",), values).units = unit
    places = {column: k for k, column in enumerate(columns)}
    tables = np.full((len(OF_COLUMNS), len(done), len(columns)), np.nan)
    for i, name in enumerate(names):
        for found in results[name]:
            tables[:, i, places[found.column]] = [getattr(found, what) for what in OF_COLUMNS]
    for what, table in zip(OF_COLUMNS, tables, strict=True):
        _add(file, what, ("run", "column"), table)
    if loads:  # an axis of no length is one without limit
        _add_fatigue(file, names, fatigue)
    file.flush()
    return content.getvalue()


def _add_fatigue(file: Any, names: Sequence[str], fatigue: SetFatigue) -> None:
    """Variables of fatigue, of runs and of the life."""
    loads = list(fatigue.slopes)
    ranges = [[fatigue.of_runs.get(run, {}).get(x, np.nan) for x in loads] for run in names]
    _add(file, "equivalent_range", ("run", "load"), ranges)
    _add(file, "equivalent_range_of_life", ("load",), [fatigue.of_life[x] for x in loads])
    _add(file, "slope", ("load",), [fatigue.slopes[x] for x in loads])


def _add(file: Any, name: str, dimensions: tuple[str, ...], values: Any) -> Any:
    """A variable of numbers."""
    variable = file.createVariable(name, "d", dimensions)
    variable[:] = values
    return variable


def _add_words(file: Any, name: str, dimension: str, words: Sequence[str]) -> None:
    """A variable of texts: bytes of UTF-8 along a second axis, as xarray joins them."""
    encoded = [word.encode() for word in words]
    width = max([1, *map(len, encoded)])
    axis = f"letters_of_{name}"
    file.createDimension(axis, width)
    variable = file.createVariable(name, "c", (dimension, axis))
    variable._Encoding = "utf-8"
    for k, word in enumerate(encoded):
        variable[k] = np.frombuffer(word.ljust(width, b"\0"), "S1")

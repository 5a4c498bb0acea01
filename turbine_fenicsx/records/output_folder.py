"""The files of an output folder, read back: time series, summary, case, times of the fields.

Any defect of a file is one sentence in an `InputError`.
"""

import csv
import json
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from io import TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular, read_regular
from turbine_fenicsx.records.conventions import OPENFAST_HEAD
from turbine_fenicsx.records.names import TIME, Family
from turbine_fenicsx.records.parts import Parts
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile

FATIGUE = "fatigue.csv"
"""Table of the fatigue of a run, or of a load set."""

MARKOV = "markov.csv"
"""Table of numbers of cycles by range and mean, of a run or of the life of a load set."""

LOADS = "loads.npz"
"""Cycles and extremes of blocks of a run of a load set."""

RESULTS = (
    *("history.csv", "history.out", "history.outb", "history.png"),
    *(FATIGUE, MARKOV, "statistics.csv", "summary.json", "case.json"),
    *("plies.csv", "worst.json", "worst.png", "gauges.csv", "sections.csv", "at_*.csv"),
    *("life.csv", "life_*.csv", "life.png", "life_*.png", "life.vtkhdf", "life.vtkhdf.part"),
    *("fields.xdmf", "fields.bin", "fields.[0-9]*.bin", "fields.vtkhdf", "fields.vtkhdf.part"),
    *("wind.xdmf", "wind.bin", "wind.[0-9]*.bin", "wind.vtkhdf", "wind.vtkhdf.part"),
    *("basis_*.npz", "motion.bin", "motion.json", LOADS),
)
"""Names of what a run computes, beside checkpoints and its log."""

MODE_RESULTS = (
    *("damping.csv", "decay.csv", "work.csv", "damping.png"),
    *("modes.csv", "modes.xdmf", "modes.bin", "modes.[0-9]*.bin", "campbell.csv"),
    *("campbell.png", "modes.png", "mode_[0-9]*.png"),
)
"""Names of what belongs to modes."""

STEADY_RESULTS = ("steady.csv", "steady_blade.csv", "steady.yaml", "steady*.png")
"""Names of what belongs to steady states."""

SECTIONS, SECTION_PLIES = "sections.csv", "section_plies.csv"
"""Tables of the sections of a blade, and of their plies under loads, in its output folder."""

STUDY = "study.csv"
"""Table of a study in its output folder."""

SET, SET_RUNS, WINDS, EXTRAPOLATED = "set.csv", "runs.csv", "winds.csv", "extrapolated.csv"
"""Tables of a load set in its output folder: channels, runs, channels at each wind speed, loads of
return periods."""

SET_ARRAYS = "set.nc"
"""Statistics and fatigue of all runs of a load set as arrays."""


@dataclass(frozen=True)
class TimeSeries:
    """Time series of one run.

    Args:
        name: Shown in legends when several runs share a figure.
        columns: Column of ``history.csv`` to its values, each of shape (n_rows,).
    """

    name: str
    columns: dict[str, NDArray[np.float64]]

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """Values of one column, shape (n_rows,)."""
        if column not in self.columns:
            raise InputError(f"history of '{self.name}' has no column '{column}'")
        return self.columns[column]

    def of(self, family: Family, **fields: object) -> dict[str, NDArray[np.float64]]:
        """Values of all columns of a family, by the one field that is not given."""
        found = family.find(self.columns, **fields)
        return {field: self.columns[column] for field, column in found.items()}


def read_history(path: str | os.PathLike[str], name: str | None = None) -> TimeSeries:
    """Read ``history.csv``; a last row that a crash has cut off is left out.

    Args:
        path: CSV file with one header line; empty fields become NaN.
        name: Name of the run; that of its folder if None.

    Raises:
        InputError: if it cannot be read, holds no complete row, or something else than numbers.
    """
    path = Path(path)
    try:
        with TextIOWrapper(open_regular(path), encoding="utf-8", newline="") as file:
            lines = [line for line in csv.reader(file) if line]
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise InputError(f"{path} is not a table of comma-separated numbers") from None
    header = [column.strip() for column in lines[0]] if lines else []
    rows = lines[1:]
    if rows and len(rows[-1]) < len(header):
        rows.pop()
    if not rows:
        raise InputError(f"{path} holds no rows")
    values = np.empty((len(rows), len(header)))
    for number, row in enumerate(rows):
        if len(row) != len(header):
            raise InputError(
                f"{path}: row {number + 1} has {len(row)} fields, the header {len(header)}"
            )
        try:
            values[number] = [float(x) if x.strip() else np.nan for x in row]
        except ValueError as error:
            raise InputError(f"{path}: row {number + 1}: {error}") from None
    columns = {column: values[:, i] for i, column in enumerate(header)}
    series = TimeSeries(name or path.resolve().parent.name, columns)
    if not np.isfinite(series[TIME]).all():
        raise InputError(f"{path}: a row has no time")
    return series


def add_openfast(series: TimeSeries, path: Path, wanted: Sequence[str] | None = None) -> TimeSeries:
    """A run with columns of its ``history.out``, without the initial state.

    Args:
        wanted: Names of columns of either file; those of ``history.out`` with or without the unit.
            All of these with it if None.
    """
    try:
        with TextIOWrapper(open_regular(path), encoding="utf-8") as file:
            lines = file.read().splitlines()
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not text") from None
    if len(lines) <= OPENFAST_HEAD:
        raise InputError(f"{path} holds no rows")
    names, units = (lines[OPENFAST_HEAD - k].split() for k in (2, 1))
    try:
        rows = [line.split() for line in lines[OPENFAST_HEAD:]]
        table = np.array([[float(x) for x in row] for row in rows if len(row) == len(names)])
    except ValueError as error:
        raise InputError(f"{path} has a row that is not of numbers: {error}") from None
    n = min(len(table), len(series[TIME]) - 1)  # there is no row of the initial state
    time = series[TIME][1 : n + 1]
    if n < 1 or len(units) != len(names) or not np.allclose(table[:n, 0], time, rtol=1e-6):
        raise InputError(f"{path} has not the times of history.csv")
    columns = {TIME: time}
    full = [f"{name}_[{unit.strip('()')}]" for name, unit in zip(names, units, strict=True)]
    for name in full[1:] if wanted is None else wanted:
        for k, (short, long) in enumerate(zip(names, full, strict=True)):
            if name in (short, long):
                columns[name] = table[:n, k]
        if name in series.columns:
            columns[name] = series[name][1 : n + 1]
    return TimeSeries(series.name, columns)


def read_histories(folders: Sequence[str | os.PathLike[str]]) -> list[TimeSeries]:
    """Read the time series of several runs, under names that differ."""
    for folder in folders:
        need_folder(folder)
    parts = [Path(folder).resolve().parts for folder in folders]
    if len(set(parts)) < len(parts):
        twice = next(f for f, p in zip(folders, parts, strict=True) if parts.count(p) > 1)
        raise InputError(f"{str(twice)!r} is given twice")
    names, n = [p[-1] for p in parts], 1
    while len(set(names)) < len(names):
        n += 1
        names = ["/".join(p[-n:]) for p in parts]
    return [
        read_history(Path(f) / "history.csv", name) for f, name in zip(folders, names, strict=True)
    ]


def read_tables(path: str | os.PathLike[str]) -> dict[str, Any] | None:
    """Read nested tables from ``summary.json`` or ``case.json``; None if there is no such file.

    Raises:
        InputError: if there is one that does not hold tables.
    """
    try:
        with open_regular(path) as file:
            tables = json.loads(file.read())
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror}") from None
    except (ValueError, RecursionError):
        raise InputError(f"{path} is not valid JSON") from None
    if not isinstance(tables, dict):
        raise InputError(f"{path} holds no tables")
    return tables


def read_solver_tolerance(folder: str | os.PathLike[str]) -> float | None:
    """Relative tolerance of the run in a folder; None if its ``case.json`` does not say."""
    solver = (read_tables(Path(folder) / "case.json") or {}).get("solver")
    tolerance = solver.get("tolerance") if isinstance(solver, dict) else None
    return tolerance if isinstance(tolerance, float) and 0.0 < tolerance < 1.0 else None


def find_fields(folder: str | os.PathLike[str]) -> Path:
    """The fields in an output folder: ``fields.vtkhdf`` if it is there, else ``fields.xdmf``."""
    path = Path(folder) / "fields.vtkhdf"
    return path if path.exists() else path.with_suffix(".xdmf")


def read_field_times(path: str | os.PathLike[str]) -> NDArray[np.float64]:
    """Times [s] in a file of fields, shape (n,), after a look whether their numbers are there.

    VTK may end the process when it is given an incomplete file, so that this comes first.

    Raises:
        InputError: if the file or one of its ``.bin`` files is missing or incomplete.
    """
    path = Path(path)
    if path.suffix == ".vtkhdf":
        with VtkHdfFile(path) as file:
            times = file.times
        if not times.size:
            raise InputError(f"{path} holds no times")
        return times
    try:
        root = ElementTree.fromstring(read_regular(path))
        times = np.array([float(t.attrib["Value"]) for t in root.iter("Time")])
        needed: dict[str, int] = {}
        for item in root.iter("DataItem"):
            name = "".join(item.itertext()).strip()
            count = int(np.prod([int(n) for n in item.attrib["Dimensions"].split()]))
            end = int(item.attrib["Seek"]) + count * int(item.attrib["Precision"])
            needed[name] = max(needed.get(name, 0), end)
    except FileNotFoundError:
        raise InputError(f"there is no {path}; {_explain_no_fields(path.parent)}") from None
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror}") from None
    except (ElementTree.ParseError, KeyError, ValueError):
        raise InputError(f"{path} is not the field output of a run") from None
    if not times.size:
        raise InputError(f"{path} holds no times")
    for name, size in needed.items():
        numbers = path.parent / name
        if not numbers.is_file():
            raise InputError(f"{numbers} is missing, which holds the numbers of {path.name}")
        if numbers.stat().st_size < size:
            raise InputError(f"{numbers} is incomplete: {path.name} needs {size} bytes of it")
    return times


def _explain_no_fields(folder: Path) -> str:
    """Why a folder has no fields."""
    case = read_tables(folder / "case.json") or {}
    blade = case.get("blade")
    if isinstance(blade, dict) and blade.get("model") == "reduced":
        return (
            "reduced blades write no fields: `turbine-fenicsx recover --fields` makes them of "
            "motion.bin"
        )
    return "it is written by a run with output.fields_every greater than 0"


def read_field_parts(path: str | os.PathLike[str]) -> Parts:
    """Names of the parts in a file of fields, and their parent bodies.

    Raises:
        InputError: if the file does not say so.
    """
    try:
        if Path(path).suffix == ".vtkhdf":
            with VtkHdfFile(path) as file:
                found = file.information
        else:
            items = ElementTree.fromstring(read_regular(path)).iter("Information")
            found = {item.attrib["Name"]: item.attrib["Value"] for item in items}
        if "parts" in found:
            return Parts.from_text(found["parts"])
    except (OSError, ElementTree.ParseError, KeyError, ValueError) as error:
        raise InputError(f"cannot read the parts in {os.fspath(path)!r}: {error}") from None
    raise InputError(
        f"{os.fspath(path)!r} does not say what its parts are: an earlier version has written it, "
        "run the case again"
    )


def holds_run(folder: str | os.PathLike[str]) -> bool:
    """Whether there is something in a folder that a run has computed.

    That is a summary, a checkpoint, or more than the first row of a history.
    """
    folder = Path(folder)
    files = [folder / "summary.json", *(folder / "checkpoints").glob("*.npz")]
    if any(path.is_file() for path in files):
        return True
    history = folder / "history.csv"
    if not history.is_file():
        return False
    with history.open("rb") as file:
        return sum(1 for _ in islice(file, 3)) == 3


def keep_results(folder: str | os.PathLike[str], new: str, overwrite: bool) -> None:
    """Refuse a folder that holds a run, or what the user does not want to be replaced.

    Args:
        new: What comes into it, in the plural, for example "modes".

    Raises:
        InputError: if it does.
    """
    if holds_run(folder):
        sentence = f"holds the results of a run; {new} need another folder"
        raise InputError(f"{os.fspath(folder)!r} {sentence}")
    refuse_others(folder, overwrite)


def refuse_others(folder: str | os.PathLike[str], overwrite: bool) -> None:
    """Refuse a folder with results that may not be replaced, by an InputError."""
    kinds = ("modes", holds_modes), ("steady states", holds_steady), ("sections", holds_sections)
    found = [kind for kind, holds in kinds if holds(folder)]
    found += ["dampings"] * (Path(folder) / "damping.csv").is_file()
    if found and not overwrite:
        raise InputError(f"{os.fspath(folder)!r} holds {found[0]}; --overwrite replaces them")


def remove_results(folder: str | os.PathLike[str]) -> None:
    """Remove earlier results, so that nothing of them stands beside the new ones."""
    for pattern in (*RESULTS, *MODE_RESULTS, *STEADY_RESULTS, "sections.*", SECTION_PLIES):
        for path in Path(folder).glob(pattern):
            with name_file_in_errors("write", path):
                path.unlink()


def is_older(path: Path, other: Path) -> bool:
    """Whether a file is missing or was written before another one, which is there."""
    if not other.exists():
        return False
    return not path.exists() or path.stat().st_mtime < other.stat().st_mtime


def holds_modes(folder: str | os.PathLike[str]) -> bool:
    """Whether there are modes in a folder."""
    return (Path(folder) / "modes.csv").is_file()


def holds_set(folder: str | os.PathLike[str]) -> bool:
    """Whether there is a load set in a folder."""
    return (Path(folder) / SET_RUNS).is_file()


def holds_steady(folder: str | os.PathLike[str]) -> bool:
    """Whether there are steady states in a folder."""
    return (Path(folder) / "steady.csv").is_file()


def holds_sections(folder: str | os.PathLike[str]) -> bool:
    """Whether there are sections of a blade in a folder."""
    return (Path(folder) / SECTIONS).is_file()


def need_folder(folder: str | os.PathLike[str]) -> Path:
    """The output folder of a run as a path."""
    if not Path(folder).is_dir():
        raise InputError(f"there is no output folder {os.fspath(folder)!r}")
    if (Path(folder) / STUDY).exists() and not (Path(folder) / "history.csv").exists():
        runs = sorted(x.parent.name for x in Path(folder).glob("*/history.csv"))
        named = f", such as {os.path.join(folder, runs[0])!r}" if runs else ""
        raise InputError(
            f"{os.fspath(folder)!r} is the folder of a study: name one of its runs{named}"
        )
    return Path(folder)


def make_target_folder(folder: str | os.PathLike[str]) -> Path:
    """A folder to write to, made if it does not exist.

    Raises:
        InputError: if nothing can be written there.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"cannot write to {os.fspath(folder)!r}: {error.strerror}") from None
    return Path(folder)

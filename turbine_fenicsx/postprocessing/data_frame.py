"""An output folder as a table of pandas."""

from __future__ import annotations

import os
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.names import TIME
from turbine_fenicsx.records.output_folder import need_folder, read_history, read_tables


def read_run(folder: str | os.PathLike[str]) -> Any:
    """The time series of a run, also of one that is still running.

    Args:
        folder: Output folder.

    Returns:
        A pandas.DataFrame with the columns of ``history.csv``, such as ``"total_energy_[J]"``, and
        the time [s] as index. Its ``attrs`` hold the nested tables "summary" and "case" of
        ``summary.json`` and ``case.json``, where there are such files.

    Raises:
        InputError: if pandas is not installed, there is no such folder, or a file cannot be read.
    """
    try:
        import pandas
    except ImportError:
        raise InputError("read_run needs pandas: pip install pandas") from None
    path = need_folder(folder)
    series = read_history(path / "history.csv")
    columns = {name: values for name, values in series.columns.items() if name != TIME}
    frame = pandas.DataFrame(columns, index=pandas.Index(series[TIME], name=TIME))
    for name in ("summary", "case"):
        tables = read_tables(path / f"{name}.json")
        if tables is not None:
            frame.attrs[name] = tables
    return frame

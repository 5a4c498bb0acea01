"""Files with what is recovered of a run."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.row_file import join_columns
from turbine_fenicsx.turbine.run.ply_history import PlyHistory, PlyRecovery
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
from turbine_fenicsx.turbine.run.worst_moment import WorstMoment, find_worst_moment

PLIES, WORST = "plies.csv", "worst.json"


def list_files(plies: bool, worst: bool) -> list[str]:
    """Names of the files that are wanted."""
    return [name for name, wanted in ((PLIES, plies), (WORST, worst)) if wanted]


def refuse_to_overwrite(folder: str | os.PathLike[str], files: Sequence[str]) -> None:
    """Raise an InputError if a file is there already."""
    for name in files:
        if os.path.lexists(Path(folder) / name):
            raise InputError(
                f"{str(Path(folder) / name)!r} is there already: --overwrite replaces it"
            )


def write(
    run: RecordedRun, files: Sequence[str], criterion: str, progress: Callable[[float], None]
) -> list[str]:
    """Recover what some files need, and write them. Collective.

    Args:
        files: Some of `PLIES` and `WORST`.
        criterion: One of `turbine_fenicsx.materials.ply_failure.CRITERIA`.
        progress: Called with the part that is done, from 0 to 1.

    Returns:
        Lines for people.
    """
    comm, folder, lines = run.turbine.comm, run.folder, []
    recovery = PlyRecovery(run)
    history = recovery.find_history(criterion, progress)
    contents = {}
    if PLIES in files:
        contents[PLIES] = format_history(history)
    if WORST in files:
        worst = find_worst_moment(recovery, history)
        contents[WORST] = format_worst(worst)
        lines.append(str(worst))
    for name, content in contents.items():
        on_rank0(comm, partial(replace_file, folder / name, content.encode()))
    return [*lines, ", ".join(str(folder / name) for name in contents)]


def format_history(history: PlyHistory) -> str:
    """A table of comma-separated numbers with a head."""
    columns = history.columns()
    rows = np.column_stack(list(columns.values())).tolist()
    lines = [join_columns(list(columns)), *(",".join(map(repr, row)) for row in rows)]
    return "\n".join(lines) + "\n"


def format_worst(worst: WorstMoment) -> str:
    """All that is known of the moment; strengths that are not known are null."""
    data = asdict(worst)
    data["strengths"] = [x if np.isfinite(x) else None for x in worst.strengths]
    return json.dumps(data | {"mode": worst.mode}, indent=2) + "\n"

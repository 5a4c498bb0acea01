"""Files with what is recovered of a run."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.row_file import join_columns
from turbine_fenicsx.records.vtkhdf_layout import need_h5py
from turbine_fenicsx.turbine.run.chosen_rows import find_rows_every
from turbine_fenicsx.turbine.run.gauge_history import find_gauge_history
from turbine_fenicsx.turbine.run.run_recovery import RunRecovery
from turbine_fenicsx.turbine.run.section_history import find_section_history
from turbine_fenicsx.turbine.run.wall_history import WallPlace, find_wall_history
from turbine_fenicsx.turbine.run.worst_moment import WorstMoment

PLIES, WORST, FIELDS = "plies.csv", "worst.json", "fields.vtkhdf"
GAUGES, SECTIONS = "gauges.csv", "sections.csv"


def refuse_to_overwrite(folder: str | os.PathLike[str], files: Sequence[str]) -> None:
    """Raise an InputError if a file is there already."""
    for name in files:
        if os.path.lexists(Path(folder) / name):
            raise InputError(
                f"{str(Path(folder) / name)!r} is there already: --overwrite replaces it"
            )


def write_plies(recovery: RunRecovery, criterion: str) -> Path:
    """Write the history of each panel and web; the file. Collective."""
    return _replace(recovery, PLIES, format_columns(recovery.find_history(criterion).columns()))


def write_worst(recovery: RunRecovery, criterion: str) -> tuple[WorstMoment, Path]:
    """Find the moment nearest to failure and write it; it and the file. Collective."""
    worst = recovery.find_worst(criterion)
    return worst, _replace(recovery, WORST, format_worst(worst))


def write_place(recovery: RunRecovery, place: WallPlace, criterion: str) -> tuple[str, Path]:
    """Write the history of the plies at a place; lines for people, and the file. Collective."""
    found = find_wall_history(recovery.plies, place, criterion)
    return str(found), _replace(recovery, name_place(place), format_columns(found.columns))


def write_gauges(recovery: RunRecovery) -> Path:
    """Write the history of the gauges of the case; the file. Collective."""
    return _replace(recovery, GAUGES, format_columns(find_gauge_history(recovery.run)))


def write_sections(recovery: RunRecovery, places: Sequence[float]) -> Path:
    """Write the history of the loads in sections of beams; the file. Collective."""
    columns = find_section_history(recovery.run, places)
    return _replace(recovery, SECTIONS, format_columns(columns))


def name_place(place: WallPlace) -> str:
    """The file with the history of a place."""
    return f"at_{place.label}.csv"


def write_fields(
    recovery: RunRecovery,
    wanted: Sequence[str] | None,
    texts: Sequence[str],
    every: tuple[float, float | None, float | None] | None,
) -> Path:
    """Write fields on the full meshes; the file. Collective.

    Args:
        wanted: Names of the fields; None for those of a run.
        texts: Times, see `turbine_fenicsx.turbine.run.chosen_rows`.
        every: Distance, begin and end of other times [s], which are then taken; None for none.
    """
    comm, times = recovery.run.turbine.comm, recovery.run.motion.times
    on_rank0(comm, need_h5py)
    fields = recovery.find_fields(wanted)
    rows = recovery.find_rows(texts) if every is None else find_rows_every(times, *every)
    path = recovery.run.folder / FIELDS
    fields.write(path, rows, recovery.progress)
    return path


def _replace(recovery: RunRecovery, name: str, content: str) -> Path:
    """Write a text file."""
    path = recovery.run.folder / name
    on_rank0(recovery.run.turbine.comm, partial(replace_file, path, content.encode()))
    return path


def format_columns(columns: Mapping[str, Array]) -> str:
    """A table of comma-separated numbers with a head."""
    rows = np.column_stack(list(columns.values())).tolist()
    lines = [join_columns(list(columns)), *(",".join(map(repr, row)) for row in rows)]
    return "\n".join(lines) + "\n"


def format_worst(worst: WorstMoment) -> str:
    """All that is known of the moment; strengths that are not known are null."""
    data = asdict(worst)
    data["strengths"] = [x if np.isfinite(x) else None for x in worst.strengths]
    return json.dumps(data | {"mode": worst.mode}, indent=2) + "\n"

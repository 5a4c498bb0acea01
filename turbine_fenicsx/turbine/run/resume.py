"""The case of an output folder: written, and read again by a resumed run."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.case.files import change_files, hash_files, make_absolute
from turbine_fenicsx.case.rules import remove_refused_keys
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.output_folder import holds_modes, holds_steady, read_tables
from turbine_fenicsx.reduction.basis_file import read_sizes
from turbine_fenicsx.turbine.case.case import Case, apply_overrides
from turbine_fenicsx.turbine.tables.tables import Tables

log = logging.getLogger(__name__)

FREE = ("title", "time", "solver", "life", "output")
"""Parts of a case that may change on restart."""

BASES = {"blade": "basis_blades.npz", "tower": "basis_tower.npz"}
"""Bases of reduced bodies in an output folder, by the table of the body."""

OF_THE_START = ("start", "ramp")
"""Keys of the table ``time`` that say how a run began."""


def label_case(case: Case) -> dict[str, str]:
    """Labels in which a checkpoint and the run that reads it must agree."""
    data = case.model_dump(mode="json", exclude=set(FREE))
    for table in BASES:  # a checkpoint knows the functions of its vectors
        del data[table]["reduction"]["file"]
    tables = change_files(data, Tables, lambda mark, name: mark.what)
    return {
        "kind of the controller": case.control.kind.partition(":")[0],
        "case": hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16],
        **hash_files(make_absolute(data, Tables), Tables),
    }


def change_case(folder: Path, overrides: list[str]) -> Case:
    """The case of an output folder with changes."""
    data = _read_case(folder, "to resume")
    old, new = Case.parse(data), apply_overrides(data, overrides)
    for name in type(old).model_fields:
        mine, theirs = getattr(new, name), getattr(old, name)
        if name not in FREE and mine != theirs:
            keys = [k for k in type(mine).model_fields if getattr(mine, k) != getattr(theirs, k)]
            raise InputError(
                f"{name}.{keys[0]} cannot change in a resumed run; only {', '.join(FREE)} can"
            )
    for key in OF_THE_START:
        if getattr(new.time, key) != getattr(old.time, key):
            raise InputError(f"time.{key} cannot change in a resumed run; it is how it began")
    if new.output.format != old.output.format:
        raise InputError("output.format cannot change in a resumed run, whose fields go on")
    for key, file in (("gauges", "history.csv"), ("channels", "history.out")):
        if getattr(new.output, key) != getattr(old.output, key):
            raise InputError(
                f"output.{key} cannot change in a resumed run; {file} keeps its columns"
            )
    return new


def read_case(folder: Path, overrides: Iterable[str] = ()) -> Case:
    """The case of an output folder, with the bases in it, and with changes."""
    return apply_overrides(_read_case(folder, "with reduced parts or beams"), overrides)


def _read_case(folder: Path, purpose: str) -> dict[str, Any]:
    """The tables of a case, with the bases of its run, wherever they were taken from.

    Args:
        purpose: What the run is needed for, for the error.
    """
    data = read_tables(folder / "case.json")
    if data is None or holds_modes(folder) or holds_steady(folder):
        raise InputError(f"there is no run in {str(folder)!r} {purpose}")
    for table, name in BASES.items():
        if _is_basis(folder / name):
            data[table]["reduction"]["file"] = str(folder / name)
    return data


def _is_basis(path: Path) -> bool:
    """Whether a file holds a basis; the run writes missing and damaged ones again."""
    if not path.exists():
        return False
    try:
        read_sizes(path)
    except (InputError, FileError) as error:
        log.info("%s; it is written again", error)
        return False
    return True


def fix_duration(case: Case) -> Case:
    """A case whose turbulence lasts as long as before when the end of the run changes."""
    t = case.wind.turbulence
    if not t.is_made or t.duration is not None:
        return case
    fixed = t.model_copy(update={"duration": t.find_duration(case.time.end)})
    wind = case.wind.model_copy(update={"turbulence": fixed})
    return case.model_copy(update={"wind": wind})


def write_case(case: Case, folder: Path, comm: MPI.Intracomm) -> None:
    """Write the case with all defaults, files by their absolute paths."""
    data = remove_refused_keys(case, make_absolute(case.model_dump(mode="json"), Tables))
    text = json.dumps(data, indent=2) + "\n"
    on_rank0(comm, lambda: replace_file(folder / "case.json", text.encode()))

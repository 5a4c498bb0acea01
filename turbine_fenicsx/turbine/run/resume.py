"""The case of an output folder: written, and read again by a resumed run."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import open_regular, replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.output_folder import holds_modes, read_tables
from turbine_fenicsx.turbine.case.aero_blade import find_aero_file
from turbine_fenicsx.turbine.case.case import Case, apply_overrides
from turbine_fenicsx.turbine.case.turbine_file import FOREIGN

FREE = ("title", "time", "solver", "output")
"""Parts of a case that may change on restart."""

FILES = ("mesh", "turbine", "wind", "aero", "loads", "pitch")
"""Tables that name a file of data."""

OF_THE_START = ("start", "ramp")
"""Keys of the table ``time`` that say how a run began."""


def label_case(case: Case) -> dict[str, str]:
    """Labels in which a checkpoint and the run that reads it must agree."""
    tables = case.model_dump(mode="json", exclude=set(FREE))
    files = {table: tables[table].pop("file") for table in FILES}
    if files["aero"]:
        files["aero"] = find_aero_file(case)
    for key in ("kind", "library", "input"):
        del tables["control"][key]
    labels = {
        "kind of the controller": case.control.kind.partition(":")[0],
        "case": hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16],
        "mesh": _hash_file(files["mesh"], "built in"),
        "windIO file": _hash_file(files["turbine"], "none"),
    }
    for table in ("wind", "loads", "pitch"):
        if files[table]:
            labels[f"{table} file"] = _hash_file(files[table], "none")
    if files["aero"]:
        labels["aerodynamics file"] = _hash_file(find_aero_file(case), "none")
    labels.update({what: _hash_file(name, "none") for what, name in case.control.files.items()})
    return labels


def _hash_file(path: str | None, otherwise: str) -> str:
    """Hash of the contents of a file; a word without one."""
    if not path:
        return otherwise
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


def change_case(folder: Path, overrides: list[str]) -> Case:
    """The case of an output folder with changes.

    Raises:
        InputError: if there is none, or something changes that may not.
    """
    data = read_tables(folder / "case.json")
    if data is None or holds_modes(folder):
        raise InputError(f"there is no run in {str(folder)!r} to resume")
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
    if new.output.gauges != old.output.gauges:
        raise InputError(
            "output.gauges cannot change in a resumed run; history.csv keeps its columns"
        )
    return new


def write_case(case: Case, folder: Path, comm: MPI.Intracomm) -> None:
    """Write the case with all defaults, files by their absolute paths."""
    data = case.model_dump(mode="json")
    for table in ("mesh", "wind", "loads", "pitch"):
        if data[table]["file"]:
            data[table]["file"] = os.path.abspath(data[table]["file"])
    if case.aero.file:
        data["aero"]["file"] = os.path.abspath(find_aero_file(case))
    if case.turbine.file:
        data["turbine"]["file"] = os.path.abspath(case.turbine.file)
        for table, names in FOREIGN.items():
            data[table] = {key: v for key, v in data[table].items() if key not in names}
    text = json.dumps(data, indent=2) + "\n"
    on_rank0(comm, lambda: replace_file(folder / "case.json", text.encode()))

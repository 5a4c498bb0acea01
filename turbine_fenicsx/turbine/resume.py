"""Going on with a run: its case, which may change in parts, and what may not change."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.output_folder import read_tables
from turbine_fenicsx.turbine.case.case import Case, apply_overrides

FREE = ("title", "time", "solver", "output")
"""Parts of a case that may change when a run goes on."""


def label_case(case: Case) -> dict[str, str]:
    """What a checkpoint and the run that reads it must agree in."""
    tables = case.model_dump(mode="json", exclude=set(FREE))
    mesh = tables["mesh"].pop("file")
    return {
        "case": hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16],
        "mesh": hashlib.sha256(Path(mesh).read_bytes()).hexdigest()[:16] if mesh else "built in",
    }


def change_case(folder: Path, overrides: list[str]) -> Case:
    """The case of an output folder with changes.

    Raises:
        InputError: if there is none, or something changes that may not.
    """
    data = read_tables(folder / "case.json")
    if data is None:
        raise InputError(f"there is no run in {str(folder)!r} to go on with")
    old, new = Case.parse(data), apply_overrides(data, overrides)
    for name in type(old).model_fields:
        mine, theirs = getattr(new, name), getattr(old, name)
        if name not in FREE and mine != theirs:
            keys = [k for k in type(mine).model_fields if getattr(mine, k) != getattr(theirs, k)]
            raise InputError(
                f"{name}.{keys[0]} cannot change when a run goes on; only {', '.join(FREE)} can"
            )
    return new

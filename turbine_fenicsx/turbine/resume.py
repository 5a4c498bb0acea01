"""Going on with a run: its case, which may change in parts, and the checkpoint to start from."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from turbine_fenicsx import __version__
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.output_folder import read_tables
from turbine_fenicsx.simulation.checkpoint import load_newest
from turbine_fenicsx.simulation.observers.history import read_history_rows
from turbine_fenicsx.simulation.observers.openfast import read_out_rows
from turbine_fenicsx.simulation.observers.row_file import rows_until
from turbine_fenicsx.simulation.observers.stored_grids import stored_grids
from turbine_fenicsx.system.restart_data import RestartData
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.case.case import Case, changed

FREE = ("title", "time", "solver", "output")
"""Parts of a case that may change when a run goes on."""


def find_checkpoint(
    folder: Path, out: str | os.PathLike[str], system: MultibodySystem, labels: dict[str, str]
) -> RestartData:
    """The newest checkpoint of a run that is intact and that its series reach. Collective.

    Args:
        folder: Output folder of the run.
        out: The folder as the user has written it.
        system: The system, on any number of ranks.
        labels: What the checkpoint must agree in.

    Raises:
        InputError: if there is none, or it belongs to something else.
    """

    def check(found: dict[str, str]) -> None:
        for name, mine in labels.items():
            if found.get(name) != mine:
                raise InputError(
                    f"cannot go on with {os.fspath(out)!r}: the {name} has changed, it was "
                    f"{found.get(name)} and is {mine}"
                )

    return load_newest(
        folder / "checkpoints", system, check, lambda data: list_shortfalls(folder, data)
    )


def list_shortfalls(folder: Path, data: RestartData) -> list[str]:
    """What the series in a folder lack of what they had when a checkpoint was written.

    Args:
        folder: Output folder of the run.
        data: What the checkpoint knows.

    Returns:
        A clause for each series that does not reach the checkpoint.
    """
    time = float(data.numbers["state.time"])
    last = time + 1e-9 * max(1.0, abs(time))
    history, out, fields = (
        data.part(f"observer.{name}").numbers
        for name in ("history.csv", "history.out", "fields.xdmf")
    )
    counts = []
    if history:
        rows = read_history_rows(folder / "history.csv", history["columns"])
        counts.append(("history.csv", len(rows_until(rows, last, ",")), history["rows"], "rows"))
    if out:
        rows = read_out_rows(folder / "history.out", out["columns"])
        counts.append(("history.out", len(rows_until(rows, last, "\t")), out["rows"], "rows"))
    if fields:
        first = time - 1e-9 * max(1.0, abs(time))  # the run writes that of the checkpoint again
        times = [grid.time for grid in stored_grids(folder / "fields.xdmf") if grid.time < first]
        needed = fields["times"] - (fields["times"] > 0 and fields["last_time"] >= first)
        counts.append(("fields.xdmf", len(times), needed, "times"))
    return [
        f"{name} holds {there} of its {needed} {what} up to t = {time:g} s"
        for name, there, needed, what in counts
        if there < needed
    ]


def label_case(case: Case) -> dict[str, str]:
    """What a checkpoint and the run that reads it must agree in."""
    tables = case.model_dump(mode="json", exclude=set(FREE))
    mesh = tables["mesh"].pop("file")
    return {
        "version of turbine_fenicsx": __version__,
        "case": hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16],
        "mesh": hashlib.sha256(Path(mesh).read_bytes()).hexdigest()[:16] if mesh else "built in",
    }


def changed_case(folder: Path, overrides: list[str]) -> Case:
    """The case of an output folder with changes.

    Raises:
        InputError: if there is none, or something changes that may not.
    """
    data = read_tables(folder / "case.json")
    if data is None:
        raise InputError(f"there is no run in {str(folder)!r} to go on with")
    old, new = Case.parse(data), changed(data, overrides)
    for name in type(old).model_fields:
        mine, theirs = getattr(new, name), getattr(old, name)
        if name not in FREE and mine != theirs:
            keys = [k for k in type(mine).model_fields if getattr(mine, k) != getattr(theirs, k)]
            raise InputError(
                f"{name}.{keys[0]} cannot change when a run goes on; only {', '.join(FREE)} can"
            )
    return new

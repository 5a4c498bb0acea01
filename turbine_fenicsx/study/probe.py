"""Available quantities of a study, found by one short run before all others."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.study.execute import Outcome, execute
from turbine_fenicsx.study.file import flatten
from turbine_fenicsx.study.plan import Run, format_case
from turbine_fenicsx.study.results import find_quantity, read_results
from turbine_fenicsx.turbine.case.case import Case

_COARSE = {"elements": (1, 1, 2)}
_COARSE_HOLLOW = {"span": 6, "around": 16}
_COARSE_TOWER = {"elements": (4, 1, 2), "degree": 1}


def check_quantities(runs: Sequence[Run], names: Sequence[str]) -> None:
    """Make one step of each kind of case, on a mesh of a few cells, and look for the quantities.

    Args:
        runs: Runs that are not finished yet.
        names: Quantities, with or without their units.

    Raises:
        InputError: if a quantity is none of those that a run writes.
        KeyboardInterrupt: after Ctrl-C.
    """
    kinds = {_kind(run.case): run.case for run in runs}
    if not names or not kinds:
        return
    with tempfile.TemporaryDirectory(prefix="study_") as folder:
        probes = []
        for k, case in enumerate(kinds.values()):
            small = _shrink(case)
            probes.append(Run(f"probe_{k}", {}, small, format_case(small)))
        outcomes: list[Outcome] = []
        execute(probes, Path(folder), 1, (), outcomes.append)
        for outcome in outcomes:
            if outcome.reason:
                continue  # the run itself will say it, with its own mesh
            found = read_results(Path(folder) / outcome.run.name)
            for name in names:
                find_quantity(found, name)


def _kind(case: Case) -> tuple[Any, ...]:
    """What decides about the quantities of a case: everything in it that is no number or text."""
    kinds = [value for _, value in flatten(case.model_dump()) if isinstance(value, bool)]
    return (case.turbine.model, case.pitch.drive, *kinds)


def _shrink(case: Case) -> Case:
    """One step of the same case on a mesh of a few cells; the columns are the same."""
    tables = case.model_dump(exclude_unset=True)
    tables.setdefault("time", {})["end"] = case.time.step
    tables["mesh"] = _COARSE_HOLLOW if case.turbine.file else _COARSE
    tables["tower"] = tables.get("tower", {}) | _COARSE_TOWER
    try:
        return Case.parse(tables)
    except InputError:  # the shape of the blades is only in the file of the mesh
        return Case.parse({name: t for name, t in tables.items() if name != "blade"})

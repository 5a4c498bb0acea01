"""Modes at one place after another, such as speeds of the rotor or of the wind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from turbine_fenicsx.analysis.mode import Modes
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.foundation.interrupts import end_immediately_alone
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records.output_folder import make_target_folder, remove_results
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.modes.mode_files import (
    ModeTable,
    Place,
    write_shapes,
    write_tables,
)
from turbine_fenicsx.turbine.modes.mode_table import describe_modes
from turbine_fenicsx.turbine.run.resume import write_case


class Found(NamedTuple):
    """Modes at a place.

    Attributes:
        names: Of the modes; by their shapes if None.
    """

    modes: Modes
    place: Place
    names: Sequence[str] | None = None


Finder = Callable[[Modes | None], Found | None]
"""Finds the modes at a place, in the order of those before; None if there are none."""


def find_series(
    turbine: Turbine,
    finders: Sequence[Finder],
    count: int,
    found: Callable[[ModeTable], bool],
) -> tuple[list[ModeTable], Modes]:
    """Find modes place by place. Collective.

    Args:
        finders: What finds them at each place, some more than wanted.
        count: Number of modes that are wanted.
        found: Called after each place; where it returns True on any rank, no more are looked at.

    Returns:
        The modes at each place, and those at the last one, which the caller frees.

    Raises:
        StepFailure: if there are modes at none of the places.
        KeyboardInterrupt: if a signal came before the first were found.
    """
    comm, tables = turbine.comm, list[ModeTable]()
    before: Modes | None = None
    for find in finders:
        try:
            with end_immediately_alone(comm):
                here = find(before)
                if here is None:
                    continue
                named, rows = describe_modes(turbine, here.modes)
        except KeyboardInterrupt:
            if before is None:
                raise
            break
        if before is not None:
            free_modes(before)
        before = named
        if here.names is not None:
            rows = [replace(row, name=x) for row, x in zip(rows, here.names, strict=True)]
        tables.append(ModeTable(here.place, tuple(rows[:count])))
        if comm.allreduce(bool(found(tables[-1]))):
            break
    if before is None:
        raise StepFailure("there are modes at none of the places")
    for mode in before.modes[count:]:
        mode.destroy()
    return tables, replace(before, modes=before.modes[:count])


def write_series(
    case: Case, turbine: Turbine, folder: Path, tables: Sequence[ModeTable], last: Modes
) -> list[str]:
    """Write tables, the shapes at the last place, and the case; names of the files. Collective."""
    on_rank0(turbine.comm, partial(make_target_folder, folder))
    on_rank0(turbine.comm, partial(remove_results, folder))
    write_case(case, folder, turbine.comm)
    files = write_tables(folder, turbine, tables)
    return [*files, write_shapes(folder, turbine, last, tables[-1])]


def free_modes(modes: Modes) -> None:
    """Free modes and their state. Collective."""
    modes.destroy()
    modes.state.destroy()

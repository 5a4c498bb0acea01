"""The fields of a turbine, as pictures need them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from turbine_fenicsx.simulation.observers.cell_values import CellValues
from turbine_fenicsx.simulation.observers.fields import Fields
from turbine_fenicsx.turbine.components.component import Turbine


def make_fields(
    turbine: Turbine,
    path: Path,
    every: float,
    end: float,
    more: Sequence[CellValues] | None = None,
    wanted: Collection[str] | None = None,
) -> Fields:
    """All parts of a turbine with their names, see `Fields`. Collective.

    Args:
        more: More fields in the cells; those of its components if None.
        wanted: Names of the fields; None for all.
    """
    return Fields(
        turbine.system,
        path,
        every,
        end,
        turbine.surfaces(),
        turbine.parts_of_cells(),
        turbine.part_names(),
        turbine.fields() if more is None else more,
        wanted,
    )

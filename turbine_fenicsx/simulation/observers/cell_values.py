"""More numbers for the cells of the field output."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State


@dataclass(frozen=True, eq=False)
class CellValues:
    """A field of one number for each cell of a flexible body.

    Args:
        name: Name of the field in the output; several bodies may have the same.
        values: Function of the state that returns a number for each cell that this rank owns,
            shape (cells,); called on all ranks.
    """

    name: str
    body: FlexibleBody
    values: Callable[[State], Array]


def gather_values(
    fields: Sequence[CellValues], bodies: Sequence[tuple[DeformableBody, int]], state: State
) -> dict[str, Array]:
    """The numbers of all cells of each field, 0 in bodies without it. Collective.

    Args:
        bodies: All bodies, with their numbers of cells on this rank.

    Returns:
        By the name of the field, shape (cells of all bodies,).
    """
    starts = np.cumsum([0, *(n for _, n in bodies)])
    of_body = {body: slice(*starts[k : k + 2]) for k, (body, _) in enumerate(bodies)}
    found = {field.name: np.zeros(starts[-1]) for field in fields}
    for field in fields:
        found[field.name][of_body[field.body]] = field.values(state)
    return found

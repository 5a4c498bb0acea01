"""Fields of a recorded run on the full meshes of its bodies."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import suggest
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.simulation.observers.cell_values import CellValues
from turbine_fenicsx.simulation.observers.fields import MOTIONS, list_fields
from turbine_fenicsx.simulation.observers.ply_failure import failure_field
from turbine_fenicsx.turbine.components.flexible_blades import find_plies
from turbine_fenicsx.turbine.run.full_motion import FullMotion
from turbine_fenicsx.turbine.run.turbine_fields import make_fields

CARRIED = "displacement"
"""Field that pictures depend on, which is always written."""


class FieldRecovery:
    """Writes what a run with full bodies writes, and failure by all criteria. Collective.

    Args:
        motion: The motion.
        wanted: Names of fields; None for those that a run writes.

    Raises:
        InputError: for an unknown field.
    """

    def __init__(self, motion: FullMotion, wanted: Collection[str] | None = None) -> None:
        plies, case = find_plies(motion.turbine), motion.turbine.case
        more: list[CellValues] = []
        if plies is not None:
            more = [failure_field(plies.stresses, name, plies.made_up) for name in CRITERIA]
        known, usual = list_fields(more), list_fields(more[:1])
        if case.has_beam_blades or case.has_beam_tower:
            known = usual = list(MOTIONS)
        for name in wanted or ():
            if name not in known:
                raise InputError(
                    f"there is no field {name!r}, but {', '.join(known)}{suggest(name, known)}"
                )
        wanted = usual if wanted is None else wanted
        self._motion, self._more, self._wanted = motion, more, {CARRIED, *wanted}

    def write(
        self,
        path: str | os.PathLike[str],
        rows: Sequence[int],
        progress: Callable[[float], None] = lambda part: None,
    ) -> None:
        """Write the fields of some rows of the motion.

        Args:
            path: The file, ``.vtkhdf`` or ``.xdmf``; one that is there is replaced.
            rows: Numbers of the rows, rising.
            progress: Called with the part that is done, from 0 to 1.
        """
        fields = make_fields(
            self._motion.turbine, Path(path), np.inf, np.inf, self._more, self._wanted
        )
        series = fields.open(Path(path), None, len(rows))
        for k, row in enumerate(rows, start=1):
            fields.write(series, self._motion.find_state(row))
            progress(k / len(rows))
        series.finish()

"""Forces and moments in sections of beam blades over a recorded run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.section_loads import BeamLoads
from turbine_fenicsx.turbine.components.axes import blade_axes
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.components.slender_loads import name_sections
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun

BLOCK = 500
"""Rows of the motion that are looked at together."""


def find_section_history(run: RecordedRun, places: Sequence[float]) -> dict[str, Array]:
    """Time, and the loads of `BeamLoads` in all blades, by the names of columns. Collective.

    Args:
        places: Fractions of the length of the axis.

    Raises:
        InputError: for other blades than beams, and places beyond their ends.
    """
    if not run.turbine.case.has_beam_blades:
        raise InputError("--sections: only beam blades have loads in sections")
    for place in places:
        if not 0.0 <= place <= 1.0:
            raise InputError(f"--sections {place:g}: expected fractions of the span from 0 to 1")
    turbine = run.turbine
    axes = blade_axes(turbine.rotor.layout, 1)
    loads = BeamLoads(turbine.system, turbine.part(BODY), places, axes)
    vectors, found = run.motion.vectors[BODY], []
    for first in range(0, len(run.motion.times), BLOCK):
        rows = vectors[first : first + BLOCK]
        of_rows = loads.evaluate(rows.reshape(-1, *rows.shape[2:]))
        found.append(of_rows.reshape(len(rows), -1))
    columns = np.concatenate(found).T
    return {names.TIME: run.motion.times, **dict(zip(name_sections(places), columns, strict=True))}

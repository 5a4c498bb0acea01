"""Strain gauges on the blades over a recorded run, also where the run had none."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.components.gauges import make_gauges
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun


def find_gauge_history(run: RecordedRun) -> dict[str, Array]:
    """Time and the strain of each gauge of the case, by the names of columns. Collective.

    Raises:
        InputError: for a case without gauges, or with rigid blades.
    """
    if BODY not in run.reduced:
        raise InputError("rigid blades have no strains for a gauge")
    gauges = make_gauges(run.turbine, run.turbine.part(BODY))
    if gauges is None:
        raise InputError(
            "the case has no gauge: --set output.gauges.NAME.station=0.3 makes one, see "
            "howto/stress"
        )
    strains = np.array([gauges.strains(state) for state in run.list_states()])
    columns = [names.STRAIN(gauge=gauge.name) for gauge in gauges.gauges]
    return {names.TIME: run.motion.times, **dict(zip(columns, strains.T, strict=True))}

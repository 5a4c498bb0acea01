"""The blades of a case as aerodynamics sees them, from a file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from turbine_fenicsx.case.files import read_if_changed
from turbine_fenicsx.turbine.case.turbine_file import give_hub, load_turbine
from turbine_fenicsx.turbine.tables.named_files import is_windio, list_parts
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.aerodyn_files import read_aerodyn
from turbine_fenicsx.wind.resampling import place_stations, resample_blade


def find_aero_file(case: Tables) -> str:
    """The file with the aerodynamics of the blades."""
    from turbine_fenicsx.windio import find_turbine_file

    name = case.turbine.file if case.aero.file is None else case.aero.file
    assert name is not None
    return str(find_turbine_file(name)) if is_windio(name) else name


def load_aero_blade(case: Tables, stations: int | None = None) -> AeroBlade:
    """A blade at the stations of a quadrature over its span.

    Args:
        stations: Their number; that of the case if None.
    """
    number = case.aero.stations if stations is None else stations
    return _load(find_aero_file(case), number, case.blade.hub_radius)


@read_if_changed(parts=list_parts)
def _load(path: str, stations: int, hub_radius: float) -> AeroBlade:
    """The blade of a file."""
    if is_windio(path):
        from turbine_fenicsx.wind.windio_blade import make_aero_blade

        turbine = give_hub(load_turbine(path), hub_radius)
        hub, axis = turbine.hub.radius, turbine.blade.outer_shape.axis[2]
        tip = hub + float(axis.smooth(np.array([1.0]))[0])
        radius, lengths = place_stations(hub, tip, stations)
        return replace(make_aero_blade(turbine, radius), lengths=lengths)
    blade = read_aerodyn(path, hub_radius)
    radius, lengths = place_stations(blade.hub_radius, blade.tip_radius, stations)
    return replace(resample_blade(blade, radius), lengths=lengths)

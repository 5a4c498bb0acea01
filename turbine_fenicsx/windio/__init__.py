"""Turbines described by files of windIO 2: blades with their layup, hub, nacelle, tower."""

from turbine_fenicsx.windio.blade import WindIOBlade
from turbine_fenicsx.windio.files import find_turbine_file
from turbine_fenicsx.windio.materials import WindIOMaterial
from turbine_fenicsx.windio.turbine import WindIOTurbine, read_turbine

__all__ = [
    "WindIOBlade",
    "WindIOMaterial",
    "WindIOTurbine",
    "find_turbine_file",
    "read_turbine",
]

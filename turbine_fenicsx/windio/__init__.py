"""Turbines described by files of windIO 2: blades with their layup, hub, nacelle, tower."""

from turbine_fenicsx.windio.blade import WindIOBlade as WindIOBlade
from turbine_fenicsx.windio.files import find_turbine_file as find_turbine_file
from turbine_fenicsx.windio.materials import WindIOMaterial as WindIOMaterial
from turbine_fenicsx.windio.turbine import WindIOTurbine as WindIOTurbine
from turbine_fenicsx.windio.turbine import read_turbine as read_turbine

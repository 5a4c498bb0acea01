"""The tables of the wind and of the aerodynamics of the blades."""

from __future__ import annotations

import os
from contextlib import suppress
from math import pi
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from turbine_fenicsx.case.files import DataFile, find_beside
from turbine_fenicsx.case.quantities import (
    Density,
    Metres,
    Number,
    Radians,
    Seconds,
    Speed,
    Whole,
)
from turbine_fenicsx.case.section import Flag, NotNegative, Positive, Section
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.wind.inflow import FASTEST

STEEPEST = pi / 3.0
"""Largest angle between wind and ground [rad]."""

TABLES = (".csv", ".wnd", ".hh")
"""Endings of files with tables of wind."""

Angle = Annotated[Radians, Field(ge=-pi, le=pi)]
Points = Annotated[Whole, Field(ge=2, le=100_000)]
Distance = Annotated[Metres, Positive]
Scale = Annotated[Number, Field(ge=-100.0, le=100.0)]


class BoxCase(Section):
    """Turbulence box of Mann's model or HAWC2: three ``files`` with u, v and w.

    They hold fluctuations, which the steady wind of ``wind.speed`` and ``wind.shear`` carries
    along; the middle of the box is at the height of the hub.
    """

    files: Annotated[tuple[str, str, str] | None, DataFile("turbulence box")] = None
    """Binary files with u, v and w, relative to the case file, see howto/turbulence."""
    points: tuple[Points, Points, Points] | None = None
    """Number of points along the wind, across it and upwards."""
    spacing: tuple[Distance, Distance, Distance] | None = None
    """Distances between points along the wind, across it and upwards."""
    periodic: Flag = True
    """Whether the box restarts when it has passed; else it must last for the run."""
    scale: tuple[Scale, Scale, Scale] = (1.0, 1.0, 1.0)
    """Factors for u, v and w, such as those that give a standard deviation."""


class WindCase(Section):
    """The wind, which blows along e3 at the height of the hub; none without ``speed`` or ``file``.

    It is steady with a power law over the height, or one of the transients of IEC 61400-1 that
    begins at ``gust_start``, or has the turbulence of a box below. Or it comes from a ``file``:
    turbulence of TurbSim (``.bts``), or a table over the time, comma-separated (``.csv``) or
    OpenFAST's uniform wind (``.wnd``, ``.hh``). It sets in smoothly in the time ``ramp``.
    """

    speed: Annotated[Speed, Field(ge=0.0, le=FASTEST)] | None = None
    """Wind speed at the height of the hub; none: no wind, see howto/wind."""
    file: Annotated[str | None, DataFile("wind file")] = None
    """In place of ``speed``: full-field file of TurbSim (``.bts``), or a table over the time
    (``.csv``, ``.wnd``, ``.hh``, see howto/tables), relative to the case file."""
    shear: Annotated[Number, Field(ge=0.0, le=2.0)] = 0.2
    """Exponent of the power law over the height; 0.2 is the normal wind profile of IEC 61400-1."""
    hub_height: Annotated[Metres, Positive] | None = None
    """Height of the rotor centre above ground; none: ``tower.height`` and ``turbine.hub_rise``, or
    that of ``turbine.file``."""
    direction: Angle = 0.0
    """Angle of the wind with e₃, positive towards e₁."""
    inclination: Annotated[Radians, Field(ge=-STEEPEST, le=STEEPEST)] = 0.0
    """Upward angle of a steady wind."""
    gust: Literal["none", "EOG", "EDC", "ECD", "EWSV", "EWSH"] = "none"
    """Transient of IEC 61400-1: operating gust, direction change, coherent gust with direction
    change, vertical or horizontal wind shear."""
    gust_start: Annotated[Seconds, NotNegative] = 0.0
    """When the gust begins."""
    gust_sign: Annotated[Whole, Field(ge=-1, le=1)] = 1
    """1 or -1: sense of the turn, or of the shear."""
    turbine_class: Literal["I", "II", "III"] = "I"
    """Class of the turbine, for gusts."""
    turbulence: Literal["A+", "A", "B", "C"] = "B"
    """Category of turbulence, for gusts."""
    density: Annotated[Density, Positive] = 1.225
    """Density of the air."""
    ramp: Annotated[Seconds, NotNegative] = 0.0
    """Time in which the wind sets in smoothly from calm; 0 for a sudden start."""
    box: BoxCase = BoxCase()

    @property
    def table(self) -> str | None:
        """The file with a table over the time; None without one."""
        is_table = self.file is not None and self.file.lower().endswith(TABLES)
        return self.file if is_table else None

    @property
    def blows(self) -> bool:
        """Whether there is a wind."""
        return self.speed is not None or self.file is not None


def is_windio(name: str) -> bool:
    """Whether a file is one of windIO by its name."""
    return Path(name).suffix.lower() in (".yaml", ".yml")


def find_aero_file(name: str, folder: str | os.PathLike[str]) -> str:
    """A file in a folder, or one of windIO's examples, which are known by their names alone."""
    if is_windio(name):
        from turbine_fenicsx.windio import find_turbine_file  # not needed to read other cases

        with suppress(InputError):
            return str(find_turbine_file(name, folder))
    return find_beside(name, folder)


class AeroCase(Section):
    """Loads of the wind on the blades: blade-element momentum theory at ``stations``.

    ``file`` is a primary file of AeroDyn 15, which names its blade and polars, or a windIO file;
    without it the blades have the aerodynamics of ``turbine.file``.

    ``dynamic_stall = "oeye"`` lets the separation of the flow follow with a delay, ``skewed_wake``
    gives more induction where the wake of a rotor that does not face the wind is deep. The wind
    gives way to a flexible tower with ``tower_shadow = "potential"``; ``"powles"`` adds the wake
    behind it.
    """

    file: Annotated[str | None, DataFile("aerodynamics file", find=find_aero_file)] = None
    """Primary file of AeroDyn 15, or a windIO file, with chord, twist and polars, relative to the
    case file; none: those of ``turbine.file``."""
    stations: Annotated[Whole, Field(ge=5, le=1000)] = 12
    """Number of aerodynamic stations of a blade."""
    induction: Flag = True
    """Whether the rotor slows the wind; ``false`` leaves blade elements alone. A rotor whose tips
    are slower than the wind never does, see theory/bem."""
    dynamic_stall: Literal["none", "oeye"] = "none"
    """Delay of the separation of the flow, see theory/unsteady_aerodynamics."""
    skewed_wake: Flag = False
    """More induction where the wake of a rotor that does not face the wind is deep."""
    tower_shadow: Literal["none", "potential", "powles"] = "none"
    """Effect of a flexible tower on the wind: potential flow, and with ``"powles"`` the wake behind
    it."""
    tower_drag: Annotated[Number, Field(ge=0.0, le=5.0)] = 0.5
    """Drag coefficient of the tower, for the wake."""

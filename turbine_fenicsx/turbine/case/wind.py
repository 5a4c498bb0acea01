"""The tables of the wind and of the aerodynamics of the blades."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

from pydantic import Field

from turbine_fenicsx.turbine.case.quantities import (
    Density,
    Metres,
    Number,
    Radians,
    Seconds,
    Speed,
    Whole,
)
from turbine_fenicsx.turbine.case.section import Flag, NotNegative, Positive, Section
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

    files: tuple[str, str, str] | None = None
    points: tuple[Points, Points, Points] | None = None
    spacing: tuple[Distance, Distance, Distance] | None = None
    periodic: Flag = True
    scale: tuple[Scale, Scale, Scale] = (1.0, 1.0, 1.0)


class WindCase(Section):
    """The wind, which blows along e3 at the height of the hub; none without ``speed`` or ``file``.

    It is steady with a power law over the height, or one of the transients of IEC 61400-1 that
    begins at ``gust_start``, or that of a ``file``: turbulence of TurbSim (``.bts``), or a table
    over the time, comma-separated (``.csv``) or OpenFAST's uniform wind (``.wnd``, ``.hh``); or it
    has the turbulence of a box below. It sets in smoothly in the time ``ramp``.
    """

    speed: Annotated[Speed, Field(ge=0.0, le=FASTEST)] | None = None
    file: str | None = None
    shear: Annotated[Number, Field(ge=0.0, le=2.0)] = 0.2
    hub_height: Annotated[Metres, Positive] | None = None
    direction: Angle = 0.0
    inclination: Annotated[Radians, Field(ge=-STEEPEST, le=STEEPEST)] = 0.0
    gust: Literal["none", "EOG", "EDC", "ECD", "EWSV", "EWSH"] = "none"
    gust_start: Annotated[Seconds, NotNegative] = 0.0
    gust_sign: Annotated[Whole, Field(ge=-1, le=1)] = 1
    turbine_class: Literal["I", "II", "III"] = "I"
    turbulence: Literal["A+", "A", "B", "C"] = "B"
    density: Annotated[Density, Positive] = 1.225
    ramp: Annotated[Seconds, NotNegative] = 0.0
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


class AeroCase(Section):
    """What the wind does to the blades: blade-element momentum theory at ``stations``.

    ``file`` is a primary file of AeroDyn 15, which names its blade and polars, or a windIO file;
    without it the blades have the aerodynamics of ``turbine.file``.

    ``dynamic_stall = "oeye"`` lets the separation of the flow follow with a delay, ``skewed_wake``
    gives more induction where the wake of a rotor that does not face the wind is deep. The wind
    gives way to a flexible tower with ``tower_shadow = "potential"``; ``"powles"`` adds the wake
    behind it.
    """

    file: str | None = None
    stations: Annotated[Whole, Field(ge=5, le=1000)] = 12
    dynamic_stall: Literal["none", "oeye"] = "none"
    skewed_wake: Flag = False
    tower_shadow: Literal["none", "potential", "powles"] = "none"
    tower_drag: Annotated[Number, Field(ge=0.0, le=5.0)] = 0.5

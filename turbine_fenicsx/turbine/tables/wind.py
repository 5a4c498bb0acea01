"""The tables of the wind and of a box of turbulence from files."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile
from turbine_fenicsx.case.quantities import (
    Density,
    Metres,
    Number,
    Radians,
    Seconds,
    Speed,
    Whole,
)
from turbine_fenicsx.case.rules import AnyOf, Beside, If, Only, Unless, With
from turbine_fenicsx.case.section import Flag, NotNegative, Positive, Section
from turbine_fenicsx.foundation.plausible import DEGREE, Plausible
from turbine_fenicsx.turbine.tables.event import STOPS
from turbine_fenicsx.turbine.tables.turbulence import TurbulenceCase
from turbine_fenicsx.turbine.tables.wind_table import (
    FALLBACKS,
    MAX_INCLINATION,
    check_wind_table,
    load_wind_table,
)
from turbine_fenicsx.wind.inflow import FASTEST

TABLES = (".csv", ".wnd", ".hh")
"""Endings of files with tables of wind."""

CUT_OUT_SPEED = 25.0
"""Wind speed above which most turbines stop [m/s]."""

LEAST_FEATHER = pi / 4.0
"""Pitch from which on blades count as feathered [rad]."""

BLOWS = With("wind.speed", "wind.file")
"""Rule of keys that count in a wind only."""

_GUST = (Beside("file"), Unless("gust", "none"))


def _not_in_file(key: str) -> If:
    """Rule of a key that counts unless the file of the wind has its own."""
    return If(lambda case: key not in case.wind.own_keys, say="beside wind.file, which has its own")


_TURN = Plausible(0.0, 120.0 * DEGREE)
Angle = Annotated[Radians, Field(ge=-pi, le=pi)]
Points = Annotated[Whole, Field(ge=2, le=100_000)]
Distance = Annotated[Metres, Positive]
Scale = Annotated[Number, Field(ge=-100.0, le=100.0)]


Classes = Literal[
    "IA+", "IA", "IB", "IC", "IIA+", "IIA", "IIB", "IIC", "IIIA+", "IIIA", "IIIB", "IIIC"
]


class BoxCase(Section):
    """Turbulence box of Mann's model or HAWC2: three ``files`` with u, v and w.

    They hold fluctuations, which the steady wind of ``wind.speed`` and ``wind.shear`` carries
    along; the middle of the box is at the height of the hub.
    """

    rules = (With("files"),)

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
    begins at ``gust_start``, or has the turbulence of one of the tables below. Or it comes from a
    ``file``: turbulence of TurbSim (``.bts``), or a table over the time, comma-separated (``.csv``)
    or OpenFAST's uniform wind (``.wnd``, ``.hh``). It sets in smoothly in the time ``ramp``.
    """

    rules = (BLOWS,)

    speed: Annotated[Speed, Field(ge=0.0, le=FASTEST)] | None = None
    """Wind speed at the height of the hub; none: no wind, see howto/wind."""
    file: Annotated[str | None, DataFile("wind file")] = None
    """In place of ``speed``: full-field file of TurbSim (``.bts``), or a table over the time
    (``.csv``, ``.wnd``, ``.hh``, see howto/tables), relative to the case file."""
    shear: Annotated[Number, Field(ge=0.0, le=2.0), _not_in_file("shear")] = 0.2
    """Exponent of the power law over the height; 0.2 is the normal wind profile of IEC 61400-1."""
    hub_height: Annotated[Metres | None, Positive, Plausible(5.0, 400.0)] = None
    """Height of the rotor centre above ground; none: ``tower.height`` and ``turbine.hub_rise``, or
    that of ``turbine.file``."""
    direction: Annotated[
        Angle, Plausible(0.1 * DEGREE, 180.0 * DEGREE), _not_in_file("direction")
    ] = 0.0
    """Angle of the wind with e₃, positive towards e₁."""
    inclination: Annotated[
        Radians,
        Field(ge=-MAX_INCLINATION, le=MAX_INCLINATION),
        _not_in_file("inclination"),
        AnyOf(Only("gust", "none"), With("file")),
    ] = 0.0
    """Upward angle of a steady wind."""
    gust: Literal["none", "EOG", "EDC", "ECD", "EWSV", "EWSH"] = "none"
    """Transient of IEC 61400-1: operating gust, direction change, coherent gust with direction
    change, vertical or horizontal wind shear."""
    gust_start: Annotated[Seconds, NotNegative, *_GUST] = 0.0
    """When the gust begins."""
    gust_sign: Annotated[Whole, Field(ge=-1, le=1), *_GUST, Unless("gust", "EOG")] = 1
    """1 or -1: sense of the turn, or of the shear."""
    turbine_class: Annotated[
        Classes,
        Beside("file"),
        AnyOf(Unless("gust", "none"), Unless("wind.turbulence.model", "none")),
    ] = "IB"
    """Class of the turbine and category of turbulence, for gusts and turbulence."""
    density: Annotated[Density, Positive, Plausible(0.5, 2.0)] = 1.225
    """Density of the air."""
    ramp: Annotated[Seconds, NotNegative] = 0.0
    """Time in which the wind sets in smoothly from calm; 0 for a sudden start."""
    box: BoxCase = BoxCase()
    turbulence: TurbulenceCase = TurbulenceCase()

    @property
    def table(self) -> str | None:
        """The file with a table over the time; None without one."""
        is_table = self.file is not None and self.file.lower().endswith(TABLES)
        return self.file if is_table else None

    @property
    def blows(self) -> bool:
        """Whether there is a wind."""
        return self.speed is not None or self.file is not None

    @property
    def is_steady(self) -> bool:
        """Whether the wind does not change in time."""
        return self.file is None and self.gust == "none" and not self.has_box

    @property
    def has_box(self) -> bool:
        """Whether the steady wind carries the turbulence of a box along."""
        return self.box.files is not None or self.turbulence.is_made

    @property
    def class_and_category(self) -> tuple[str, str]:
        """Class of the turbine and category of turbulence, for example I and B."""
        wind = self.turbine_class.rstrip("ABC+")
        return wind, self.turbine_class.removeprefix(wind)

    @property
    def own_keys(self) -> tuple[str, ...]:
        """Keys that the file has in place of the case."""
        if self.file is None:
            return ()
        if self.table is None:
            return ("shear",)
        columns = load_wind_table(self.table).columns
        return tuple(key for key in FALLBACKS if key in columns)

    @check("speed", "file")
    def _check_source(self, case: Any) -> str:
        """A wind is steady, or that of a file."""
        if self.file is None or self.speed is None:
            return ""
        return (
            f"wind.speed = {self.speed:g}: expected none beside wind.file, which has its own wind"
        )

    @check("gust", "speed", "file")
    def _check_gust(self, case: Any) -> str:
        """A gust needs a wind before it."""
        if self.gust == "none" or (self.speed and self.file is None):
            return ""
        return (
            f'wind.gust = "{self.gust}": expected wind.speed greater than 0, the wind before the '
            "gust"
        )

    @check("gust_sign")
    def _check_sign(self, case: Any) -> str:
        """A sign is not zero."""
        return "" if self.gust_sign else "wind.gust_sign = 0: expected 1 or -1"

    @check(
        *("hub_height", "speed", "file", "turbine.file", "blade.hub_radius", "blade.length"),
        *("turbine.tilt", "turbine.precone", "turbine.hub_rise", "tower.height"),
    )
    def _check_height(self, case: Any) -> str:
        """The blades do not touch the ground of the wind."""
        height, radius = case.hub_height, case.blade.hub_radius + case.blade.length
        if not self.blows or height > radius:
            return ""
        return (
            f"wind.hub_height = {height:g}: expected more than {radius:.4g} m, the radius of the "
            "rotor"
        )

    @check("box", "turbulence", "speed", "file", "gust")
    def _check_box(self, case: Any) -> str:
        """A box has a size, and a mean wind that carries it."""
        return self.find_box_mistake()

    def find_box_mistake(self) -> str:
        """A sentence if a box does not fit to the wind; else nothing."""
        if not self.has_box:
            return ""
        if self.turbulence.is_made:
            table, words = "wind.turbulence", "wind.turbulence.model: expected"
            if self.box.files is not None:
                return f'{words} "none" beside wind.box.files, which have their turbulence'
        else:
            table, words = "wind.box", "wind.box.files: expected"
            for name in ("points", "spacing"):
                if getattr(self.box, name) is None:
                    numbers = "three numbers, along e3, e1 and e2, beside its files"
                    return f"wind.box.{name}: expected {numbers}"
        if self.file is not None:
            return f"{words} none beside wind.file, which has its own wind"
        if not self.speed:
            return f"{words} wind.speed greater than 0, the mean wind that carries it"
        if self.gust != "none":
            return f'wind.gust = "{self.gust}": expected "none" beside {table}, which has its own'
        return ""

    @check("file", "time.end")
    def _check_table(self, case: Any) -> str:
        """A table lasts as long as the run."""
        return "" if self.table is None else check_wind_table(self.table, case.time.end)

    def find_doubts(self, case: Any) -> Iterator[str]:
        """No turbine works above its cut-out speed, and its blades are feathered there."""
        speed, pitch = self.speed, case.pitch
        if speed is None or speed <= CUT_OUT_SPEED or self.file is not None:
            return
        words = f"wind.speed = {speed:g} m/s is above {CUT_OUT_SPEED:g} m/s, where turbines stop"
        if case.control.kind != "none":
            if not any(event.kind in STOPS for event in case.event.values()):
                yield f"{words}: the controller works on"
            return
        moves = pitch.drive == "prescribed" and (pitch.angle or pitch.file)
        angle = min(pitch.initial, key=abs) if case.has_pitch_bearings else 0.0
        if abs(angle) < LEAST_FEATHER and not moves:
            yield (
                f"{words} with their blades at some 90 deg of pitch; here they have "
                f"{angle * 180.0 / pi:.3g} deg"
            )

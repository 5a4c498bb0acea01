"""The table of the aerodynamics of the blades."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from math import degrees, pi
from typing import Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFile, find_beside
from turbine_fenicsx.case.quantities import Number, Whole
from turbine_fenicsx.case.rules import Only
from turbine_fenicsx.case.section import Flag, Section
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.tables.named_files import is_windio, list_parts


def find_beside_or_example(name: str, folder: str | os.PathLike[str]) -> str:
    """A file in a folder, or one of windIO's examples, which are known by their names alone."""
    if is_windio(name):
        from turbine_fenicsx.windio import find_turbine_file  # not needed to read other cases

        with suppress(InputError):
            return str(find_turbine_file(name, folder))
    return find_beside(name, folder)


STORM = 20.0
"""Speed of the wind from which loads of blades that stand matter [m/s]."""

MAX_YAW_ERROR, MIN_FEATHER = pi / 18.0, pi / 3.0
"""Angles of wind and pitch within which blades that stand are not in deep stall [rad]."""


class AeroCase(Section):
    """Loads of the wind on the blades: blade-element momentum theory at ``stations``.

    ``file`` is a primary file of AeroDyn 15, which names its blade and polars, or a windIO file;
    without it the blades have the aerodynamics of ``turbine.file``.

    ``dynamic_stall = "oeye"`` lets the separation of the flow follow with a delay, ``skewed_wake``
    gives more induction where the wake of a rotor that does not face the wind is deep. The wind
    gives way to a flexible tower with ``tower_shadow = "potential"``; ``"powles"`` adds the wake
    behind it.
    """

    file: Annotated[
        str | None, DataFile("aerodynamics file", find_beside_or_example, list_parts)
    ] = None
    """Primary file of AeroDyn 15, or a windIO file, with chord, twist and polars, relative to the
    case file; none: those of ``turbine.file``."""
    stations: Annotated[Whole, Field(ge=5, le=1000)] = 12
    """Number of aerodynamic stations of a blade."""
    induction: Flag = True
    """Whether the rotor slows the wind; ``false`` leaves blade elements alone. A rotor whose tips
    are slower than the wind never does, see theory/bem."""
    dynamic_stall: Literal["none", "oeye"] = "none"
    """Delay of the separation of the flow, see theory/unsteady_aerodynamics."""
    pitch_rate: Flag = True
    """Loads of sections that turn about the span, which dampen torsion, see
    theory/unsteady_aerodynamics; ``false`` takes the polars alone."""
    unsteady: Flag = True
    """Lift of attached flow takes time, which takes damping away, see
    theory/unsteady_aerodynamics; ``false`` takes that of the polar."""
    skewed_wake: Flag = False
    """More induction where the wake of a rotor that does not face the wind is deep."""
    tower_shadow: Literal["none", "potential", "powles"] = "none"
    """Effect of a flexible tower on the wind: potential flow, and with ``"powles"`` the wake behind
    it."""
    tower_drag: Annotated[Number, Field(ge=0.0, le=5.0), Only("tower_shadow", "powles")] = 0.5
    """Drag coefficient of the tower, for the wake."""

    @check("tower_shadow", "wind.speed", "wind.file", "tower.flexible")
    def _check_tower(self, case: Any) -> str:
        """A tower that stands in the wind has a shape."""
        if not case.wind.blows or self.tower_shadow == "none" or case.tower.flexible:
            return ""
        return (
            f'aero.tower_shadow = "{self.tower_shadow}": expected tower.flexible = true, a tower '
            "with diameters"
        )

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Blades that stand in a storm are in deep stall, where polars alone feed vibrations."""
        wind, pitch = case.wind, case.pitch
        if self.dynamic_stall != "none" or wind.speed is None or case.turbine.model == "rigid":
            return
        tips = abs(case.turbine.rotor_speed) * (case.blade.hub_radius + case.blade.length)
        feathered = case.has_pitch_bearings and min(map(abs, pitch.initial)) > MIN_FEATHER
        turned = abs(wind.direction) > MAX_YAW_ERROR or wind.gust in ("EDC", "ECD")
        if wind.speed < STORM or tips >= wind.speed or (feathered and not turned):
            return
        where = f"from {degrees(wind.direction):.3g} deg" if turned else "with blades not feathered"
        yield (
            f'aero.dynamic_stall = "none": a rotor that stands in a wind of {wind.speed:g} m/s '
            f"{where} is in deep stall, where edgewise loads swing several times too far; "
            '"oeye" lets the separation follow with a delay'
        )

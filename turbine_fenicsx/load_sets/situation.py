"""Situations: design load cases as data, which say how a case is changed and what counts of it."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from turbine_fenicsx.case.quantities import Radians, Seconds
from turbine_fenicsx.case.section import NotNegative, Positive
from turbine_fenicsx.study.file import Changes

PARTIAL_FACTOR = 1.35
"""Safety factor of normal situations, IEC 61400-1, table 3 [-]."""

STORM_INTENSITY, STORM_SHEAR = 0.11, 0.11
"""Turbulence and shear of the extreme wind speed model, IEC 61400-1, section 6.3.3.2."""

TURBULENCE: dict[str, dict[str, Any]] = {
    "none": {"wind.turbulence.model": "none"},
    "normal": {"wind.gust": "none", "wind.turbulence.level": "normal"},
    "extreme": {"wind.gust": "none", "wind.turbulence.level": "extreme"},
    "storm": {
        "wind.gust": "none",
        "wind.turbulence.intensity": STORM_INTENSITY,
        "wind.shear": STORM_SHEAR,
    },
}
"""Keys of a case for the turbulence of a situation."""

PARKED = {
    "control.kind": "none",
    "turbine.rotor_speed": 0,
    "pitch.bearings": True,
    "pitch.drive": "prescribed",
    "pitch.initial": "90 deg",
    "time.start": "equilibrium",
    "aero.dynamic_stall": "oeye",
}
"""Keys of a case whose rotor idles with feathered blades."""


class Situation(BaseModel):
    """A design load case.

    Attributes:
        title: What happens.
        uses: Another situation whose runs are evaluated; this one has none.
        winds: Speeds at the hub, see ``situations.toml``.
        start: Whether runs begin turning at the speed and pitch of their wind, parked, or as given.
        turbulence: Its kind.
        yaw_errors: Angles of the wind [rad].
        seeds: Number of winds for each speed and angle; that of the set if None.
        duration: Time that counts [s].
        transient: Time before, which does not [s].
        set: Changes of the case by dotted key.
        variants: Changes by name, each of which is run.
        evaluates: What its runs are for.
        safety_factor: Partial safety factor of the loads; by what it evaluates if None [-].
        per_year: How often it happens in a year at each of its winds; as long as the wind blows if
            it is empty.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    title: str = ""
    uses: str | None = None
    winds: tuple[str | float, ...] = ("operating",)
    start: Literal["turning", "parked", "given"] = "turning"
    turbulence: Literal["none", "normal", "extreme", "storm"] = "none"
    yaw_errors: tuple[Radians, ...] = (0.0,)
    seeds: Annotated[int, Field(ge=1, le=1000)] | None = None
    duration: Annotated[Seconds, Positive] = 600.0
    transient: Annotated[Seconds, NotNegative] = 60.0
    set: Changes = {}
    variants: dict[str, Changes] = {"": {}}
    evaluates: Literal["ultimate", "fatigue", "extrapolation"] = "ultimate"
    safety_factor: Annotated[float, Field(gt=0.0, le=10.0)] | None = None
    per_year: tuple[Annotated[float, Field(ge=0.0)], ...] = ()

    @property
    def factor(self) -> float:
        """Safety factor of its loads [-]."""
        if self.safety_factor is not None:
            return self.safety_factor
        return 1.0 if self.evaluates == "fatigue" else PARTIAL_FACTOR

    @property
    def changes(self) -> dict[str, Any]:
        """Changes of all its runs by dotted key."""
        return {
            **(PARKED if self.start == "parked" else {}),
            **({"time.start": "turning"} if self.start == "turning" else {}),
            **TURBULENCE[self.turbulence],
            "time.end": self.transient + self.duration,
            "output.transient": self.transient,
            **self.set,
        }


@lru_cache(maxsize=1)
def read_standard() -> dict[str, dict[str, Any]]:
    """Tables of the situations of the standard by name."""
    return tomllib.loads(Path(__file__).with_name("situations.toml").read_text("utf-8"))

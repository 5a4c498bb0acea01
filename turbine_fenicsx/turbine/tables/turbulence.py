"""The table of turbulence that is made at the start of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.files import DataFolder
from turbine_fenicsx.case.quantities import Metres, Number, Seconds, Whole
from turbine_fenicsx.case.rules import Beside, Unless
from turbine_fenicsx.case.section import Positive, Section
from turbine_fenicsx.foundation.plausible import Plausible

FOLDER = "turbulence"
"""Folder beside the case file in which boxes are kept, unless the case names one."""

TEN_MINUTES = 600.0
"""Time over which the standard takes the mean wind [s]."""


class TurbulenceCase(Section):
    """Turbulence of IEC 61400-1 that a run makes at its start, by ``model``.

    A box around the rotor, which the steady wind of ``wind.speed`` and ``wind.shear`` carries
    along. Equal keys give equal winds, on any machine. Boxes are kept in ``folder``.
    """

    rules = (Unless("model", "none"),)

    model: Literal["none", "kaimal", "mann"] = "none"
    """Kaimal's spectra with exponential coherence, or Mann's spectral tensor."""
    level: Annotated[Literal["normal", "extreme"], Beside("intensity")] = "normal"
    """Normal or extreme turbulence (NTM, ETM) of ``wind.turbine_class``."""
    intensity: Annotated[Number | None, Field(gt=0.0, le=1.0)] = None
    """Standard deviation along the wind over its mean, in place of that of the class."""
    seed: Annotated[Whole, Field(ge=0, le=2**31 - 1)] = 1
    """Number of the wind among all that are as likely."""
    width: Annotated[Metres | None, Positive] = None
    """Width and height of the box, around the hub; none: 1.15 diameters of the rotor, or less where
    the ground is nearer."""
    points: Annotated[Whole, Field(ge=2, le=64)] = 24
    """Number of points across the wind, and upwards."""
    time_step: Annotated[Seconds, Positive, Plausible(0.01, 2.0)] = 0.2
    """Time between two planes of the box; what is faster than two of them is left out."""
    duration: Annotated[Seconds | None, Positive, Plausible(60.0, 36000.0)] = None
    """Time after which the box restarts; none: ten minutes, or that of the run if longer."""
    folder: Annotated[str | None, DataFolder("folder of turbulence")] = None
    """Folder in which boxes are kept, relative to the case file; none: ``turbulence`` beside it, or
    in a study beside the case file of the study."""

    @property
    def is_made(self) -> bool:
        """Whether there is a turbulence to make."""
        return self.model != "none"

    @check("duration", "time_step")
    def _check_duration(self, case: Any) -> str:
        """A box has some planes."""
        if not self.is_made or self.duration is None or self.duration >= 4.0 * self.time_step:
            return ""
        return (
            f"wind.turbulence.duration = {self.duration:g}: expected at least four times "
            f"wind.turbulence.time_step = {self.time_step:g}"
        )

    def find_doubts(self, case: Any) -> Iterator[str]:
        """A wind that restarts has less variety than the run is long."""
        duration = self.duration
        if self.is_made and duration is not None and duration < case.time.end:
            yield (
                f"wind.turbulence.duration = {duration:g} s is less than time.end = "
                f"{case.time.end:g} s: the wind restarts"
            )

    def find_duration(self, end: float) -> float:
        """Time after which the box restarts [s].

        Args:
            end: End of the run [s].
        """
        return max(TEN_MINUTES, end) if self.duration is None else self.duration

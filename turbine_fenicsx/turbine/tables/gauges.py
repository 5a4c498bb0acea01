"""The tables of strain gauges: their keys, and what they have to do with the blades."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.case.quantities import Metres, Number, Radians, require_number
from turbine_fenicsx.case.section import Positive, Section, check_names
from turbine_fenicsx.foundation.text_files import quote

PLACES = ("trailing edge", "suction side", "leading edge", "pressure side")
"""Places around a section that all blades have, by rising contour fraction."""


def _check_around(value: Any) -> Any:
    """A contour fraction, or the name of a place."""
    if isinstance(value, str):
        return value
    try:
        fraction = float(require_number(value))
    except (ValueError, OverflowError):
        fraction = -1.0
    if not 0.0 <= fraction <= 1.0:
        raise ValueError('expected a number from 0 to 1, or a place such as "suction side"')
    return fraction


class GaugeCase(Section):
    """Strain gauge on the outer surface of a flexible blade; NAME is yours.

    It lies at a ``station``, a fraction of the span, or at a ``distance`` from the root. ``around``
    the section it is at a place such as ``"leading edge"``, or at a fraction of the contour, which
    rises from the trailing edge over the suction side.
    """

    blade: Annotated[Literal[1, 2, 3], BeforeValidator(require_number)] = 1
    """Number of the blade."""
    station: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = None
    """Place along the span as a fraction of the length; this or ``distance``."""
    distance: Annotated[Metres, Positive] | None = None
    """Place along the span from the root."""
    around: Annotated[float | str, BeforeValidator(_check_around)] = "suction side"
    """Place around the section: ``"trailing edge"``, ``"suction side"``, ``"leading edge"``,
    ``"pressure side"``, the name of a panel of blades of ``turbine.file``, or a fraction of the
    contour, see howto/stress."""
    angle: Annotated[Radians, Field(ge=-2.0 * pi, le=2.0 * pi)] = 0.0
    """Between the gauge and the span, positive about the normal outwards."""

    def find_station(self, length: float) -> float:
        """Its fraction of a span of a length [m]."""
        if self.station is not None:
            return self.station
        assert self.distance is not None
        return self.distance / length


GaugeCases = Annotated[dict[str, GaugeCase], BeforeValidator(check_names)]
"""Gauges by name."""


def check_gauges(gauges: Mapping[str, GaugeCase], length: float, panels: tuple[str, ...]) -> str:
    """A sentence about the first gauge that lies nowhere on a blade, else nothing.

    Args:
        gauges: The gauges.
        length: Of the span [m].
        panels: Panels of the blades, for those of a windIO file.
    """
    places = tuple(dict.fromkeys((*PLACES, *panels)))
    for name, gauge in gauges.items():
        key = f"output.gauges.{name}"
        if (gauge.station is None) == (gauge.distance is None):
            return f"{key}: expected either a station or a distance"
        if gauge.distance is not None and gauge.distance >= length:
            return (
                f"{key}.distance = {gauge.distance:g}: expected less than {length:g} m, the length "
                "of the blades"
            )
        if isinstance(gauge.around, str) and gauge.around not in places:
            return (
                f"{key}.around = {quote(gauge.around)}: expected a number from 0 to 1 or one of "
                f"{', '.join(places)}"
            )
    return ""

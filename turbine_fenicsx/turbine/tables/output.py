"""The tables of the output, and of strain gauges on the blades."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Metres, Number, Radians, Seconds, require_number
from turbine_fenicsx.case.rules import AnyOf, If, Only
from turbine_fenicsx.case.section import Flag, NotNegative, Positive, Section, check_names
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.records.openfast_names import find_unknown

_FIELDS = If(
    lambda case: not case.moves_by_vectors,
    "beside reduced parts and beams, whose fields `turbine-fenicsx recover --fields` makes",
)

_Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]
_MIDDLE = Only("time.scheme", "energy_momentum")

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


def _check_channels(patterns: tuple[str, ...]) -> tuple[str, ...]:
    """Patterns that all fit some channel."""
    unknown = find_unknown(patterns)
    if unknown:
        raise ValueError(unknown)
    return patterns


def _check_places(places: tuple[float, ...]) -> tuple[float, ...]:
    """Places with different names of columns."""
    named = [f"{place:g}" for place in places]
    for name in named:
        if named.count(name) > 1:
            raise ValueError(f"expected different places, got {name} twice")
    return places


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

    def find_mistake(self, key: str, length: float, panels: tuple[str, ...]) -> str:
        """A sentence if it lies nowhere on a blade; else nothing.

        Args:
            key: Its name, such as "output.gauges.root".
            length: Of the span [m].
            panels: Panels of the blades, for those of a windIO file.
        """
        places = tuple(dict.fromkeys((*PLACES, *panels)))
        if (self.station is None) == (self.distance is None):
            return f"{key}: expected either a station or a distance"
        if self.distance is not None and self.distance >= length:
            return (
                f"{key}.distance = {self.distance:g}: expected less than {length:g} m, the length "
                "of the blades"
            )
        if isinstance(self.around, str) and self.around not in places:
            return (
                f"{key}.around = {quote(self.around)}: expected a number from 0 to 1 or one of "
                f"{', '.join(places)}"
            )
        return ""


class OutputCase(Section):
    """Output; 0 = never.

    ``fields_every`` is the simulated time between two outputs of fields, ``checkpoint_every`` that
    between two checkpoints; ``checkpoint_wall_time`` is the wall time between them. There always is
    one at the start and at the end.
    """

    fields_every: Annotated[Seconds, NotNegative, AnyOf(_FIELDS, Only("fields_every", 0.0))] = 0.1
    """Simulated time between two outputs of fields; 0: no fields."""
    format: Annotated[Literal["xdmf", "vtkhdf"], _FIELDS] = "xdmf"
    """Files of the fields: ``fields.xdmf`` with ``fields.bin``, or ``fields.vtkhdf``."""
    motion_every: Annotated[
        Seconds,
        NotNegative,
        If(lambda case: case.moves_by_vectors, "without reduced parts and beams"),
    ] = 0.1
    """Simulated time between two rows of the motion of reduced bodies, from which fields and
    stresses can be recovered; 0: none."""
    checkpoint_every: Annotated[Seconds, NotNegative] = 0.0
    """Simulated time between two checkpoints; 0: by wall time alone."""
    checkpoint_wall_time: Annotated[Seconds, NotNegative] = 300.0
    """Wall time between two checkpoints; 0: only at start and end."""
    channels: Annotated[tuple[str, ...], AfterValidator(_check_channels)] = ("default",)
    """Channels of ``history.out``: ``"default"`` and patterns such as ``"RootM*"``, see
    reference/channels."""
    binary: Flag = False
    """Whether the end of a run also writes ``history.outb``, OpenFAST's binary output."""
    transient: Annotated[Seconds, NotNegative] = 0.0
    """Time from the start that ``statistics.csv`` leaves out."""
    shaft_gauge: Metres = 0.0
    """Distance of the strain gauge of the shaft behind the rotor centre, for ``LSSGagMys``."""
    twists: Annotated[
        tuple[Annotated[Number, Field(gt=0.0, lt=1.0)], ...],
        AfterValidator(_check_places),
        Only("turbine.model", "hybrid"),
    ] = ()
    """Places along the span, as fractions of its length, where histories have the twist of the
    blades by deformation."""
    sections: Annotated[
        tuple[_Fraction, ...],
        Field(max_length=99),
        AfterValidator(_check_places),
        Only("turbine.model", "hybrid"),
        _MIDDLE,
    ] = ()
    """Places along the axis of flexible blades, as fractions of its length, where histories have
    the force and moment in the section."""
    tower_sections: Annotated[
        tuple[_Fraction, ...],
        Field(max_length=99),
        AfterValidator(_check_places),
        Only("tower.flexible", True),
        _MIDDLE,
    ] = ()
    """Places along a flexible tower, as fractions of its height, where histories have the force and
    moment in the section."""
    gauges: Annotated[
        dict[str, GaugeCase], BeforeValidator(check_names), Only("turbine.model", "hybrid")
    ] = Field(default_factory=dict)

    @check("transient", "time.end")
    def _check_transient(self, case: Any) -> str:
        """Something is left for the statistics."""
        if not self.transient or self.transient < case.time.end:
            return ""
        end = case.time.end
        return f"output.transient = {self.transient:g}: expected less than time.end, {end:g} s"

    def name_file(self, folder: Path, name: str) -> Path:
        """A file of fields in an output folder."""
        return folder / f"{name}.{self.format}"

"""The table of the turbine: its model, rigid parts, angles of the rotor."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, pi
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.case.files import DataFile, keep_name
from turbine_fenicsx.case.quantities import AngularSpeed, Metres, Number, Radians, Unit, to_si
from turbine_fenicsx.case.rules import AnyOf, Beside, Only, Unless
from turbine_fenicsx.case.section import HUGE, Finite, NotNegative, Positive, Section
from turbine_fenicsx.foundation.plausible import DEGREE, Plausible
from turbine_fenicsx.turbine.tables.named_files import list_included
from turbine_fenicsx.turbine.tables.rigid_parts import (
    PRINTED_ARMS,
    HubCase,
    NacelleCase,
    RigidBladeCase,
    TurbineParameters,
)

MAX_LEAN = pi / 4.0
"""Largest tilt of the shaft and cone of the blades [rad]."""

_LEAN = Plausible(0.3 * DEGREE, 20.0 * DEGREE)

_PRINTED = (Only("model", "rigid"), Beside("file"))
_CONSERVES = Unless("time.scheme", "generalised_alpha")
_FLEXIBLE = AnyOf(
    Only("model", "hybrid"), Only("tower.flexible", True), say="without flexible parts"
)


def _check_arm(value: Any) -> Any:
    """Either "printed" or a positive length [m]."""
    if value == "printed":
        return value
    try:
        arm = to_si(value, "m")
    except ValueError:
        arm = 0.0
    if not 0.0 < arm <= HUGE:
        raise ValueError('expected "printed" or a length greater than 0, for example "29.25 m"')
    return arm


class TurbineCase(Section):
    """Rigid parts; ``model`` decides whether the blades are rigid or flexible.

    ``file`` is a windIO file, see `turbine_fenicsx.turbine.case.turbine_file`.

    ``rotor_speed`` and ``azimuth`` are those at t = 0, positive about the shaft, downwind. ``tilt``
    and ``precone`` count as in OpenFAST: a rotor in front of the tower has negative ones if shaft
    and blades lean away from the tower. The hub centre is ``hub_distance`` in front of the yaw axis
    and ``hub_rise`` above the tower top.
    ``numerical_dissipation`` damps high frequencies of flexible parts and conserves momenta.
    """

    model: Literal["rigid", "hybrid"] = "hybrid"
    """Blades of the turbine: rigid bodies or flexible."""
    file: Annotated[str | None, DataFile("windIO file", keep_name, list_included)] = None
    """File of a whole turbine in windIO's format, relative to the case file, or the name of one of
    windIO's examples; keys of the case override its values, see howto/real_turbine."""
    rotor_speed: Annotated[AngularSpeed, Finite] = 0.0
    """Speed of the rotor at t = 0, positive about the shaft, downwind."""
    azimuth: Annotated[Radians, Field(ge=-2.0 * pi, le=2.0 * pi)] = 0.0
    """Angle of the rotor at t = 0, positive about the shaft, downwind."""
    blade_arm: Annotated[
        Literal["printed"] | float, BeforeValidator(_check_arm), Unit("m"), *_PRINTED
    ] = "printed"
    """Distance of the centres of rigid blades from the hub centre; ``"printed"``: 29.598, 29.25
    and 29.598 m as in (28)-(32)."""
    angle_form: Annotated[Literal["regular", "paper"], _CONSERVES] = "regular"
    """Form of the joint angle constraint, see theory/joints."""
    numerical_dissipation: Annotated[Number, NotNegative, _CONSERVES, _FLEXIBLE] = 0.0
    """Factor chi of the energy-decaying variant; 0 conserves energy."""
    hub_distance: Annotated[Metres, Positive, Plausible(0.5, 40.0)] = 5.0
    """Horizontal distance a of the hub centre from the yaw axis, see howto/turbine_options."""
    hub_rise: Annotated[Metres, Finite, Plausible(0.05, 20.0)] = 0.0
    """Height of the hub centre above the tower top."""
    tilt: Annotated[Radians, Field(ge=-MAX_LEAN, le=MAX_LEAN), _LEAN] = 0.0
    """Angle between shaft and horizontal, as in OpenFAST negative if the shaft rises towards the
    rotor."""
    precone: Annotated[Radians, Field(ge=-MAX_LEAN, le=MAX_LEAN), _LEAN] = 0.0
    """Angle between the blades and the plane normal to the shaft, as in OpenFAST negative if the
    blades lean upwind."""
    nacelle: NacelleCase = NacelleCase()
    hub: HubCase = HubCase()
    blade: Annotated[RigidBladeCase, *_PRINTED] = RigidBladeCase()

    def parameters(self) -> TurbineParameters:
        """The parameters for the builders."""
        arms = PRINTED_ARMS if self.blade_arm == "printed" else (float(self.blade_arm),) * 3
        return TurbineParameters(
            arms, self.nacelle.inertia_data(), self.hub.inertia_data(), self.blade.inertia_data()
        )

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Blades stay above the ground, shaft and blades lean away from the tower."""
        radius = case.blade.hub_radius + case.blade.length
        depth = radius * cos(self.precone + self.tilt) - case.tower.height - self.hub_rise
        if case.tower.flexible and depth > 0.0:
            yield (
                f"the blades reach {depth:.4g} m into the ground: they end at a radius of "
                f"{radius:.4g} m and tower.height is {case.tower.height:.4g} m"
            )
        for key, angle in (("tilt", self.tilt), ("precone", self.precone)):
            if angle > 0.0:
                yield (
                    f"turbine.{key} = {angle * 180.0 / pi:.4g} degrees leans the blades towards "
                    "the tower; the angle counts as in OpenFAST, negative for a rotor in front of "
                    "it"
                )

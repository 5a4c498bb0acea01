"""The tables of nacelle, hub and rigid blades, by default those of the paper's Table 1."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi
from typing import Annotated, Any

from pydantic import Field

from turbine_fenicsx.bodies.inertia import principal_inertia
from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import EulerMoment, Kilograms, Metres
from turbine_fenicsx.case.rules import Beside, find_name
from turbine_fenicsx.case.section import Finite, Moment, Positive, Section
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.plausible import Plausible
from turbine_fenicsx.foundation.text_files import quote

PRINTED_ARMS = (27.0 + 4.5 / (2.0 * cos(pi / 6.0)), 29.25, 27.0 + 4.5 / (2.0 * cos(pi / 6.0)))
"""Distances of the rigid blades' centres from the hub centre as printed, eqs (28)-(32) [m].

The arm of the upright blade differs from the other two, so that the printed rotor is slightly out
of balance.
"""


Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Inertia:
    """Mass, centre of mass and inertia of a rigid part.

    Args:
        mass: m [kg].
        euler: E1, E2, E3, the principal values of the Euler tensor [kg m^2].
        centre: Centre of mass from the origin of the part [m].
        tensor: Tensor of inertia about the centre of mass, rows [kg m^2]; in place of ``euler``.
    """

    mass: float
    euler: Vector
    centre: Vector = (0.0, 0.0, 0.0)
    tensor: tuple[Vector, Vector, Vector] | None = None


@dataclass(frozen=True)
class TurbineParameters:
    """Rigid parts of the turbine.

    The tower top is the origin; e2 is vertical.

    Masses and Euler values are those of the paper's Table 1, rows 1, 2 and 3-5. Its columns E1, E2,
    E3 belong to the body axes d1, d2, d3 of the initial configuration, eqs (30)-(32). With them the
    rigid turbine meets every reference number of ``docs/paper.md``.

    Args:
        blade_arms: Distances of the rigid blades' centres from the hub centre [m].
        nacelle: Inertia in the axes e1, e2, e3 (d1, d2, d3), from the tower top.
        hub: Inertia in the axes d1, d2, d3 of the rotor, the last of which is the shaft, from the
            rotor centre.
        blade: Inertia of a rigid blade; d1 along the chord, d2 along the span, d3 normal to both.
    """

    blade_arms: tuple[float, float, float] = PRINTED_ARMS
    nacelle: Inertia = Inertia(2.0e5, (6.0e5, 6.0e5, 6.0e5))
    hub: Inertia = Inertia(6.1e4, (102940.0, 102940.0, 81330.0))
    blade: Inertia = Inertia(1.65e4, (183500.0, 1449500.0, 18900.0))


_DEFAULTS = TurbineParameters()

Coordinate = Annotated[Metres, Finite]
Product = Annotated[EulerMoment, Finite]


class RigidBladeCase(Section):
    """Mass [kg] and Euler values [kg m^2] of a rigid blade."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.blade.mass
    """Mass."""
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.blade.euler
    """Principal values of the Euler tensor along chord, span and rotor axis."""

    def inertia_data(self) -> Inertia:
        """The numbers for the builders."""
        return Inertia(self.mass, self.euler)


class NacelleCase(Section):
    """Mass [kg], centre of mass [m] and inertia [kg m^2] of the nacelle.

    ``centre`` counts from the tower top along e1, e2, e3. ``inertia`` is the tensor about the
    centre of mass, J11, J22, J33 and, if there are, J12, J13, J23; it takes the place of the Euler
    values ``euler``.
    """

    mass: Annotated[Kilograms, Positive, Plausible(50.0, 5e6)] = _DEFAULTS.nacelle.mass
    """Mass."""
    centre: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Centre of mass from the tower top, along e₁, e₂, e₃."""
    euler: Annotated[tuple[Moment, Moment, Moment], Beside("inertia")] = _DEFAULTS.nacelle.euler
    """Principal values E₁, E₂, E₃ of the Euler tensor."""
    inertia: Annotated[tuple[Product, ...], Field(min_length=3, max_length=6)] | None = None
    """Tensor of inertia about the centre of mass in place of ``euler``: J₁₁, J₂₂, J₃₃, or these and
    J₁₂, J₁₃, J₂₃, in the axes of ``centre``."""

    def inertia_data(self) -> Inertia:
        """The numbers for the builders."""
        return Inertia(self.mass, self.euler, self.centre, self.tensor)

    @property
    def tensor(self) -> tuple[Vector, Vector, Vector] | None:
        """The tensor of inertia, rows."""
        if self.inertia is None:
            return None
        J11, J22, J33, J12, J13, J23 = (*self.inertia, 0.0, 0.0, 0.0)[:6]
        return (J11, J12, J13), (J12, J22, J23), (J13, J23, J33)

    @check("")
    def _check_inertia(self, case: Any) -> str:
        """The tensor of inertia is that of a body."""
        J, tensor = self.inertia, self.tensor
        if J is None or tensor is None:
            return ""
        key = find_name(case, self)
        words = f"{key}.inertia = {quote(list(J))}"
        if len(J) not in (3, 6):
            return (
                f"{words}: expected J11, J22, J33, or these and J12, J13, J23, got {len(J)} numbers"
            )
        try:
            principal_inertia(key, tensor)
        except ModelError as error:
            return f"{words}: {error}"
        return ""


class HubCase(NacelleCase):
    """Mass [kg], centre of mass [m] and inertia [kg m^2] of the hub.

    Its axes are those of the rotor: to the side, up, and along the shaft, downwind. ``centre``
    counts from the rotor centre.
    """

    mass: Annotated[Kilograms, Positive, Plausible(10.0, 2e6)] = _DEFAULTS.hub.mass
    """Mass."""
    centre: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Centre of mass from the rotor centre, to the side, up and along the shaft."""
    euler: Annotated[tuple[Moment, Moment, Moment], Beside("inertia")] = _DEFAULTS.hub.euler
    """Principal values E₁, E₂, E₃ of the Euler tensor."""

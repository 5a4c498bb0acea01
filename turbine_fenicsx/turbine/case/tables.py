"""The tables of a case file, their keys, defaults and ranges.

A new key is a line here; a new table is a class and a line in `Tables`, and stands in a file of its
own with the checks of its component, as `turbine_fenicsx.turbine.case.tower`. What belongs to a
value is in its type: unit, range, choices. What keys of several tables have to do with each other
is in `turbine_fenicsx.turbine.case.consistency`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.turbine.case.parameters import PRINTED_ARMS, Inertia, TurbineParameters
from turbine_fenicsx.turbine.case.pitch import PitchCase, has_bearings
from turbine_fenicsx.turbine.case.quantities import (
    Acceleration,
    Density,
    Kilograms,
    Metres,
    Number,
    Pascal,
    Seconds,
    Torque,
    Unit,
    Viscosity,
    Whole,
    to_si,
)
from turbine_fenicsx.turbine.case.section import (
    HUGE,
    Count,
    Degree,
    Finite,
    Moment,
    NotNegative,
    Positive,
    Section,
)
from turbine_fenicsx.turbine.case.tower import TowerCase

_DEFAULTS = TurbineParameters()


class TimeCase(Section):
    """Time step and end of the run [s], and the integrator.

    ``scheme`` is the energy-momentum scheme of the paper, or the generalised-alpha method, which
    damps high frequencies but conserves neither energy nor momenta: ``spectral_radius`` is what a
    step leaves of a mode of infinite frequency.

    With a tolerance, steps whose estimated error exceeds it are halved, and grow again up to
    ``step``: of directions of rigid bodies [rad], of displacements [m].
    """

    step: Annotated[Seconds, Positive] = 0.02
    end: Annotated[Seconds, NotNegative] = 12.0
    angle_tolerance: Annotated[Number, Positive] | None = None
    displacement_tolerance: Annotated[Metres, Positive] | None = None
    scheme: Literal["energy_momentum", "generalised_alpha"] = "energy_momentum"
    spectral_radius: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.9


class NacelleCase(Section):
    """Mass [kg] and Euler values [kg m^2] of the nacelle."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.nacelle.mass
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.nacelle.euler


class HubCase(NacelleCase):
    """Mass [kg] and Euler values [kg m^2] of the hub."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.hub.mass
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.hub.euler


class RigidBladeCase(NacelleCase):
    """Mass [kg] and Euler values [kg m^2] of a rigid blade."""

    mass: Annotated[Kilograms, Positive] = _DEFAULTS.blade.mass
    euler: tuple[Moment, Moment, Moment] = _DEFAULTS.blade.euler


def _arm(value: Any) -> Any:
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

    ``numerical_dissipation`` damps high frequencies of flexible parts and conserves momenta.
    """

    model: Literal["rigid", "hybrid"] = "hybrid"
    blade_arm: Annotated[Literal["printed"] | float, BeforeValidator(_arm), Unit("m")] = "printed"
    angle_form: Literal["regular", "paper"] = "regular"
    numerical_dissipation: Annotated[Number, NotNegative] = 0.0
    hub_distance: Annotated[Metres, Positive] = _DEFAULTS.hub_distance
    nacelle: NacelleCase = NacelleCase()
    hub: HubCase = HubCase()
    blade: RigidBladeCase = RigidBladeCase()

    def parameters(self) -> TurbineParameters:
        """The parameters for the builders."""
        arms = PRINTED_ARMS if self.blade_arm == "printed" else (float(self.blade_arm),) * 3
        parts = {
            name: Inertia(part.mass, part.euler)
            for name, part in (("nacelle", self.nacelle), ("hub", self.hub), ("blade", self.blade))
        }
        return TurbineParameters(hub_distance=self.hub_distance, blade_arms=arms, **parts)


class BladeCase(Section):
    """Shape of a blade, see `turbine_fenicsx.meshing.BladeGeometry`."""

    hub_radius: Annotated[Metres, Positive] = 2.25
    length: Annotated[Metres, Positive] = 54.0
    stations: tuple[Annotated[Number, NotNegative], ...] = (0.0, 0.2, 1.0)
    chord: tuple[Annotated[Metres, Positive], ...] = (1.8, 3.0, 0.6)
    thickness: tuple[Annotated[Metres, Positive], ...] = (1.8, 1.5, 0.2)


class MeshCase(Section):
    """Mesh of the blades; ``file`` takes a mesh of one's own instead."""

    cell: Literal["hexahedron", "tetrahedron"] = "hexahedron"
    elements: tuple[Count, Count, Count] = (2, 2, 12)
    size: Annotated[Metres, Positive] | None = None
    degree: Degree = 1
    geometry_degree: Degree = 1
    file: str | None = None


Stiffness = Annotated[Pascal, Finite]
Ratio = Annotated[Number, Finite]


class MaterialCase(Section):
    """Material of the blades: law, its constants [Pa, -], density [kg/m^3] and viscosity [Pa s].

    ``"transversely_isotropic_finite"`` has the stiffness of ``"transversely_isotropic"`` at rest
    and resists being crushed; it takes the shear modulus 23 from the others. Viscosities damp the
    blades, see `turbine_fenicsx.materials.KelvinVoigt`.
    """

    law: Literal[
        "transversely_isotropic",
        "transversely_isotropic_finite",
        "st_venant_kirchhoff",
        "neo_hooke",
    ] = "transversely_isotropic"
    density: Annotated[Density, Positive] = 1500.0
    young: tuple[Stiffness, Stiffness, Stiffness] = (45e9, 15e9, 15e9)
    shear: tuple[Stiffness, Stiffness, Stiffness] = (5.4e9, 5.4e9, 5.4e9)
    poisson: tuple[Ratio, Ratio, Ratio] = (0.3, 0.3, 0.3)
    first_lame: Stiffness = 3.9e9
    shear_modulus: Stiffness = 0.975e9
    shear_viscosity: Annotated[Viscosity, NotNegative] = 0.0
    bulk_viscosity: Annotated[Viscosity, NotNegative] = 0.0

    def make(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material with the given axes."""
        from turbine_fenicsx.materials import KelvinVoigt

        elastic = self._elastic(frame)
        if self.shear_viscosity == self.bulk_viscosity == 0.0:
            return elastic
        return KelvinVoigt(elastic, self.shear_viscosity, self.bulk_viscosity)

    def _elastic(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material without viscosity."""
        from turbine_fenicsx import materials as m

        if self.law == "transversely_isotropic":
            return m.OrthotropicSVK(self.young, self.shear, self.poisson, frame)
        if self.law == "transversely_isotropic_finite":
            for name, i, j in (("young", 1, 2), ("shear", 0, 1), ("poisson", 0, 1)):
                values = getattr(self, name)
                if values[i] != values[j]:
                    raise ModelError(
                        f"material.{name} = {list(values)}: expected entries {i + 1} and {j + 1} "
                        f'to be equal with material.law = "{self.law}"'
                    )
            (E1, E2, _), (n12, _, n23) = self.young, self.poisson
            return m.TransverselyIsotropic(E1, E2, self.shear[0], n12, n23, frame[0])
        law = m.StVenantKirchhoff if self.law == "st_venant_kirchhoff" else m.NeoHooke
        return law(self.first_lame, self.shear_modulus)


class LoadsCase(Section):
    """Gravity, and hat functions of torque on rotor, yaw and pitch bearings, eq. (60)."""

    gravity: Annotated[Acceleration, NotNegative] = 9.81
    rotor_torque: Annotated[Torque, Finite] = 0.0
    yaw_torque: Annotated[Torque, Finite] = 0.0
    pitch_torque: Annotated[Torque, Finite] = 0.0
    duration: Annotated[Seconds, Positive] = 3.0


class SolverCase(Section):
    """Solver of the step."""

    linear_solver: Literal["auto", "frozen", "iterative", "lu", "monolithic"] = "auto"
    tolerance: Annotated[Number, Field(gt=0.0, lt=1.0)] = 1e-12
    max_iterations: Annotated[Whole, Field(ge=1, le=100_000)] = 30


class OutputCase(Section):
    """Output; 0 = never.

    ``fields_every`` is the simulated time between two outputs of fields, ``checkpoint_every`` that
    between two checkpoints; ``checkpoint_wall_time`` is the wall time between them. There always is
    one at the start and at the end.
    """

    fields_every: Annotated[Seconds, NotNegative] = 0.1
    checkpoint_every: Annotated[Seconds, NotNegative] = 0.0
    checkpoint_wall_time: Annotated[Seconds, NotNegative] = 300.0


class Tables(Section):
    """All tables of a case file."""

    title: str = ""
    time: TimeCase = TimeCase()
    turbine: TurbineCase = TurbineCase()
    blade: BladeCase = BladeCase()
    mesh: MeshCase = MeshCase()
    material: MaterialCase = MaterialCase()
    pitch: PitchCase = PitchCase()
    tower: TowerCase = TowerCase()
    loads: LoadsCase = LoadsCase()
    solver: SolverCase = SolverCase()
    output: OutputCase = OutputCase()

    @property
    def has_pitch_bearings(self) -> bool:
        """Whether the blades can turn about their spans: always in the rigid turbine."""
        return has_bearings(self.pitch, self.turbine.model)

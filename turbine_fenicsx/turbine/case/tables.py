"""The tables of a case file, their keys, defaults and ranges.

A new key is a line here; a new table is a class and a line in `Tables`, and stands in a file of its
own with the checks of its component, as `turbine_fenicsx.turbine.case.tower`. What belongs to a
value is in its type: unit, range, choices. What keys of several tables have to do with each other
is in `turbine_fenicsx.turbine.case.consistency`.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.turbine.case.control import ControlCase
from turbine_fenicsx.turbine.case.drivetrain import DrivetrainCase, YawCase
from turbine_fenicsx.turbine.case.event import EventCases
from turbine_fenicsx.turbine.case.gauges import GaugeCases
from turbine_fenicsx.turbine.case.generator import GeneratorCase
from turbine_fenicsx.turbine.case.parameters import PRINTED_ARMS, TurbineParameters
from turbine_fenicsx.turbine.case.pitch import PitchCase, has_bearings
from turbine_fenicsx.turbine.case.quantities import (
    Acceleration,
    AngularSpeed,
    Density,
    Metres,
    Number,
    Pascal,
    Radians,
    Seconds,
    Torque,
    Unit,
    Viscosity,
    Whole,
    to_si,
)
from turbine_fenicsx.turbine.case.rigid_parts import HubCase, NacelleCase, RigidBladeCase
from turbine_fenicsx.turbine.case.section import (
    HUGE,
    Count,
    Degree,
    Finite,
    NotNegative,
    Positive,
    Section,
)
from turbine_fenicsx.turbine.case.tower import TowerCase
from turbine_fenicsx.turbine.case.wind import AeroCase, WindCase

if TYPE_CHECKING:  # no case needs MPI to be read
    from turbine_fenicsx.meshing import BladeGeometry

MAX_LEAN = pi / 4.0
"""Largest tilt of the shaft and cone of the blades [rad]."""


class TimeCase(Section):
    """Time step and end of the run [s], and the integrator.

    ``scheme`` is the energy-momentum scheme of the paper, or the generalised-alpha method, which
    damps high frequencies but conserves neither energy nor momenta: ``spectral_radius`` is what a
    step leaves of a mode of infinite frequency.

    A run starts from the undeformed turbine, its static equilibrium, or the state in which it turns
    at ``turbine.rotor_speed``. ``ramp`` is the time in which all loads but weight set in.

    With a tolerance, steps whose estimated error exceeds it are halved, and grow again up to
    ``step``: of directions of rigid bodies [rad], of displacements [m].
    """

    step: Annotated[Seconds, Positive] = 0.02
    end: Annotated[Seconds, NotNegative] = 12.0
    start: Literal["undeformed", "equilibrium", "turning"] = "undeformed"
    ramp: Annotated[Seconds, NotNegative] = 0.0
    angle_tolerance: Annotated[Number, Positive] | None = None
    displacement_tolerance: Annotated[Metres, Positive] | None = None
    scheme: Literal["energy_momentum", "generalised_alpha"] = "energy_momentum"
    spectral_radius: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.9


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
    file: str | None = None
    rotor_speed: Annotated[AngularSpeed, Finite] = 0.0
    azimuth: Annotated[Radians, Field(ge=-2.0 * pi, le=2.0 * pi)] = 0.0
    blade_arm: Annotated[Literal["printed"] | float, BeforeValidator(_check_arm), Unit("m")] = (
        "printed"
    )
    angle_form: Literal["regular", "paper"] = "regular"
    numerical_dissipation: Annotated[Number, NotNegative] = 0.0
    hub_distance: Annotated[Metres, Positive] = 5.0
    hub_rise: Annotated[Metres, Finite] = 0.0
    tilt: Annotated[Radians, Field(ge=-MAX_LEAN, le=MAX_LEAN)] = 0.0
    precone: Annotated[Radians, Field(ge=-MAX_LEAN, le=MAX_LEAN)] = 0.0
    nacelle: NacelleCase = NacelleCase()
    hub: HubCase = HubCase()
    blade: RigidBladeCase = RigidBladeCase()

    def parameters(self) -> TurbineParameters:
        """The parameters for the builders."""
        arms = PRINTED_ARMS if self.blade_arm == "printed" else (float(self.blade_arm),) * 3
        return TurbineParameters(
            arms, self.nacelle.inertia_data(), self.hub.inertia_data(), self.blade.inertia_data()
        )


class BladeCase(Section):
    """Shape of a blade, see `turbine_fenicsx.meshing.BladeGeometry`; or layup of that of a file.

    ``"homogenised"`` walls have the stiffness of their plies in the plane, ``"laminate"`` walls
    also in bending.
    """

    hub_radius: Annotated[Metres, Positive] = 2.25
    length: Annotated[Metres, Positive] = 54.0
    stations: tuple[Annotated[Number, NotNegative], ...] = (0.0, 0.2, 1.0)
    chord: tuple[Annotated[Metres, Positive], ...] = (1.8, 3.0, 0.6)
    thickness: tuple[Annotated[Metres, Positive], ...] = (1.8, 1.5, 0.2)
    wall: tuple[Annotated[Metres, Positive], ...] | None = None
    twist: tuple[Annotated[Radians, Field(ge=-pi, le=pi)], ...] | None = None
    layup: Literal["homogenised", "laminate"] = "homogenised"

    def geometry(self) -> BladeGeometry:
        """The shape of a blade with elliptic sections.

        Raises:
            ModelError: if stations and widths do not fit together.
        """
        from turbine_fenicsx.meshing import BladeGeometry

        return BladeGeometry(**self.model_dump(exclude={"layup"}))


class MeshCase(Section):
    """Mesh of the blades; ``file`` takes a mesh of one's own instead.

    Hollow blades have ``span`` elements along the span and ``around`` around a section; those of a
    windIO file end in a plate, or in an open ``tip``.
    """

    cell: Literal["hexahedron", "tetrahedron"] = "hexahedron"
    elements: tuple[Count, Count, Count] = (2, 2, 12)
    size: Annotated[Metres, Positive] | None = None
    degree: Degree = 1
    geometry_degree: Degree = 1
    span: Count = 40
    around: Count = 24
    tip: Literal["closed", "open"] = "closed"
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
        "windio",
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
        return self.add_viscosity(self._elastic(frame))

    def add_viscosity(self, elastic: Any) -> Any:
        """A material with the viscosities of this table."""
        from turbine_fenicsx.materials import KelvinVoigt

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
    """Gravity, and torques on rotor, yaw and pitch bearings.

    Torques are hat functions of time, eq. (60), or columns of the same names in a ``file`` of
    comma-separated values.
    """

    gravity: Annotated[Acceleration, NotNegative] = 9.81
    file: str | None = None
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
    gauges: GaugeCases = Field(default_factory=dict)


class Tables(Section):
    """All tables of a case file."""

    title: str = ""
    time: TimeCase = TimeCase()
    turbine: TurbineCase = TurbineCase()
    blade: BladeCase = BladeCase()
    mesh: MeshCase = MeshCase()
    material: MaterialCase = MaterialCase()
    pitch: PitchCase = PitchCase()
    drivetrain: DrivetrainCase = DrivetrainCase()
    yaw: YawCase = YawCase()
    tower: TowerCase = TowerCase()
    wind: WindCase = WindCase()
    aero: AeroCase = AeroCase()
    control: ControlCase = ControlCase()
    event: EventCases = Field(default_factory=dict)
    generator: GeneratorCase = GeneratorCase()
    loads: LoadsCase = LoadsCase()
    solver: SolverCase = SolverCase()
    output: OutputCase = OutputCase()

    @property
    def hub_height(self) -> float:
        """Height of the rotor centre above ground [m]."""
        given = self.wind.hub_height
        return self.tower.height + self.turbine.hub_rise if given is None else given

    @property
    def has_pitch_bearings(self) -> bool:
        """Whether the blades can turn about their spans: always in the rigid turbine."""
        return has_bearings(self.pitch, self.turbine.model)

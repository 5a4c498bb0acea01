"""The tables of a case file, their keys, defaults and ranges.

A new key is a line here with a docstring that says what it means; the reference and the command
``keys`` show it. A new table is a class and a line in `Tables`. It has a separate file with the
checks of its component, as `turbine_fenicsx.turbine.tables.tower`. The type of a value holds its
unit, range and choices. Relations between keys of several tables are in
`turbine_fenicsx.turbine.case.consistency`.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from turbine_fenicsx.case.files import DataFile, keep_name
from turbine_fenicsx.case.quantities import (
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
from turbine_fenicsx.case.section import (
    HUGE,
    Count,
    Degree,
    Finite,
    NotNegative,
    Positive,
    Section,
)
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.turbine.tables.control import ControlCase
from turbine_fenicsx.turbine.tables.damping import BladeDamping, BladeDampingCase
from turbine_fenicsx.turbine.tables.drivetrain import DrivetrainCase, YawCase
from turbine_fenicsx.turbine.tables.event import EventCases
from turbine_fenicsx.turbine.tables.gauges import GaugeCases
from turbine_fenicsx.turbine.tables.generator import GeneratorCase
from turbine_fenicsx.turbine.tables.parameters import PRINTED_ARMS, TurbineParameters
from turbine_fenicsx.turbine.tables.pitch import PitchCase, has_bearings
from turbine_fenicsx.turbine.tables.rigid_parts import HubCase, NacelleCase, RigidBladeCase
from turbine_fenicsx.turbine.tables.tower import TowerCase
from turbine_fenicsx.turbine.tables.wind import AeroCase, WindCase

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
    """Time step Δt."""
    end: Annotated[Seconds, NotNegative] = 12.0
    """End of the run; the last step is shortened to meet it."""
    start: Literal["undeformed", "equilibrium", "turning"] = "undeformed"
    """State at t = 0: undeformed, static equilibrium, or turning at ``turbine.rotor_speed``, see
    howto/start."""
    ramp: Annotated[Seconds, NotNegative] = 0.0
    """Time in which torques set in smoothly; 0 for a sudden start."""
    angle_tolerance: Annotated[Number, Positive] | None = None
    """Largest error of a step in directions of rigid bodies, in rad; none: no limit."""
    displacement_tolerance: Annotated[Metres, Positive] | None = None
    """Largest error of a step in positions; none: no limit."""
    scheme: Literal["energy_momentum", "generalised_alpha"] = "energy_momentum"
    """Integrator: the energy-momentum scheme of the paper, or the generalised-alpha method for
    comparison."""
    spectral_radius: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.9
    """Spectral radius of the generalised-alpha method: the factor by which one step reduces a mode
    of infinite frequency."""


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
    file: Annotated[str | None, DataFile("windIO file", find=keep_name)] = None
    """File of a whole turbine in windIO's format, relative to the case file, or the name of one of
    windIO's examples; keys of the case override its values, see howto/real_turbine."""
    rotor_speed: Annotated[AngularSpeed, Finite] = 0.0
    """Speed of the rotor at t = 0, positive about the shaft, downwind."""
    azimuth: Annotated[Radians, Field(ge=-2.0 * pi, le=2.0 * pi)] = 0.0
    """Angle of the rotor at t = 0, positive about the shaft, downwind."""
    blade_arm: Annotated[Literal["printed"] | float, BeforeValidator(_check_arm), Unit("m")] = (
        "printed"
    )
    """Distance of the centres of rigid blades from the hub centre; ``"printed"``: 29.598, 29.25
    and 29.598 m as in (28)-(32)."""
    angle_form: Literal["regular", "paper"] = "regular"
    """Form of the joint angle constraint, see theory/joints."""
    numerical_dissipation: Annotated[Number, NotNegative] = 0.0
    """Factor chi of the energy-decaying variant; 0 conserves energy."""
    hub_distance: Annotated[Metres, Positive] = 5.0
    """Horizontal distance a of the hub centre from the yaw axis, see howto/turbine_options."""
    hub_rise: Annotated[Metres, Finite] = 0.0
    """Height of the hub centre above the tower top."""
    tilt: Annotated[Radians, Field(ge=-MAX_LEAN, le=MAX_LEAN)] = 0.0
    """Angle between shaft and horizontal, as in OpenFAST negative if the shaft rises towards the
    rotor."""
    precone: Annotated[Radians, Field(ge=-MAX_LEAN, le=MAX_LEAN)] = 0.0
    """Angle between the blades and the plane normal to the shaft, as in OpenFAST negative if the
    blades lean upwind."""
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
    """Radius of the hub, where the blades begin."""
    length: Annotated[Metres, Positive] = 54.0
    """Length from the hub to the tip."""
    stations: tuple[Annotated[Number, NotNegative], ...] = (0.0, 0.2, 1.0)
    """Places along the span, as fractions of the length, from 0 to 1."""
    chord: tuple[Annotated[Metres, Positive], ...] = (1.8, 3.0, 0.6)
    """Full width along the chord, one for each station."""
    thickness: tuple[Annotated[Metres, Positive], ...] = (1.8, 1.5, 0.2)
    """Full width across the chord, one for each station."""
    wall: tuple[Annotated[Metres, Positive], ...] | None = None
    """Thickness of the wall of hollow blades, one for each station; none: they are solid."""
    twist: tuple[Annotated[Radians, Field(ge=-pi, le=pi)], ...] | None = None
    """Angle by which the leading edge is turned upwind, as in OpenFAST, one for each station;
    none: no twist."""
    layup: Literal["homogenised", "laminate"] = "homogenised"
    """Walls of blades of ``turbine.file``: with the in-plane stiffness of their plies, or with
    their bending stiffness too."""
    damping: BladeDamping = BladeDampingCase()
    """Structural damping: a ratio such as ``"0.5 %"``, or a table with ratios of named modes, see
    howto/damping; 0.5 % beside ``turbine.file``."""

    def geometry(self) -> BladeGeometry:
        """The shape of a blade with elliptic sections.

        Raises:
            ModelError: if stations and widths do not fit together.
        """
        from turbine_fenicsx.meshing import BladeGeometry

        return BladeGeometry(**self.model_dump(exclude={"layup", "damping"}))


class MeshCase(Section):
    """Mesh of the blades; ``file`` takes a custom mesh instead.

    Hollow blades have ``span`` elements along the span and ``around`` around a section; those of a
    windIO file end in a plate, or in an open ``tip``.
    """

    cell: Literal["hexahedron", "tetrahedron"] = "hexahedron"
    """Kind of the cells."""
    elements: tuple[Count, Count, Count] = (2, 2, 12)
    """Numbers of elements along chord, thickness and span."""
    size: Annotated[Metres, Positive] | None = None
    """Target length of element edges; takes the place of ``elements``."""
    degree: Degree = 1
    """Polynomial degree of the displacement."""
    geometry_degree: Degree = 1
    """2 for curved cells, with ``degree = 2`` only."""
    span: Count = 40
    """Number of elements of hollow blades along the span."""
    around: Count = 24
    """Number of elements of hollow blades around a section, webs not counted."""
    tip: Literal["closed", "open"] = "closed"
    """End of the blades of ``turbine.file``: ``"closed"`` by a plate, or ``"open"``, see
    howto/real_turbine."""
    file: Annotated[str | None, DataFile("mesh")] = None
    """Your own ``.msh`` file, relative to the case file, see howto/mesh; beside ``turbine.file``
    one that the command ``mesh`` has written for it."""


Stiffness = Annotated[Pascal, Finite]
Ratio = Annotated[Number, Finite]


class MaterialCase(Section):
    """Material of the blades: law, its constants [Pa, -], density [kg/m^3] and viscosity [Pa s].

    ``"transversely_isotropic_finite"`` has the stiffness of ``"transversely_isotropic"`` at rest
    and resists being crushed; it takes the shear modulus 23 from the others. Viscosities damp the
    blades, see `turbine_fenicsx.KelvinVoigt`.
    """

    law: Literal[
        "transversely_isotropic",
        "transversely_isotropic_finite",
        "st_venant_kirchhoff",
        "neo_hooke",
        "windio",
    ] = "transversely_isotropic"
    """Strain energy; ``"windio"`` is the layup of ``turbine.file``."""
    density: Annotated[Density, Positive] = 1500.0
    """Density in the initial configuration."""
    young: tuple[Stiffness, Stiffness, Stiffness] = (45e9, 15e9, 15e9)
    """Young's moduli E₁, E₂, E₃ of the two transversely isotropic laws; 1 is the span."""
    shear: tuple[Stiffness, Stiffness, Stiffness] = (5.4e9, 5.4e9, 5.4e9)
    """Shear moduli G₁₂, G₁₃, G₂₃ of these two laws."""
    poisson: tuple[Ratio, Ratio, Ratio] = (0.3, 0.3, 0.3)
    """Poisson's ratios 12, 13 and 23 of these two laws."""
    first_lame: Stiffness = 3.9e9
    """First Lame constant of the two isotropic laws."""
    shear_modulus: Stiffness = 0.975e9
    """Shear modulus of the two isotropic laws."""
    shear_viscosity: Annotated[Viscosity, NotNegative] = 0.0
    """Viscosity of the deviator of the strain rate."""
    bulk_viscosity: Annotated[Viscosity, NotNegative] = 0.0
    """Viscosity of the trace of the strain rate."""

    def make(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material with the given axes."""
        return self.add_viscosity(self._elastic(frame))

    def add_viscosity(self, elastic: Any) -> Any:
        """A material with the viscosities of this table."""
        from turbine_fenicsx.materials.kelvin_voigt import KelvinVoigt

        if self.shear_viscosity == self.bulk_viscosity == 0.0:
            return elastic
        return KelvinVoigt(elastic, self.shear_viscosity, self.bulk_viscosity)

    def _elastic(self, frame: tuple[Any, Any, Any]) -> Any:
        """The material without viscosity."""
        from turbine_fenicsx.materials.neo_hooke import NeoHooke
        from turbine_fenicsx.materials.orthotropic import OrthotropicSVK
        from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
        from turbine_fenicsx.materials.transversely_isotropic import TransverselyIsotropic

        if self.law == "transversely_isotropic":
            return OrthotropicSVK(
                young=self.young, shear=self.shear, poisson=self.poisson, frame=frame
            )
        if self.law == "transversely_isotropic_finite":
            for name, i, j in (("young", 1, 2), ("shear", 0, 1), ("poisson", 0, 1)):
                values = getattr(self, name)
                if values[i] != values[j]:
                    raise ModelError(
                        f"material.{name} = {list(values)}: expected entries {i + 1} and {j + 1} "
                        f'to be equal with material.law = "{self.law}"'
                    )
            (E1, E2, _), (n12, _, n23) = self.young, self.poisson
            return TransverselyIsotropic(E1, E2, self.shear[0], n12, n23, frame[0])
        law = StVenantKirchhoff if self.law == "st_venant_kirchhoff" else NeoHooke
        return law(self.first_lame, self.shear_modulus)


class LoadsCase(Section):
    """Gravity, and torques on rotor, yaw and pitch bearings.

    Torques are hat functions of time, eq. (60), or columns of the same names in a ``file`` of
    comma-separated values.
    """

    gravity: Annotated[Acceleration, NotNegative] = 9.81
    """Acceleration, downwards."""
    file: Annotated[str | None, DataFile("loads file")] = None
    """CSV file with ``time`` and one or more of ``rotor_torque``, ``yaw_torque``,
    ``pitch_torque``, relative to the case file, see howto/tables."""
    rotor_torque: Annotated[Torque, Finite] = 0.0
    """Peak of the torque on the rotor bearing, positive about e₃."""
    yaw_torque: Annotated[Torque, Finite] = 0.0
    """Peak of the torque on the yaw bearing, negative about e₂."""
    pitch_torque: Annotated[Torque, Finite] = 0.0
    """Peak of the torque on each pitch bearing, positive to feather."""
    duration: Annotated[Seconds, Positive] = 3.0
    """Duration of all hat functions, which begin at t = 0."""


class SolverCase(Section):
    """Solver of the step."""

    linear_solver: Literal["frozen", "iterative", "lu", "monolithic"] = "frozen"
    """Linear solver, see howto/solver."""
    tolerance: Annotated[Number, Field(gt=0.0, lt=1.0)] = 1e-12
    """Relative residual at which an iteration ends."""
    max_iterations: Annotated[Whole, Field(ge=1, le=100_000)] = 30
    """Largest number of Newton iterations of an attempt."""


class OutputCase(Section):
    """Output; 0 = never.

    ``fields_every`` is the simulated time between two outputs of fields, ``checkpoint_every`` that
    between two checkpoints; ``checkpoint_wall_time`` is the wall time between them. There always is
    one at the start and at the end.
    """

    fields_every: Annotated[Seconds, NotNegative] = 0.1
    """Simulated time between two outputs of fields; 0: no fields."""
    checkpoint_every: Annotated[Seconds, NotNegative] = 0.0
    """Simulated time between two checkpoints; 0: by wall time alone."""
    checkpoint_wall_time: Annotated[Seconds, NotNegative] = 300.0
    """Wall time between two checkpoints; 0: only at start and end."""
    gauges: GaugeCases = Field(default_factory=dict)


class Tables(Section):
    """All tables of a case file; the title stands before them."""

    title: str = ""
    """Title of plots, tables and ``history.out``."""
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

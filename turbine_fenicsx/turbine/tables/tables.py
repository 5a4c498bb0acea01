"""All tables of a case file; the reference and the command ``keys`` show them.

A new key is a line in the class of its table, with a docstring that says what it means. Its type
holds unit, range and choices, marks in it say when it counts and whether it names a file. A new
table is a file with its class, and a line in `Tables`.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from turbine_fenicsx.case.rules import AnyOf, Only, With
from turbine_fenicsx.case.section import Section
from turbine_fenicsx.turbine.tables.aero import AeroCase
from turbine_fenicsx.turbine.tables.blade import BladeCase
from turbine_fenicsx.turbine.tables.control import ControlCase
from turbine_fenicsx.turbine.tables.drivetrain import DrivetrainCase, YawCase
from turbine_fenicsx.turbine.tables.event import EventCases
from turbine_fenicsx.turbine.tables.generator import GeneratorCase
from turbine_fenicsx.turbine.tables.life import LifeCase
from turbine_fenicsx.turbine.tables.loads import LoadsCase
from turbine_fenicsx.turbine.tables.material import MaterialCase
from turbine_fenicsx.turbine.tables.mesh import MeshCase
from turbine_fenicsx.turbine.tables.output import OutputCase
from turbine_fenicsx.turbine.tables.pitch import PitchCase
from turbine_fenicsx.turbine.tables.time import SolverCase, TimeCase
from turbine_fenicsx.turbine.tables.tower import TowerCase
from turbine_fenicsx.turbine.tables.turbine import TurbineCase
from turbine_fenicsx.turbine.tables.wind import BLOWS, WindCase


class Tables(Section):
    """All tables of a case file; the title stands before them."""

    title: str = ""
    """Title of plots, tables and ``history.out``."""
    time: TimeCase = TimeCase()
    turbine: TurbineCase = TurbineCase()
    blade: BladeCase = BladeCase()
    mesh: Annotated[MeshCase, AnyOf(Only("turbine.model", "hybrid"), With("turbine.file"))] = (
        MeshCase()
    )
    material: Annotated[MaterialCase, Only("turbine.model", "hybrid")] = MaterialCase()
    pitch: PitchCase = PitchCase()
    drivetrain: DrivetrainCase = DrivetrainCase()
    yaw: YawCase = YawCase()
    tower: TowerCase = TowerCase()
    wind: WindCase = WindCase()
    aero: Annotated[AeroCase, BLOWS] = AeroCase()
    control: ControlCase = ControlCase()
    event: EventCases = Field(default_factory=dict)
    generator: GeneratorCase = GeneratorCase()
    loads: LoadsCase = LoadsCase()
    life: LifeCase = LifeCase()
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
        return self.turbine.model == "rigid" or self.pitch.bearings

    @property
    def has_solid_blades(self) -> bool:
        """Whether the blades are flexible and of one material, as the case describes them."""
        flexible = self.turbine.model == "hybrid" and self.turbine.file is None
        return flexible and self.blade.model != "beam"

    @property
    def has_reduced_blades(self) -> bool:
        """Whether the blades are flexible and move by few vectors: reduced ones and beams."""
        return self.turbine.model == "hybrid" and self.blade.model != "full"

    @property
    def has_beam_blades(self) -> bool:
        """Whether the blades are flexible and beams."""
        return self.turbine.model == "hybrid" and self.blade.model == "beam"

    @property
    def has_full_blades(self) -> bool:
        """Whether the blades are flexible and move on their whole mesh."""
        return self.turbine.model == "hybrid" and self.blade.model == "full"

    @property
    def has_reduced_tower(self) -> bool:
        """Whether the tower is flexible and moves by few vectors: never beside full blades."""
        return not self.has_full_blades and self.tower.flexible and self.tower.model != "full"

    @property
    def has_beam_tower(self) -> bool:
        """Whether the tower is a beam."""
        return self.has_reduced_tower and self.tower.model == "beam"

    @property
    def moves_by_vectors(self) -> bool:
        """Whether the blades or the tower move by few vectors: a run writes these, no fields."""
        return self.has_reduced_blades or self.has_reduced_tower

    @property
    def fields_every(self) -> float:
        """Time between two outputs of fields; 0 for none [s]."""
        return 0.0 if self.moves_by_vectors else self.output.fields_every

    @property
    def motion_every(self) -> float:
        """Time between two rows of the motion of reduced bodies; 0 for none [s]."""
        return self.output.motion_every if self.moves_by_vectors else 0.0

    @property
    def meshes_blades(self) -> bool:
        """Whether the blades have a mesh; that of rigid ones of a file gives their inertia."""
        return self.turbine.model == "hybrid" or self.turbine.file is not None

    @property
    def may_brake(self) -> bool:
        """Whether an event or a controller from outside may close a brake that has a torque."""
        by_event = any(event.kind == "brake" for event in self.event.values())
        return by_event or (self.control.is_foreign and self.drivetrain.brake_torque > 0.0)

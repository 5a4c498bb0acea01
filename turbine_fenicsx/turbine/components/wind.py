"""The wind on the blades: loads on their sections, and what the rotor takes out of the wind.

Forces F and moments M act on the sections of a blade, which move with v and turn with omega in the
middle of a step. Their work dt sum (F.v + M.omega) is that blade's share of the work of the wind to
round-off: loads go to nodes and directors by the transpose of how these move.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from turbine_fenicsx.forces.line_source import StepLoads
from turbine_fenicsx.forces.rigid_section_loads import RigidSectionLoads, RigidStations
from turbine_fenicsx.forces.section_loads import LineLoad, SectionLoads, StationLine
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.simulation.observer import Observer
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.clamped_blade import SKIN
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.components.rotor_air import (
    WIND,
    HubWind,
    RotorLoads,
    air_channels,
    node_channels,
)
from turbine_fenicsx.turbine.components.tower import tower_geometry
from turbine_fenicsx.turbine.components.wind_fields import WindFields
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.wind.aerodynamics import RotorAerodynamics
from turbine_fenicsx.wind.skew import SkewedWake
from turbine_fenicsx.wind.stall import OeyeStall
from turbine_fenicsx.wind.tower_shadow import TowerShadow
from turbine_fenicsx.wind.turning_start import TurningAtRest


class BladeWorks:
    """Adds up the works of a run, step after step, and survives a restart.

    Args:
        blades: Number of blades, each with equally many stations.
        find_loads: Loads in the step that led to a state; called on all ranks.

    Attributes:
        works: Work on each blade since the start, shape (blades,) [J].
    """

    name = "works on blades"

    def __init__(self, blades: int, find_loads: Callable[[Snapshot], StepLoads]) -> None:
        self._find_loads = find_loads
        self.works: Array = np.zeros(blades)

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """No step is done yet."""

    def observe(self, snapshot: Snapshot) -> None:
        """Add the works of a step."""
        motion, F, M, times = self._find_loads(snapshot)
        power = np.sum(F * motion.velocity + M * motion.angular_velocity, axis=1)
        self.works += times.dt * power.reshape(len(self.works), -1).sum(axis=1)

    def finish(self) -> None:
        """Nothing has to be closed."""

    def save(self) -> RestartData:
        """The works so far."""
        return RestartData({"works": self.works.tolist()})

    def restore(self, data: RestartData) -> None:
        """Restore works."""
        self.works = np.array(data.numbers["works"], dtype=float)


class AeroModels(TypedDict):
    """Arguments of `RotorAerodynamics`; None for what a case leaves out."""

    stall: OeyeStall | None
    skew: SkewedWake | None
    tower: TowerShadow | None


def make_aero_models(case: Tables) -> AeroModels:
    """Dynamic stall, skewed wake and tower of a case."""
    aero = case.aero
    return {
        "stall": OeyeStall() if aero.dynamic_stall == "oeye" else None,
        "skew": SkewedWake() if aero.skewed_wake else None,
        "tower": None if aero.tower_shadow == "none" else _make_tower(case),
    }


def _make_tower(case: Tables) -> TowerShadow:
    """The undeformed tower, which ends at the yaw bearing in the origin."""
    shape, aero = tower_geometry(case.tower), case.aero
    drag = aero.tower_drag if aero.tower_shadow == "powles" else 0.0
    heights, radii = shape.height * np.array(shape.stations), 0.5 * np.array(shape.diameters)
    return TowerShadow((0.0, -shape.height, 0.0), (0.0, 0.0, 0.0), heights, radii, drag=drag)


@dataclass(frozen=True)
class Wind(Component):
    """Blade-element momentum theory on the sections of flexible or rigid blades.

    Attributes:
        works: The system that runs and the works of the air on its blades; empty before.
    """

    works: list[tuple[MultibodySystem, BladeWorks]] = field(
        default_factory=list, init=False, compare=False
    )

    def parts(self, assembly: Assembly) -> list[Any]:
        """Loads named ``wind`` on all blades."""
        case, layout, inflow = assembly.case, assembly.rotor.layout, assembly.inflow
        assert inflow is not None
        blade = on_rank0(assembly.comm, lambda: load_aero_blade(case))
        numbers = range(1, layout.n_blades + 1)
        frames = [layout.frame(k) for k in numbers]
        hub = (layout.axes[2], layout.centre)
        source: LineLoad = RotorAerodynamics(
            blade,
            frames,
            *hub,
            inflow,
            case.wind.density,
            **make_aero_models(case),
            induction=case.aero.induction,
            pitch_rate=case.aero.pitch_rate,
            unsteady=case.aero.unsteady,
        )
        if case.turbine.rotor_speed:
            roots = len(blade.radius) * np.arange(layout.n_blades)
            source = TurningAtRest(source, roots, *hub, case.turbine.rotor_speed)
        if case.turbine.model == "rigid":
            stations = [
                RigidStations(
                    assembly.part(name),
                    np.array([layout.point_on_span(k, r) for r in blade.radius]),
                )
                for k, name in zip(numbers, BLADES, strict=True)
            ]
            return [RigidSectionLoads(WIND, stations, source)]
        mesh, reduced = assembly.meshes[BODY], case.has_reduced_blades
        lines = [
            StationLine(
                mesh.facets(SKIN if reduced else f"skin_{k}"),
                origin=layout.centre,
                axis=frame[0],
                stations=blade.radius,
                copy=k - 1 if reduced else 0,
            )
            for k, frame in zip(numbers, frames, strict=True)
        ]
        return [SectionLoads(WIND, assembly.part(BODY), lines, source)]

    def channels(self, turbine: Turbine) -> Channels:
        """Power, thrust and torque of the rotor, its speed, the wind, and the air on sections."""
        rotor = RotorLoads(turbine)
        hub = HubWind(turbine)

        def loads(s: Snapshot) -> list[float]:
            air, speed = rotor.at(s), rotor.speed(s.state)
            thrust, torque = float(air.force[0]), float(air.moment[0])
            return [torque * speed, thrust, torque, air.wind, speed * 30.0 / np.pi]

        columns = (
            *(names.AERO_POWER, names.AERO_THRUST, names.AERO_TORQUE),
            *(names.ROTOR_WIND, names.ROTOR_SPEED),
        )
        per_blade = Channel(
            tuple(names.BLADE_WORK(blade=k) for k in range(1, turbine.rotor.layout.n_blades + 1)),
            lambda s: self._works_of(turbine).works.tolist(),
        )
        at_hub = tuple(names.HUB_WIND(axis=axis) for axis in "xyz")
        return Channels(
            history=[Channel(columns, loads), Channel(at_hub, hub.at), per_blade],
            openfast=[
                in_openfast([f"Wind1Vel{axis}" for axis in "XYZ"], hub.at),
                *air_channels(turbine, rotor),
                *node_channels(turbine),
            ],
        )

    def observers(self, turbine: Turbine, folder: Path) -> list[Observer]:
        """The works of the air on each blade, and with fields the loads and the wind as vectors."""
        every = turbine.case.fields_every
        found: list[Observer] = [self._works_of(turbine)]
        if every > 0.0:
            blade = on_rank0(turbine.comm, lambda: load_aero_blade(turbine.case))
            path, end = turbine.case.output.name_file(folder, "wind"), turbine.case.time.end

            def find(state: State) -> StepLoads:
                return find_loads(turbine.system, WIND, state)

            found.append(WindFields(turbine, path, every, end, find, blade))
        return found

    def _works_of(self, turbine: Turbine) -> BladeWorks:
        """The works of a turbine, made where they are first asked for."""
        system, number = turbine.system, turbine.rotor.layout.n_blades
        if not self.works or self.works[0][0] is not system:
            works = BladeWorks(number, lambda s: find_loads(system, WIND, s.state))
            self.works[:] = [(system, works)]
        return self.works[0][1]

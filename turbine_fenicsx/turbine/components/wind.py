"""The wind on the blades: loads on their sections, and what the rotor takes out of the wind.

Thrust and torque are those of the air on the blades along and about the shaft. They belong to the
middle of the step that ends at the time of the row, at t = 0 to the first state. A turn by theta
about a shaft with the unit vector e moves a point in the middle x_m of its chord by

    x_1 - x_0 = 2 tan(theta/2) e x x_m,

so forces with the moment M about the shaft there do the work 2 tan(theta/2) M: the torque in the
step is M tan(theta/2)/(theta/2), and torque times mean speed is the power exactly.

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

from turbine_fenicsx.forces.line_source import SAME_TIME, StepLoads
from turbine_fenicsx.forces.rigid_section_loads import RigidSectionLoads, RigidStations
from turbine_fenicsx.forces.section_loads import LineLoad, SectionLoads, StationLine
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import cross_rows
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES, HUB
from turbine_fenicsx.simulation.observer import Observer
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.clamped_blade import SKIN
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.inflow import AXES
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.components.nacelle import ROTOR
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


WIND = "wind"
"""Name under which the work of the wind is reported."""


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
        """Power, thrust and torque of the rotor, its speed, and the wind at rotor and hub."""
        rotor, inflow = RotorLoads(turbine), turbine.inflow
        assert inflow is not None
        hub = np.asarray(turbine.rotor.layout.centre, dtype=float)
        kept: list[tuple[float, list[float]]] = []  # both time series show the same wind

        def loads(s: Snapshot) -> list[float]:
            thrust, torque, wind = rotor.at(s)
            speed = rotor.speed(s.state)
            return [torque * speed, thrust, torque, wind, speed * 30.0 / np.pi]

        def wind(s: Snapshot) -> list[float]:
            if not kept or kept[-1][0] != s.state.time:
                x, y, z = AXES @ inflow.velocity(hub, s.state.time)
                kept[:] = [(s.state.time, [float(x), float(y), float(z)])]
            return kept[-1][1]

        columns = (
            *(names.AERO_POWER, names.AERO_THRUST, names.AERO_TORQUE),
            *(names.ROTOR_WIND, names.ROTOR_SPEED),
        )
        openfast = ("RtAeroPwr_[W]", "RtAeroFxh_[N]", "RtAeroMxh_[N-m]", "RtVAvgxh_[m/s]")
        per_blade = Channel(
            tuple(names.BLADE_WORK(blade=k) for k in range(1, turbine.rotor.layout.n_blades + 1)),
            lambda s: self._works_of(turbine).works.tolist(),
        )
        at_hub = tuple(names.HUB_WIND(axis=axis) for axis in "xyz")
        return Channels(
            history=[Channel(columns, loads), Channel(at_hub, wind), per_blade],
            openfast=[
                Channel(tuple(f"Wind1Vel{axis}_[m/s]" for axis in "XYZ"), wind),
                Channel(openfast, lambda s: loads(s)[:4]),
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


class RotorLoads:
    """Thrust and torque of the air on the blades of a turbine."""

    def __init__(self, turbine: Turbine) -> None:
        self._system = turbine.system
        hub, layout = turbine.part(HUB), turbine.rotor.layout
        first = turbine.system.first_coordinate[hub]
        self._q = slice(first, first + 12)
        # constant coordinates in the frame of the hub
        self._centre = np.array([1.0, *hub.body_coordinates(layout.centre)])
        self._shaft = np.array([0.0, *(layout.axes[2] @ np.asarray(hub.directors))])
        self._inflow = turbine.inflow
        self._rotor = turbine.system.joint_coordinate_names.index(ROTOR)
        self._kept: tuple[float, tuple[float, float, float]] | None = None

    def at(self, snapshot: Snapshot) -> tuple[float, float, float]:
        """Thrust [N], torque [N m] and wind through the rotor [m/s]. Collective."""
        time = snapshot.state.time
        if self._kept is None or self._kept[0] != time:
            self._kept = (time, self._evaluate(snapshot.state))
        return self._kept[1]

    def speed(self, state: State) -> float:
        """Speed of the rotor, the mean of the last step [rad/s]."""
        return float(state.joint_rates[self._rotor])

    def _evaluate(self, state: State) -> tuple[float, float, float]:
        """As `at`."""
        loads, q = find_loads(self._system, WIND, state), state.q[self._q].reshape(4, 3)
        centre, shaft = self._centre @ q, self._shaft @ q
        motion, F = loads.motion, loads.force
        moment = cross_rows(motion.position - centre, F) + loads.moment
        half = 0.5 * loads.times.dt * self.speed(state)
        factor = np.tan(half) / half if half else 1.0
        assert self._inflow is not None
        wind = self._inflow.velocity(motion.position, loads.times.middle) - motion.velocity
        return (
            float(F.sum(axis=0) @ shaft),
            float(factor * (moment.sum(axis=0) @ shaft)),
            float(wind.mean(axis=0) @ shaft),
        )


def find_loads(system: MultibodySystem, name: str, state: State) -> StepLoads:
    """Loads on sections in the step that led to a state, or in the first state. Collective."""
    last = system.section_loads[name].last
    if last is not None and abs(last.times.end - state.time) <= SAME_TIME * last.times.dt:
        return last
    for model, u, v in zip(system.flexible_models, state.u, state.v, strict=True):
        for loads in model.section_loads:
            if loads.name == name:
                return loads.loads_at(u.array_r, v.array_r, state.time)
    rigid = next(x for x in system.rigid_section_loads if x.name == name)
    y = np.concatenate([state.q, state.joint_coordinates])[rigid.index]
    y_dot = np.concatenate([state.q_dot, state.joint_rates])[rigid.index]
    return rigid.loads_at(y, y_dot, state.time)

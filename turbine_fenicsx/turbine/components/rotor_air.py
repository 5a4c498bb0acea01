"""Loads of the air on rotor and blades, as channels.

Thrust and torque are those of the air on the blades along and about the shaft. They belong to the
middle of the step that ends at the time of the row, at t = 0 to the first state. A turn by theta
about a shaft with the unit vector e moves a point in the middle x_m of its chord by

    x_1 - x_0 = 2 tan(theta/2) e x x_m,

so forces with the moment M about the shaft there do the work 2 tan(theta/2) M: the torque in the
step is M tan(theta/2)/(theta/2), and torque times mean speed is the power exactly.

As in AeroDyn, V is the mean along the shaft of the wind relative to the stations. R is the radius
that the tips of the undeformed rotor sweep:

    C_P = P/(rho V^3 pi R^2/2),  C_Q = Q/(rho V^2 pi R^3/2),  C_T = T/(rho V^2 pi R^2/2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import cross_rows
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import BLADES, HUB
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.inflow import AXES
from turbine_fenicsx.turbine.components.axes import hub_axes
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.wind.aerodynamics import RotorAerodynamics
from turbine_fenicsx.wind.rotor import Rotor
from turbine_fenicsx.wind.section_air import SectionFlow
from turbine_fenicsx.wind.turning_start import TurningAtRest

WIND = "wind"
"""Name under which the work of the wind is reported."""


class RotorAir(NamedTuple):
    """Loads of the air on all blades, along the axes of the hub.

    Attributes:
        force: Shape (3,) [N].
        moment: About the rotor centre, shape (3,) [N m].
        wind: Mean along the shaft, relative to the stations [m/s].
    """

    force: Array
    moment: Array
    wind: float


class RotorLoads:
    """Loads of the air on the blades of a turbine."""

    def __init__(self, turbine: Turbine) -> None:
        self._system = turbine.system
        hub, layout = turbine.part(HUB), turbine.rotor.layout
        first = turbine.system.first_coordinate[hub]
        self._q = slice(first, first + 12)
        # constant coordinates in the frame of the hub
        self._centre = np.array([1.0, *hub.body_coordinates(layout.centre)])
        self._axes = hub_axes(layout) @ np.asarray(hub.directors)
        self._inflow = turbine.inflow
        self._rotor = turbine.system.joint_coordinate_names.index(ROTOR)
        self._kept: tuple[float, RotorAir] | None = None

    def at(self, snapshot: Snapshot) -> RotorAir:
        """The loads in the step that led to a snapshot. Collective."""
        time = snapshot.state.time
        if self._kept is None or self._kept[0] != time:
            self._kept = (time, self.evaluate(snapshot.state))
        return self._kept[1]

    def speed(self, state: State) -> float:
        """Speed of the rotor, the mean of the last step [rad/s]."""
        return float(state.joint_rates[self._rotor])

    def evaluate(self, state: State) -> RotorAir:
        """The loads in the step that led to a state, or in a first state. Collective."""
        loads, q = find_loads(self._system, WIND, state), state.q[self._q].reshape(4, 3)
        centre, axes = self._centre @ q, self._axes @ q[1:]
        motion, F = loads.motion, loads.force
        moments = cross_rows(motion.position - centre, F) + loads.moment
        half = 0.5 * loads.times.dt * self.speed(state)
        moment = axes @ moments.sum(axis=0)
        moment[0] *= np.tan(half) / half if half else 1.0
        assert self._inflow is not None
        wind = self._inflow.velocity(motion.position, loads.times.middle) - motion.velocity
        return RotorAir(axes @ F.sum(axis=0), moment, float(wind.mean(axis=0) @ axes[0]))


class HubWind:
    """The wind where the hub stood at the start, which both histories show."""

    def __init__(self, turbine: Turbine) -> None:
        assert turbine.inflow is not None
        self._inflow = turbine.inflow
        self._hub = np.asarray(turbine.rotor.layout.centre, dtype=float)
        self._kept: tuple[float, list[float]] | None = None

    def at(self, snapshot: Snapshot) -> list[float]:
        """Velocity downwind, to the left and up [m/s]."""
        time = snapshot.state.time
        if self._kept is None or self._kept[0] != time:
            self._kept = time, (AXES @ self._inflow.velocity(self._hub, time)).tolist()
        return self._kept[1]


def air_channels(turbine: Turbine, rotor: RotorLoads) -> list[Channel]:
    """Loads of the air on the rotor and their coefficients. Collective."""
    case = turbine.case
    blade = on_rank0(turbine.comm, lambda: load_aero_blade(case))
    R = Rotor(blade, precone=-case.turbine.precone).tip_distance
    area = np.pi * R * R

    def power(s: Snapshot) -> list[float]:
        return [float(rotor.at(s).moment[0]) * rotor.speed(s.state)]

    def coefficients(s: Snapshot) -> list[float]:
        air, speed = rotor.at(s), rotor.speed(s.state)
        if air.wind <= 0.0:
            return [0.0] * 4
        pressure = 0.5 * case.wind.density * air.wind**2 * area
        C_Q = float(air.moment[0]) / (pressure * R)
        ratio = speed * R / air.wind
        return [C_Q * ratio, C_Q, float(air.force[0]) / pressure, ratio]

    return [
        in_openfast(("RtAeroPwr",), power),
        in_openfast([f"RtAeroF{axis}h" for axis in "xyz"], lambda s: rotor.at(s).force),
        in_openfast([f"RtAeroM{axis}h" for axis in "xyz"], lambda s: rotor.at(s).moment),
        in_openfast(("RtVAvgxh",), lambda s: [rotor.at(s).wind]),
        in_openfast(("RtAeroCp", "RtAeroCq", "RtAeroCt", "RtTSR"), coefficients),
        in_openfast(("RtArea",), lambda s: [area]),
    ]


NODES = {
    "Alpha": "attack",
    "Phi": "inflow",
    "Vrel": "speed",
    "Cl": "lift",
    "Cd": "drag",
    "Fn": "normal",
    "Ft": "tangential",
    "Fx": "axial",
    "Fy": "driving",
    "AxInd": "induction",
    "TnInd": "swirl",
}
"""Quantities at nodes by the ends of their names, and what they are of `SectionFlow`."""


class NodeFlow:
    """The flow at all stations of all blades in the step that led to a state."""

    def __init__(self, turbine: Turbine) -> None:
        self._system = turbine.system
        source = turbine.part(WIND).source
        source = source.source if isinstance(source, TurningAtRest) else source
        assert isinstance(source, RotorAerodynamics)
        self._source = source
        self._kept: tuple[float, SectionFlow] | None = None

    def at(self, state: State) -> SectionFlow:
        """The flow, one blade after another. Collective."""
        if self._kept is None or self._kept[0] != state.time:
            loads = find_loads(self._system, WIND, state)
            self._kept = state.time, self._source.find_flow(loads.motion, loads.times.middle)
        return self._kept[1]


def node_channels(turbine: Turbine) -> list[Channel]:
    """Flow and line loads at the stations of the blades, counted from the root.

    As in the names of OpenFAST there are two digits for them.
    """
    flow = NodeFlow(turbine)
    stations = min(turbine.case.aero.stations, 99)

    def make(end: str, field: str) -> Channel:
        sign = -1.0 if end == "Fy" else 1.0
        return in_openfast(
            [
                f"B{blade}N{node}{end}"
                for blade in range(1, len(BLADES) + 1)
                for node in range(1, stations + 1)
            ],
            lambda s: sign * getattr(flow.at(s.state), field),
        )

    return [make(end, field) for end, field in NODES.items()]

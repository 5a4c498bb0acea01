"""Numbers of a turbine in a steady state, and values along its blades.

Weight and wind that is not the same everywhere bend the blades by their azimuth. An equilibrium in
a turning frame keeps this shape as it turns, and its momenta p and L, about the point a of the axis
n, change with

    dp/dt = Omega n x p,    dL/dt = Omega n x L.

In a revolution these changes are zero on average. So they are added to loads on what does not turn,
which are then those of air and weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import interp1d
from scipy.spatial.transform import Rotation

from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.records.loads_along import COLUMNS
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.components.axes import TOWER_AXES, blade_axes
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.flexible_blades import make_tips
from turbine_fenicsx.turbine.components.interface_loads import InterfaceLoads
from turbine_fenicsx.turbine.components.nacelle import ROTOR, SUPPORT
from turbine_fenicsx.turbine.components.pitch import BEARINGS
from turbine_fenicsx.turbine.components.root_channels import RootLoads
from turbine_fenicsx.turbine.components.rotor_air import WIND, NodeFlow, RotorLoads
from turbine_fenicsx.turbine.components.slender_loads import SlenderLoads, find_blade_sections
from turbine_fenicsx.turbine.components.tower import find_tower_base
from turbine_fenicsx.turbine.steady.operating_states import DEGREE, RPM, OperatingState
from turbine_fenicsx.turbine.steady.steady_turbine import SteadyTurbine
from turbine_fenicsx.wind.rotor import Rotor


@dataclass(frozen=True)
class SteadyState:
    """A steady state; values of blades are means over all of them.

    Args:
        operating: How the turbine is run.
        numbers: Numbers of the turbine by their names with units.
        along: Values at the stations of a blade by their names with units, shape (n,) each.
    """

    operating: OperatingState
    numbers: dict[str, float]
    along: dict[str, Array]


class SteadyReader:
    """Reads steady states of a turbine.

    Args:
        steady: The turbine.

    Note:
        Collective.
    """

    def __init__(self, steady: SteadyTurbine) -> None:
        self._turbine = turbine = steady.turbine
        self._blade = on_rank0(turbine.comm, lambda: load_aero_blade(steady.case))
        rotor = Rotor(self._blade, precone=-steady.case.turbine.precone)
        self._radius = rotor.tip_distance
        self._air, self._roots = RotorLoads(turbine), RootLoads(turbine)
        self._interfaces = InterfaceLoads(turbine, turning=False)
        self._base, self._efficiency = find_tower_base(turbine), steady.efficiency
        is_rigid = turbine.case.turbine.model == "rigid"
        self._tips = None if is_rigid else make_tips(turbine)
        self._sections = None if is_rigid else _find_sections(turbine, self._blade.radius)
        joints = {joint.name: joint for joint in turbine.system.joints}
        bodies = (joints[name].bodies[1] for name in BEARINGS)
        self._carriers = [body for body in bodies if body is not None]

    def read(self, operating: OperatingState, states: Sequence[State]) -> SteadyState:
        """Means over equilibria at several azimuths."""
        read = [self._read(operating, state) for state in states]
        numbers = {k: float(np.mean([x.numbers[k] for x in read])) for k in read[0].numbers}
        along = {k: np.mean([x.along[k] for x in read], axis=0) for k in read[0].along}
        return SteadyState(operating, numbers, along)

    def _read(self, operating: OperatingState, state: State) -> SteadyState:
        """Numbers and values of an equilibrium."""
        along = self._read_along(operating, state)
        numbers = {
            names.WIND_SPEED: operating.wind,
            names.ROTOR_SPEED: operating.rotor_speed / RPM,
            names.PITCH: operating.pitch / DEGREE,
            **self._read_rotor(operating, state),
            **self._read_tip(state),
            "tip_rotation_z_[deg]": float(along["rotation_z_[deg]"][-1]),
            **_name_loads("root", self._roots.at_rest(state).mean(axis=0)),
            **self._read_tower(operating, state),
        }
        return SteadyState(operating, numbers, along)

    def _read_tip(self, state: State) -> dict[str, float]:
        """Deflection of the tips, zero of rigid blades."""
        way = np.zeros(3) if self._tips is None else self._tips.find(state).mean(axis=0)
        return {f"tip_{name}": float(x) for name, x in zip(_DEFLECTIONS, way, strict=True)}

    def _read_rotor(self, operating: OperatingState, state: State) -> dict[str, float]:
        """Power, thrust and torque of the air, and their coefficients."""
        air, case = self._air.evaluate(state), self._turbine.case
        thrust, torque = float(air.force[0]), float(air.moment[0])
        V, R = operating.wind, self._radius
        force, power = 0.5 * case.wind.density * V**2 * np.pi * R**2, torque * operating.rotor_speed
        return {
            names.AERO_POWER: power,
            "electrical_power_[W]": self._efficiency * power,
            names.AERO_THRUST: thrust,
            names.AERO_TORQUE: torque,
            "power_coefficient_[-]": power / (force * V),
            "thrust_coefficient_[-]": thrust / force,
            "tip_speed_ratio_[-]": operating.rotor_speed * R / V,
        }

    def _read_tower(self, operating: OperatingState, state: State) -> dict[str, float]:
        """Loads on the yaw bearing and at the base, and the way of the top."""
        turbine, axes, point = self._turbine, TOWER_AXES, np.zeros(3)
        found = {}
        if self._base is not None:
            top = turbine.part(SUPPORT)
            first = turbine.system.first_coordinate[top]
            q = state.q[first : first + 12].reshape(4, 3)
            axes = TOWER_AXES @ np.asarray(top.directors) @ q[1:]
            point = q[0] + np.asarray(top.body_coordinates(np.zeros(3))) @ q[1:]
            way = TOWER_AXES @ (q[0] - np.asarray(top.position))
            found = {names.TOWER_TOP_DISPLACEMENT(axis=x): way[k] for k, x in enumerate("xyz")}
            foot = np.array([0.0, -turbine.case.tower.height, 0.0])
            changes = _find_changes(turbine, operating.rotor_speed, state, foot)
            base = self._base.at_rest(state)[0] + changes @ TOWER_AXES.T
            found |= _name_loads("tower_base", base)
        changes = _find_changes(turbine, operating.rotor_speed, state, point)
        bearing = self._interfaces.at_rest(state)[0] + changes @ axes.T
        return {**_name_loads("yaw_bearing", bearing), **found}

    def _read_along(self, operating: OperatingState, state: State) -> dict[str, Array]:
        """Flow, line loads, deflection and loads in sections at the stations."""
        turbine, blade = self._turbine, self._blade
        flow = NodeFlow(turbine).at(state)
        motion = find_loads(turbine.system, WIND, state).motion
        deflection, turns = _find_deflection(turbine, self._carriers, motion, state)

        def mean(values: Array) -> Array:
            found: Array = values.reshape(len(BLADES), -1).mean(axis=0)
            return found

        # sections are means over the skin around them, whose centres stand beside the stations
        layout = turbine.rotor.layout
        spans = np.repeat([layout.frame(k)[0] for k in (1, 2, 3)], len(blade.radius), axis=0)
        centres = mean(((motion.initial - np.asarray(layout.centre)) * spans).sum(axis=1))

        def at_stations(values: Array) -> Array:
            found: Array = interp1d(centres, mean(values), fill_value="extrapolate")(blade.radius)
            return found

        span = (blade.radius - blade.hub_radius) / (blade.tip_radius - blade.hub_radius)
        return {
            names.RADIUS: blade.radius,
            "span_[-]": span,
            "force_x_[N/m]": mean(flow.axial),
            "force_y_[N/m]": -mean(flow.driving),
            "force_normal_[N/m]": mean(flow.normal),
            "force_tangential_[N/m]": mean(flow.tangential),
            "angle_of_attack_[deg]": mean(flow.attack) / DEGREE,
            "flow_angle_[deg]": mean(flow.inflow) / DEGREE,
            "flow_speed_[m/s]": mean(flow.speed),
            "lift_coefficient_[-]": mean(flow.lift),
            "drag_coefficient_[-]": mean(flow.drag),
            "axial_induction_[-]": mean(flow.induction),
            "tangential_induction_[-]": mean(flow.swirl),
            **{n: at_stations(x) for n, x in zip(_DEFLECTIONS, deflection.T, strict=True)},
            **{n: at_stations(x) / DEGREE for n, x in zip(_ROTATIONS, turns.T, strict=True)},
            **self._read_sections(operating, state),
        }

    def _read_sections(self, operating: OperatingState, state: State) -> dict[str, Array]:
        """Forces and moments in the sections at the stations; none in rigid blades."""
        if self._sections is None:
            return {}
        frame = turning_frame(self._turbine.system, ROTOR, operating.rotor_speed, state)
        found = self._sections.at_rest(state, frame).reshape(len(BLADES), -1, 6).mean(axis=0)
        return dict(zip(COLUMNS, found.T, strict=True))


FINE = 1001
"""Points of the reference axis of a blade, between which places are linear."""

_DEFLECTIONS = tuple(f"deflection_{axis}_[m]" for axis in "xyz")
_ROTATIONS = tuple(f"rotation_{axis}_[deg]" for axis in "xyz")


def _find_sections(turbine: Turbine, radius: Array) -> SlenderLoads:
    """Loads in the sections of all blades at distances along the span."""
    fractions = np.linspace(0.0, 1.0, FINE)
    along = turbine.rotor.blades.axis_at(fractions)[:, 0]
    return find_blade_sections(turbine, np.interp(radius, along, fractions).tolist())


def _name_loads(place: str, loads: Array) -> dict[str, float]:
    """Force and moment by their names, for shape (2, 3)."""
    kinds = (("force", "N"), ("moment", "Nm"))
    return {
        f"{place}_{kind}_{axis}_[{unit}]": float(x)
        for (kind, unit), row in zip(kinds, loads, strict=True)
        for axis, x in zip("xyz", row, strict=True)
    }


def _find_changes(turbine: Turbine, speed: float, state: State, point: Array) -> Array:
    """dp/dt, and dL/dt about a point that does not move, of a turning equilibrium, (2, 3)."""
    frame = turning_frame(turbine.system, ROTOR, speed, state)
    balance = turbine.system.balance(state)
    force, moment = frame.momentum_rates(balance.linear, balance.angular)
    return np.array([force, moment - np.cross(point, force)])


def _find_deflection(
    turbine: Turbine, carriers: list[RigidBody], motion: SectionMotion, state: State
) -> tuple[Array, Array]:
    """How sections have moved and turned, seen from what carries the blades.

    Returns:
        Ways [m] and vectors of rotations [rad] in axes that pitch with the blade, shape (n, 3).
    """
    n = len(motion.position) // len(carriers)
    ways, turns = np.empty_like(motion.position), np.empty_like(motion.position)
    for k, body in enumerate(carriers):
        rows, first = slice(n * k, n * (k + 1)), turbine.system.first_coordinate[body]
        q = state.q[first : first + 12].reshape(4, 3)
        back = np.asarray(body.directors) @ q[1:]  # to the initial directions
        axes = blade_axes(turbine.rotor.layout, k + 1)
        before = motion.initial[rows] - np.asarray(body.position)
        ways[rows] = ((motion.position[rows] - q[0]) @ back.T - before) @ axes.T
        turns[rows] = Rotation.from_matrix(back @ motion.axes[rows]).as_rotvec() @ axes.T
    return ways, turns

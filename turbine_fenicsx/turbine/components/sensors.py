"""Sensors of a turbine for its controller: speeds, angles, and moments at the roots of blades."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.control.interface import Angles, Measurements
from turbine_fenicsx.control.loop import Actuators
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import E2, E3
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import BLADES, HUB, NACELLE, OPENFAST_SIGNS
from turbine_fenicsx.simulation.observers.step_rates import StepRates
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.blades.rotor_plan import AZIMUTHS
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.drivetrain import fast_shaft
from turbine_fenicsx.turbine.components.nacelle import ROTOR, SUPPORT, YAW
from turbine_fenicsx.turbine.components.pitch import BEARINGS
from turbine_fenicsx.turbine.components.root_channels import RootLoads, unpitch


class TopAcceleration:
    """Acceleration of the top of a flexible tower, as of `StepRates`."""

    def __init__(self, turbine: Turbine) -> None:
        support = turbine.find(SUPPORT)
        first = 0 if support is None else turbine.system.first_coordinate[support]
        self._is_there = support is not None
        self.rates = StepRates(lambda state: state.q[first : first + 3])

    def at(self, state: State, forward: Array) -> tuple[float, float]:
        """Acceleration downwind and to the left, as the nacelle looks [m/s^2].

        Args:
            forward: Direction of the shaft of the nacelle, downwind, shape (3,).
        """
        if not self._is_there:
            return 0.0, 0.0
        _, found = self.rates.follow(state)
        ahead = forward - (forward @ E2) * E2
        ahead /= np.linalg.norm(ahead)
        return float(found @ ahead), float(found @ np.cross(E2, ahead))


class Sensors:
    """Sensors of a turbine; speeds and the acceleration are means of the step that has ended."""

    def __init__(self, turbine: Turbine, actuators: Actuators) -> None:
        self._turbine, self._actuators, system = turbine, actuators, turbine.system
        names = system.joint_coordinate_names
        self._rotor, self._yaw = names.index(ROTOR), names.index(YAW)
        factors = fast_shaft(system, turbine.case.drivetrain.ratio)
        self._generator = [(names.index(name), factor) for name, factor in factors.items()]
        self._pitch = [(names.index(b), OPENFAST_SIGNS[b]) for b in BEARINGS if b in names]
        bodies = {body.name: first for body, first in system.first_coordinate.items()}
        self._nacelle, self._hub = bodies[NACELLE], bodies[HUB]
        # directors are principal axes, which need not be those of the turbine
        self._forward = np.asarray(turbine.part(NACELLE).directors).T @ E3
        # controllers of others may want what takes time to find
        wanted = turbine.case.control.kind not in ("none", "pi")
        self._roots = RootLoads(turbine) if wanted else None
        self._top = TopAcceleration(turbine) if wanted else None

    def resume(self, snapshot: Snapshot) -> None:
        """A run resumes from here."""
        if self._roots is not None:
            self._roots.mean_at(snapshot)
        if self._top is not None:
            self._top.rates.follow(snapshot.state)

    def save(self) -> RestartData:
        """State of the accelerometer and the gauges."""
        data = RestartData()
        if self._top is not None:
            data.add("top", self._top.rates.save())
        if self._roots is not None:
            data.add("roots", self._roots.loads.save())
        return data

    def restore(self, data: RestartData) -> None:
        """Restore the state of the sensors that saved this."""
        if self._top is not None:
            self._top.rates.restore(data.part("top"))
        if self._roots is not None:
            self._roots.loads.restore(data.part("roots"))

    def __call__(self, s: Snapshot, dt: float, first: bool) -> Measurements:
        """Measure."""
        state, d = s.state, self._turbine.case.drivetrain
        T, rates = state.joint_coordinates, state.joint_rates
        speed = sum(factor * float(rates[k]) for k, factor in self._generator)
        torque = -self._actuators.generator.torque
        angles = [sign * float(T[k]) for k, sign in self._pitch] or [0.0] * len(BLADES)
        pitch: Angles = (angles[0], angles[1], angles[2])
        forward = state.q[self._nacelle + 3 : self._nacelle + 12].reshape(3, 3).T @ self._forward
        wind, direction = self._see_wind(state.q, forward, state.time)
        none = (0.0, 0.0, 0.0)
        flap, edge = none, none
        if self._roots is not None:  # out of the plane of the rotor and in it
            edge, flap, _ = map(tuple, unpitch(self._roots.mean_at(s)[:, 1], pitch).T.tolist())
        top = (0.0, 0.0) if self._top is None else self._top.at(state, forward)
        return Measurements(
            time=state.time,
            dt=dt,
            first=first,
            generator_speed=speed,
            rotor_speed=float(rates[self._rotor]),
            azimuth=float((T[self._rotor] + AZIMUTHS[0]) % (2.0 * np.pi)),
            pitch=pitch,
            generator_torque=torque,
            electrical_power=d.efficiency * torque * speed,
            wind_speed=wind,
            yaw=OPENFAST_SIGNS[YAW] * float(T[self._yaw]),
            yaw_error=direction,
            flap_moments=flap,
            edge_moments=edge,
            top_acceleration=top,
        )

    def _see_wind(self, q: Array, forward: Array, time: float) -> tuple[float, float]:
        """Horizontal speed of the wind at the hub [m/s], and its angle with the nacelle [rad]."""
        inflow = self._turbine.inflow
        if inflow is None:
            return 0.0, 0.0
        wind = inflow.velocity(q[self._hub : self._hub + 3], time)
        wind, ahead = (x - (x @ E2) * E2 for x in (wind, forward))
        angle = np.arctan2(np.cross(ahead, wind) @ E2, ahead @ wind)
        return float(np.linalg.norm(wind)), float(angle)

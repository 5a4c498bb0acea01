"""The controller in the time loop: an observer that measures, asks it, and holds what it wants.

After each accepted step the controller sees the state; what it commands is held until the next
step is accepted. It does not see attempts at a step that are repeated with half of its length.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from turbine_fenicsx.control.command_check import check_commands
from turbine_fenicsx.control.drives import PitchDrive, YawDrive
from turbine_fenicsx.control.events import Event, Orders, supervise
from turbine_fenicsx.control.interface import Controller, Measurements
from turbine_fenicsx.control.step_torques import HeldBrake, HeldTorque
from turbine_fenicsx.foundation.errors import ForeignError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.simulation.snapshot import Snapshot

log = logging.getLogger(__name__)

Sensors = Callable[[Snapshot, float, bool], Measurements]
"""(state, time since the last call, whether this is the first) -> measurements."""


@runtime_checkable
class RestartableSensors(Protocol):
    """Sensors that need to know more than the present state."""

    def resume(self, snapshot: Snapshot) -> None:
        """A run resumes from here."""

    def save(self) -> RestartData:
        """State that later measurements depend on."""

    def restore(self, data: RestartData) -> None:
        """Restore the state of the sensors that saved this."""


@dataclass(frozen=True, eq=False)
class Actuators:
    """Actuators of a controller.

    Args:
        generator: Torque of the generator on the fast shaft, negative where it brakes.
        pitch: Drives of the blades; none if they are fixed.
        yaw: Drive of the nacelle; None if there is none.
        brake: Brake; None if there is none.
        brake_torque: Torque of the closed brake [N m].
    """

    generator: HeldTorque
    pitch: Sequence[PitchDrive] = ()
    yaw: YawDrive | None = None
    brake: HeldBrake | None = None
    brake_torque: float = 0.0

    def hold(self, orders: Orders, time: float) -> None:
        """Hold orders from a time on [s]."""
        self.generator.hold(-orders.generator_torque)
        for drive, target in zip(self.pitch, orders.pitch, strict=False):
            drive.hold(target, time)
        if self.yaw is not None:
            self.yaw.hold(orders.yaw_rate, time)
        if self.brake is not None:
            self.brake.strength = self.brake_torque * orders.brake

    @property
    def _drives(self) -> list[PitchDrive | YawDrive]:
        """All drives."""
        return [*self.pitch, *([self.yaw] if self.yaw else [])]

    def save(self) -> list[list[float]]:
        """Torques of the generator and states of the drives."""
        torques = [self.generator.last, self.generator.torque]
        return [torques, *(drive.save() for drive in self._drives)]

    def restore(self, states: Sequence[list[float]], orders: Orders) -> None:
        """Restore states and orders."""
        (self.generator.last, self.generator.torque), *others = states
        for drive, state in zip(self._drives, others, strict=True):
            drive.restore(state)
        if self.brake is not None:
            self.brake.strength = self.brake_torque * orders.brake


class ControlLoop:
    """Asks a controller after each step and holds its commands; see the head of this file.

    Args:
        controller: The controller.
        sensors: What it sees.
        actuators: What it acts on.
        events: What happens whatever it wants.
        dt: Time step of the run [s].

    Attributes:
        name: Under which checkpoints know it.
        orders: What the actuators hold.
    """

    name = "control"

    def __init__(
        self,
        controller: Controller,
        sensors: Sensors,
        actuators: Actuators,
        events: Sequence[Event] = (),
        dt: float = 0.01,
    ) -> None:
        self._controller, self._sensors, self._actuators = controller, sensors, actuators
        self._events, self._dt = tuple(events), dt
        pitch = [drive.angle for drive in actuators.pitch] or [0.0, 0.0, 0.0]
        a, b, c = pitch
        self.orders = Orders(0.0, (a, b, c))
        self._time = 0.0
        self._unanswered: Measurements | None = None
        self._speaks = False

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Ask for the first commands, unless a resumed run has them."""
        self._speaks = snapshot.stepper.system.comm.rank == 0
        if not resumed:
            self._ask(self._sensors(snapshot, self._dt, True))
            return
        if isinstance(self._sensors, RestartableSensors):
            self._sensors.resume(snapshot)
        if self._unanswered is not None:
            self._ask(self._unanswered)

    def observe(self, snapshot: Snapshot) -> None:
        """Ask for the next commands.

        Raises:
            ForeignError: if the controller fails; a run that resumes here calls it again.
        """
        self._ask(self._sensors(snapshot, snapshot.state.time - self._time, False))

    def finish(self) -> None:
        """Call the controller at the end of the run."""
        self._controller.finish()

    def _ask(self, measured: Measurements) -> None:
        """Ask for commands and hold them."""
        time = measured.time
        try:
            commands = check_commands(self._controller.command(measured), "the controller", time)
        except ForeignError:
            self._unanswered = measured
            self._actuators.generator.hold(self._actuators.generator.torque)
            raise
        self._unanswered = None
        if commands.brake and self._actuators.brake is None and self._speaks:
            self._speaks = False
            log.warning(
                "the controller closes the shaft brake at t = %g s, but there is none: "
                "drivetrain.brake_torque is 0",
                time,
            )
        self.orders = supervise(self._events, measured, commands, self.orders)
        self._actuators.hold(self.orders, time)
        self._time = time

    def save(self) -> RestartData:
        """Orders, states of the drives and of the controller."""
        data = RestartData({"time": self._time, "orders": list(self.orders)})
        data.numbers["actuators"] = self._actuators.save()
        if self._unanswered is not None:
            data.numbers["unanswered"] = self._unanswered.to_row()
        data.add("controller", self._controller.save())
        if isinstance(self._sensors, RestartableSensors):
            data.add("sensors", self._sensors.save())
        return data

    def restore(self, data: RestartData) -> None:
        """Restore what was held."""
        self._time = data.numbers["time"]
        torque, pitch, *others = data.numbers["orders"]
        self.orders = Orders(torque, tuple(pitch), *others)
        self._actuators.restore(data.numbers["actuators"], self.orders)
        if row := data.numbers.get("unanswered"):
            self._unanswered = Measurements.from_row(row)
        self._controller.restore(data.part("controller"))
        if isinstance(self._sensors, RestartableSensors):
            self._sensors.restore(data.part("sensors"))

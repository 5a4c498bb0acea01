"""The controller of a case: what it measures on the turbine, and what it acts on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from turbine_fenicsx.control.discon import Discon
from turbine_fenicsx.control.drives import PitchDrive, YawDrive
from turbine_fenicsx.control.fixed import FixedCommands
from turbine_fenicsx.control.foreign import ForeignController
from turbine_fenicsx.control.interface import Controller
from turbine_fenicsx.control.loop import Actuators, ControlLoop
from turbine_fenicsx.control.pi import PIController
from turbine_fenicsx.control.python_class import PythonClass
from turbine_fenicsx.control.step_torques import HeldBrake, HeldTorque
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.turbine.components.component import Assembly, Channels, Component, Turbine
from turbine_fenicsx.turbine.components.drivetrain import SHAFT, fast_shaft
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.openfast_channel import in_openfast
from turbine_fenicsx.turbine.components.sensors import Sensors
from turbine_fenicsx.turbine.tables.control import ControlCase
from turbine_fenicsx.turbine.tables.event import list_events

FOLDER = "controller"
"""Folder for the files of a library, in the output folder."""

_Held = TypeVar("_Held")


@dataclass(frozen=True)
class Control(Component):
    """Generator torque and brake, and the controller that sets them and the drives.

    The torque acts between generator and nacelle.
    """

    def parts(self, assembly: Assembly) -> list[Any]:
        """The torque ``generator`` and, where it has a torque, the friction ``brake``."""
        case = assembly.case
        names = [ROTOR, *((SHAFT,) if case.drivetrain.model == "two_mass" else ())]
        factors = dict.fromkeys(names, case.drivetrain.ratio)
        found: list[Any] = [HeldTorque("generator", factors)]
        if case.may_brake:
            found.append(HeldBrake("brake", names))
        return found

    def channels(self, turbine: Turbine) -> Channels:
        """Torque and power of the generator in the step, and the commands held from now."""
        actuators, d = list_actuators(turbine), turbine.case.drivetrain
        places = turbine.system.joint_coordinate_names
        factors = fast_shaft(turbine.system, d.ratio)
        terms = [(places.index(name), factor) for name, factor in factors.items()]

        def values(s: Snapshot) -> list[float]:
            speed = sum(factor * float(s.state.joint_rates[k]) for k, factor in terms)
            torque = -actuators.generator.last
            pitch = [drive.target or 0.0 for drive in actuators.pitch]
            return [torque, d.efficiency * torque * speed, *pitch]

        commands = [f"BlPitchC{k + 1}" for k in range(len(actuators.pitch))]
        return Channels(openfast=[in_openfast(("GenTq", "GenPwr", *commands), values)])

    def observers(self, turbine: Turbine, folder: Path) -> list[ControlLoop]:
        """The loop that asks the controller after each step. Collective."""
        case, actuators = turbine.case, list_actuators(turbine)
        controller = _make_controller(turbine, folder, actuators)
        sensors = Sensors(turbine, actuators)
        return [
            ControlLoop(controller, sensors, actuators, list_events(case.event), case.time.step)
        ]


def _make_controller(turbine: Turbine, folder: Path, actuators: Actuators) -> Controller:
    """The controller that a case names. Collective."""
    case, comm = turbine.case, turbine.comm
    c = case.control
    if c.kind == "none":
        return FixedCommands(0.0, case.pitch.initial)
    if c.kind == "pi":
        return make_pi(c)
    if c.python_class:
        path, name = c.python_class
        who = f"the controller {name!r} of '{path}'"
        return ForeignController(comm, lambda: PythonClass(path, name), who)
    assert c.library and c.input
    library, infile = Path(c.library), Path(c.input)
    limits = (c.pitch.fine, c.pitch.largest)
    return ForeignController(
        comm,
        lambda: Discon(library, infile, folder / FOLDER, limits),
        f"the controller '{library}'",
    )


def make_pi(control: ControlCase) -> PIController:
    """The built-in controller of a case."""
    torque, pitch = control.torque.make(), control.pitch.make()
    return PIController(torque, pitch, control.filter_frequency, control.torque.rate)


def list_actuators(turbine: Turbine) -> Actuators:
    """Actuators among the parts of a turbine."""
    motions = [part.motion for part in turbine.parts if isinstance(part, PrescribedMotion)]
    return Actuators(
        next(_pick(turbine.parts, HeldTorque)),
        tuple(_pick(motions, PitchDrive)),
        next(_pick(motions, YawDrive), None),
        next(_pick(turbine.parts, HeldBrake), None),
        turbine.case.drivetrain.brake_torque,
    )


def _pick(things: list[Any], kind: type[_Held]) -> Iterator[_Held]:
    """Those of a kind."""
    return (thing for thing in things if isinstance(thing, kind))

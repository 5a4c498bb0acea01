"""The controller in the time loop: when it is asked, what is held, restarts bit for bit."""

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx import (
    Checkpoints,
    MultibodySystem,
    PrescribedMotion,
    Revolute,
    RigidBody,
    Simulation,
)
from turbine_fenicsx.control.drives import PitchDrive
from turbine_fenicsx.control.events import Event
from turbine_fenicsx.control.foreign import ForeignController
from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.control.loop import Actuators, ControlLoop
from turbine_fenicsx.control.pi import PIController, PitchLaw
from turbine_fenicsx.control.step_torques import HeldTorque
from turbine_fenicsx.foundation.errors import ForeignError, InputError, StepFailure
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

pytestmark = pytest.mark.parallel

DT, RATIO = 0.05, 97.0


class Machine:
    """A rotor with a pitch bearing and a generator, without air."""

    def __init__(self, comm):
        rotor = RigidBody("rotor", 1e4, (2e7, 2e7, 1e6))
        blade = RigidBody("blade", 1e3, (1e4, 10.0, 1e4), position=(0.0, 10.0, 0.0))
        self.generator = HeldTorque("generator", {"main": RATIO})
        self.drives = [PitchDrive(s, 6.0, 0.8) for s in (1.0, -1.0, 1.0)]
        main = Revolute("main", None, rotor, point=(0, 0, 0), axis=(0, 0, 1))
        pitch = Revolute("pitch", rotor, blade, point=(0, 0, 0), axis=(0, 1, 0))
        motion = PrescribedMotion("pitch", self.drives[0])
        self.system = MultibodySystem(comm, [rotor, blade, main, pitch, motion, self.generator])
        self.start = initial_motion(self.system, {"main": 1.25, "pitch": 0.0})

    def measure(self, s, dt, first):
        speed = float(s.state.joint_rates[0])
        angle = float(s.state.joint_coordinates[1])
        torque = -self.generator.torque
        return Measurements(
            s.state.time, dt, first, RATIO * speed, speed, 0.0, (angle,) * 3, torque, 0.0
        )

    def loop(self, controller, events=()):
        return ControlLoop(
            controller, self.measure, Actuators(self.generator, self.drives), events, DT
        )


class Steps:
    """A controller whose torque counts its calls."""

    def __init__(self):
        self.calls = []

    def respond(self, measured):
        self.calls.append((measured.time, measured.dt, measured.first))
        return Commands(1e3 * len(self.calls), (0.01 * len(self.calls),) * 3)

    def finish(self):
        pass


def everything(snapshot):
    s = snapshot.state
    return [s.time, *s.q, *s.q_dot, *snapshot.works, snapshot.energy_error]


def run(machine, loop, end, folder=None, stepper=None, resume=False, every=0.5):
    recorder = Seen(everything)
    checkpoints = Checkpoints(machine.system, folder, every=every) if folder else None
    simulation = Simulation(
        machine.system,
        DT,
        end,
        [loop, recorder],
        stepper,
        checkpoints=checkpoints,
        start=None if resume else machine.start,
    )
    last = simulation.resume() if resume else simulation.run()
    return last, np.array(recorder.values)


def test_torque_and_pitch_are_held_over_each_step_and_works_are_exact(comm):
    machine = Machine(comm)
    calls = Steps()
    loop = machine.loop(ForeignController(comm, lambda: calls, "steps"))
    last, rows = run(machine, loop, 0.5)
    if comm.rank == 0:
        assert [c[2] for c in calls.calls] == [True] + 10 * [False]
        assert np.allclose([c[0] for c in calls.calls], DT * np.arange(11))
        assert np.allclose([c[1] for c in calls.calls], DT)
    angle = [0.0]  # of the rotor, from its speed in each step
    generator = rows[:, -3]
    assert np.all(np.diff(generator) < 0.0)
    share = np.diff(generator) / (-1e3 * RATIO * np.arange(1, 11))  # increments of the angle
    angle = np.cumsum(share)
    assert np.isclose(angle[-1], last.state.joint_coordinates[0], rtol=1e-12)
    assert abs(last.energy_error) < 1e-11 * last.balance.kinetic
    drive = PitchDrive(1.0, 6.0, 0.8)
    for k in range(10):
        drive.hold(0.01 * (k + 1), DT * k)
    assert np.isclose(last.state.joint_coordinates[1], drive(0.5), rtol=0.0, atol=1e-13)


def test_a_step_that_is_halved_leaves_no_trace(comm):
    """The controller sees accepted steps alone, and both halves see what was held for the whole."""

    class Failing(EnergyMomentum):
        attempts = 0

        def advance(self, state, dt, out):
            if dt > 0.6 * DT and state.time < 0.1:
                type(self).attempts += 1
                EnergyMomentum.advance(self, state, dt, out)
                raise StepFailure("no")
            return EnergyMomentum.advance(self, state, dt, out)

    class Small(EnergyMomentum):
        def advance(self, state, dt, out):
            if dt > 0.6 * DT and state.time < 0.1:
                raise StepFailure("no")
            return EnergyMomentum.advance(self, state, dt, out)

    found = []
    for kind in (Failing, Small):
        machine = Machine(comm)
        loop = machine.loop(PIController())
        found.append(run(machine, loop, 0.5, stepper=kind(machine.system))[1])
    assert Failing.attempts > 0
    assert np.array_equal(*found)
    assert np.isclose(found[0][1, 0], 0.5 * DT)


def make_controller(kind, comm):
    if kind == "pi":
        return PIController(pitch_law=PitchLaw(speed=118.0))
    return ForeignController(comm, Steps, "steps")


@pytest.mark.parametrize("kind", ["pi", "foreign"])
def test_a_restart_goes_on_bit_for_bit(comm, shared_tmp_path, kind):
    events = [Event(0.4, "pitch_fault", blade=1), Event(0.6, "grid_loss")]
    whole = Machine(comm)
    _, rows = run(whole, whole.loop(make_controller(kind, comm), events), 1.0)
    first = Machine(comm)
    loop = first.loop(make_controller(kind, comm), events)
    run(first, loop, 0.5, shared_tmp_path)
    second = Machine(comm)
    loop = second.loop(make_controller(kind, comm), events)
    _, again = run(second, loop, 1.0, shared_tmp_path, resume=True)
    assert np.array_equal(again, rows[10:])
    assert np.ptp(rows[:, -3]) > 0.0


def test_commands_that_are_no_numbers_end_the_run_with_a_sentence(comm):
    class Wild(PIController):
        def command(self, measured):
            return Commands(np.nan if measured.time > 0.1 else 0.0, (0.0, 0.0, 0.0))

    machine = Machine(comm)
    with pytest.raises(InputError, match=r"no number as generator torque at t = 0.15 s"):
        run(machine, machine.loop(Wild()), 0.5)


class Failing(Steps):
    """It fails at a time, once."""

    at = 0.5

    def respond(self, measured):
        if np.isclose(measured.time, self.at):
            raise ForeignError("the controller 'Failing' fails")
        return super().respond(measured)


def test_a_controller_that_fails_leaves_a_checkpoint_and_all_rows(comm, shared_tmp_path):
    """The run goes on from the step that it was asked about, with nothing lost."""
    whole = Machine(comm)
    _, rows = run(whole, whole.loop(ForeignController(comm, Steps, "steps")), 1.0)
    first = Machine(comm)
    recorder = Seen(everything)
    checkpoints = Checkpoints(first.system, shared_tmp_path)
    loop = first.loop(ForeignController(comm, Failing, "steps"))
    observers = [loop, recorder]
    simulation = Simulation(
        first.system, DT, 1.0, observers, checkpoints=checkpoints, start=first.start
    )
    with pytest.raises(ForeignError, match="'Failing' fails"):
        simulation.run()
    assert np.array_equal(recorder.values, rows[:11])
    second = Machine(comm)
    loop = second.loop(ForeignController(comm, Steps, "steps"))
    _, again = run(second, loop, 1.0, shared_tmp_path, resume=True)
    assert np.array_equal(again, rows[10:])

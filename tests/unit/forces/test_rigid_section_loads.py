"""Claims about loads on sections of rigid bodies: kinematics, power, balance, restarts."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from turbine_fenicsx import (
    LineLoad,
    ModelError,
    MultibodySystem,
    Revolute,
    RigidBody,
    RigidSectionLoads,
    RigidStations,
    Simulation,
    StepTimes,
)
from turbine_fenicsx.forces.force import Layout
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.generalised_alpha import GeneralisedAlpha

pytestmark = pytest.mark.parallel

TURN = rotation_about((0.3, -0.5, 0.8), 0.4)


@dataclass
class Drag:
    """A load of a wind on each of five sections, with a wake that follows slowly."""

    wake: np.ndarray = field(default_factory=lambda: np.zeros((5, 3)))
    calls: list = field(default_factory=list)

    def start_step(self, times):
        self.calls.append(("start_step", times.end))

    def loads(self, motion, time):
        relative = np.array([0.0, 3.0, 9.0]) + np.sin(time) - motion.velocity - self.wake
        force = 4.0 * np.linalg.norm(relative, axis=1)[:, None] * relative
        return force, np.cross(motion.axes[:, :, 0], force) - 0.2 * motion.angular_velocity

    def accept(self, motion, times):
        self.calls.append(("accept", times.end))
        self.wake = self.wake + times.dt * (0.02 * self.loads(motion, 0.0)[0] - self.wake)

    def save(self):
        return RestartData(arrays={"wake": self.wake.copy()})

    def restore(self, data):
        self.wake = data.arrays["wake"].copy() if data else np.zeros((5, 3))


def bodies():
    shape = {"euler": (0.2, 3.0, 4.0), "directors": TURN}
    return [RigidBody(name, 20.0, position=(x, 0.2, 0.1), **shape) for name, x in NAMES]


NAMES = (("left", -2.0), ("right", 2.0))
POINTS = [np.linspace(a, b, n)[:, None] * [1.0, 0.05, 0.0] for a, b, n in ((-1, -4, 2), (1, 4, 3))]


def loads(two, source, points=POINTS):
    return RigidSectionLoads("wind", [*map(RigidStations, two, points)], source)


def turning(comm, source):
    """Two rigid arms on a shaft, in a wind."""
    two = bodies()
    shafts = [Revolute(b.name + " shaft", None, b, point=(0, 0, 0), axis=(0, 0, 1)) for b in two]
    return MultibodySystem(comm, [*two, *shafts, loads(two, source)])


def bound(source):
    two = bodies()
    start = np.concatenate([b.coordinates for b in two])
    return loads(two, source).bind(Layout({b: 12 * k for k, b in enumerate(two)}, {})), start


class Seen(Drag):
    """Known loads; keeps the motion that it is asked for."""

    def loads(self, motion, time):
        self.motion, self.time = motion, time
        return F, M


F, M = np.random.default_rng(4).standard_normal((2, 5, 3))


def test_sections_move_with_their_bodies():
    source = Seen()
    force, y = bound(source)
    Q, shift = rotation_about((0.3, -0.5, 0.8), 2.6), np.array([30.0, -4.0, 7.0])
    # of a body that turns with omega from a configuration, the mean one of the step
    v, omega, dt = np.array([1.0, 2.0, -3.0]), np.array([0.5, -1.0, 2.0]), 0.01
    x = y.reshape(-1, 4, 3) @ Q.T
    x[:, 0] += shift
    rate = np.cross(omega, x)
    rate[:, 0] += v
    ends = [(x + s * 0.5 * dt * rate).ravel() for s in (-1.0, 1.0)]
    force.force(*ends, StepTimes.from_start(3.0, dt))
    found, initial = source.motion, np.concatenate(POINTS)
    assert source.time == 3.005
    assert found.initial == pytest.approx(initial)
    assert found.position == pytest.approx(initial @ Q.T + shift, abs=1e-12)
    assert found.axes == pytest.approx(np.broadcast_to(Q, (5, 3, 3)), abs=1e-13)
    assert found.velocity == pytest.approx(v + np.cross(omega, found.position), abs=1e-11)
    assert found.angular_velocity == pytest.approx(np.broadcast_to(omega, (5, 3)), abs=1e-11)


def test_resultant_moment_and_work_are_those_of_the_loads():
    source = Seen()
    force, y = bound(source)
    y0, y1 = y + 0.1 * np.sin(np.arange(24.0)), y + 0.1 * np.cos(3.0 * np.arange(24.0))
    f, _ = force.force(y0, y1, StepTimes.from_start(0.0, 0.02))
    parts, mean = f.reshape(2, 4, 3), (0.5 * (y0 + y1)).reshape(2, 4, 3)
    assert parts[:, 0].sum(axis=0) == pytest.approx(F.sum(axis=0), abs=1e-13)
    moment = M.sum(axis=0) + np.cross(source.motion.position, F).sum(axis=0)
    assert np.cross(mean, parts).sum(axis=(0, 1)) == pytest.approx(moment, abs=1e-12)
    power = np.sum(F * source.motion.velocity) + np.sum(M * source.motion.angular_velocity)
    assert f @ (y1 - y0) == pytest.approx(0.02 * power, abs=1e-13)


def test_wind_work_is_all_that_changes_the_energy(comm):
    snapshot = Simulation(turning(comm, Drag()), 0.02, 1.0).run()
    (work,) = snapshot.works
    assert abs(work) > 10.0
    assert abs(snapshot.energy_error) <= 5e-11 * snapshot.balance.kinetic


def test_the_loads_of_the_last_step_are_known(comm):
    system = turning(comm, Drag())
    snapshot = Simulation(system, 0.02, 0.1).run()
    last = system.section_loads["wind"].last
    assert last.times.end == pytest.approx(0.1)
    assert last.times.dt == pytest.approx(0.02)
    power = np.sum(last.force * last.motion.velocity)
    power += np.sum(last.moment * last.motion.angular_velocity)
    assert 0.02 * power == pytest.approx(snapshot.report.works[0], rel=1e-12)


def test_each_accepted_step_moves_the_wake_on_once(comm):
    source = Drag()
    run = Simulation(turning(comm, source), 0.02, 0.1)
    run.run()
    run.stepper.save()  # the last step
    accepted = [round(t, 9) for kind, t in source.calls if kind == "accept"]
    assert accepted == [0.02, 0.04, 0.06, 0.08, 0.1]


def test_a_step_that_is_repeated_leaves_no_trace(comm):
    ends, wakes = [], []
    for lengths in ([0.02], [0.08, 0.04, 0.02]):
        source = Drag()
        stepper = EnergyMomentum(turning(comm, source))
        state, out = stepper.system.initial_state(), stepper.system.initial_state()
        stepper.advance(state, 0.02, out)
        for dt in lengths:
            end = stepper.system.initial_state()
            stepper.advance(out, dt, end)
        stepper.save()
        ends.append(end.q_dot)
        wakes.append(source.wake)
    assert ends[1] == pytest.approx(ends[0], abs=1e-11)
    assert np.any(wakes[0]) and wakes[1] == pytest.approx(wakes[0], rel=1e-10)


@pytest.mark.parametrize("scheme", [EnergyMomentum, GeneralisedAlpha])
def test_a_run_goes_on_bit_for_bit(comm, scheme):
    def end(parts):
        state, data = None, None
        for steps in parts:
            system = turning(comm, Drag())
            stepper = scheme(system)
            stepper.restore(data or RestartData())
            state = state or system.initial_state()
            for _ in range(steps):
                out = system.initial_state()
                stepper.advance(state, 0.02, out)
                state = out
            data = stepper.save()
        return state.q

    whole, halves = end([6]), end([3, 3])
    assert not np.array_equal(whole, end([5]))
    assert np.array_equal(whole, halves)


def test_schemes_agree_in_the_limit(comm):
    ends = []
    for scheme in (EnergyMomentum, GeneralisedAlpha):
        system = turning(comm, Drag())
        snapshot = Simulation(system, 0.005, 0.3, stepper=scheme(system)).run()
        ends.append(snapshot.state.joint_coordinates)
    assert ends[1] == pytest.approx(ends[0], rel=2e-3)


def test_wrong_stations_sources_and_loads_are_refused(comm):
    assert isinstance(Drag(), LineLoad)
    two = bodies()
    with pytest.raises(ModelError, match="stations of 'wind' must be positions"):
        loads(two, Drag(), [POINTS[0], [[1.0, np.nan, 0.0]]])
    with pytest.raises(ModelError, match="'wind' has a body twice"):
        loads([two[0], two[0]], Drag())
    with pytest.raises(TypeError, match=r"source of 'wind' needs the methods start_step\(\)"):
        loads(two, "wind")
    with pytest.raises(TypeError, match="'wind' needs a rigid body, got str 'hub'"):
        loads(["hub", two[0]], Drag())

    class Wrong(Drag):
        def loads(self, motion, time):
            return np.zeros((4, 3)), np.zeros((5, 3))

    system = turning(comm, Wrong())
    with pytest.raises(ModelError, match=r"forces of 'wind' must have the shape \(5, 3\)"):
        EnergyMomentum(system).advance(system.initial_state(), 0.01, system.initial_state())

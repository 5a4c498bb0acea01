"""Claims about the time loop: which times it meets, what observers see, and how it halves steps."""

from dataclasses import replace

import numpy as np
import pytest

from turbine_fenicsx import Gravity, Hat, JointTorque
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions
from turbine_fenicsx.turbine.run.summary import Statistics

pytestmark = pytest.mark.parallel


class Recorder:
    """An observer that writes down what it sees, and may raise."""

    def __init__(self, fail_at=None):
        self.seen, self.finished, self.fail_at = [], 0, fail_at

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, snapshot):
        assert self.finished == 0
        s = snapshot
        self.seen.append((s.index, s.state.time, s.balance.total, s.report, s.state.q.copy()))
        if s.index == self.fail_at:
            raise RuntimeError("disk full")

    def finish(self):
        self.finished += 1

    @property
    def times(self):
        return [time for _, time, *_ in self.seen]


class Fussy:
    """A step solver that fails where ``fails(time, dt)`` says so, else the real one."""

    def __init__(self, solver, fails):
        self.solver, self.fails, self.tried = solver, fails, []

    def __getattr__(self, name):
        return getattr(self.solver, name)

    def advance(self, state, dt, out):
        self.tried.append((state.time, dt))
        if self.fails(state.time, dt):
            raise StepFailure(f"no solution from t = {state.time}")
        return self.solver.advance(state, dt, out)


@pytest.fixture
def rotor(comm, machine):
    """The rigid part of the machine, for speed."""
    m = machine(spin=3.0)
    loads = [
        Gravity(),
        JointTorque("torque on rotor", "rotor", 1.0, Hat(5.0)),
        JointTorque("torque on yaw", "yaw", 1.0, Hat(1.0)),
    ]
    return MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, *loads])


def simulate(system, step, end, fails=None, fail_at=None, **options):
    """Run, and return the last snapshot, the recorder, and the simulation."""
    recorder = Recorder(fail_at)
    simulation = Simulation(system, step, end, [recorder], **options)
    if fails is not None:
        simulation.stepper = Fussy(simulation.stepper, fails)
    return simulation.run(), recorder, simulation


@pytest.mark.parametrize(("step", "end"), [(0.02, 0.2), (0.1, 0.3), (0.07, 0.7), (1 / 30, 0.1)])
def test_steps_are_equal_where_they_fit(rotor, step, end):
    _, recorder, _ = simulate(rotor, step, end)
    n = round(end / step)
    assert len(recorder.times) == n + 1
    assert recorder.times == [k * step for k in range(n)] + [recorder.times[-1]]  # no drift
    assert recorder.times[-1] == pytest.approx(end, rel=1e-12)


@pytest.mark.parametrize("end", [0.05, 0.0401, 0.0799])
def test_the_last_step_is_shortened_to_meet_the_end(rotor, end):
    _, recorder, _ = simulate(rotor, 0.02, end)
    n = int(end / 0.02)
    assert recorder.times == [k * 0.02 for k in range(n + 1)] + [end]


def test_an_end_before_the_first_step_is_met_in_one_short_step(rotor):
    last, recorder, _ = simulate(rotor, 0.02, 0.001)
    assert recorder.times == [0.0, 0.001]
    assert last.state.joint_coordinates[1] == pytest.approx(
        2 * np.arctan(3.0 * 0.001 / 2), rel=1e-4
    )


def test_an_end_at_zero_shows_the_initial_state_only(rotor):
    last, recorder, _ = simulate(rotor, 0.02, 0.0)
    assert recorder.times == [0.0]
    assert (last.index, last.external_work, last.energy_error, last.report) == (0, 0.0, 0.0, None)
    assert recorder.finished == 1


def test_observers_see_each_accepted_step_once_and_in_order(rotor):
    recorders = [Recorder(), Recorder()]
    last = Simulation(rotor, 0.02, 0.1, recorders).run()
    for recorder in recorders:
        assert [index for index, *_ in recorder.seen] == list(range(6))
        assert recorder.seen[0][3] is None
        assert all(report.newton_iterations > 0 for *_, report, _ in recorder.seen[1:])
        assert recorder.finished == 1
    assert np.array_equal(last.state.q, recorders[0].seen[-1][4])


def test_snapshots_balance_energy_against_the_work_since_the_start(machine):
    m = machine(spin=3.0)
    system = m.system(Gravity(), JointTorque("torque on rotor", "rotor", 1.0, Hat(5.0)))
    last, recorder, _ = simulate(system, 0.02, 0.1)
    assert last.external_work > 1e-4
    change = last.balance.total - recorder.seen[0][2]
    assert last.energy_error == pytest.approx(change - last.external_work, abs=1e-14)
    assert abs(last.energy_error) <= 1e-10  # five steps with energies of order ten
    assert last.constraint_error <= 1e-12
    assert last.wall_time > 0.0


def test_snapshots_are_equal_on_all_ranks(comm, machine):
    last, _, _ = simulate(machine(spin=3.0).system(Gravity()), 0.02, 0.06)
    b = last.balance
    numbers = [b.kinetic, b.strain, b.potential, *b.linear, *b.angular]
    numbers += [last.external_work, last.energy_error, last.constraint_error]
    numbers += [last.index, last.report.newton_iterations, last.report.residual, *last.state.q]
    assert comm.allgather(numbers) == [numbers] * comm.size


def test_a_second_run_starts_again(rotor):
    simulation = Simulation(rotor, 0.02, 0.06)
    first, again = simulation.run(), simulation.run()
    assert first.index == again.index == 3
    assert np.array_equal(first.state.q, again.state.q)


def test_a_failed_step_is_halved_until_it_succeeds(rotor):
    """Only steps of a quarter of dt work between t = 0.02 and 0.04."""
    last, recorder, simulation = simulate(
        rotor, 0.02, 0.06, fails=lambda t, dt: 0.02 <= t < 0.0399 and dt > 0.0051
    )
    # half steps are tried again wherever they fit the grid, full ones from 0.06 on
    expected = [0.0, 0.02, 0.025, 0.03, 0.035, 0.04, 0.05, 0.06]
    assert recorder.times == pytest.approx(expected, rel=1e-14)
    assert recorder.times[5] == 0.04 and recorder.times[7] == 0.06  # exactly: the grid is met again
    assert [index for index, *_ in recorder.seen] == list(range(8))
    assert simulation.halvings == 3  # 0.02 at 0.02; 0.01 at 0.02; 0.01 at 0.03
    assert last.index == 7 and recorder.finished == 1


def test_energy_balances_over_halved_steps_too(rotor):
    last, _, _ = simulate(rotor, 0.02, 0.2, fails=lambda t, dt: 0.05 < t < 0.15 and dt > 0.006)
    assert last.external_work > 1e-3
    assert abs(last.energy_error) <= 1e-11


def test_the_shortened_last_step_may_be_halved(rotor):
    _, recorder, _ = simulate(rotor, 0.02, 0.03, fails=lambda t, dt: t > 0.01 and dt > 0.006)
    assert recorder.times == pytest.approx([0.0, 0.02, 0.025, 0.03], rel=1e-14)
    assert recorder.times[-1] == 0.03


def test_a_step_that_cannot_be_halved_any_further_ends_the_run_in_words(rotor):
    recorder = Recorder()
    simulation = Simulation(rotor, 0.02, 0.2, [recorder], smallest_step=0.25)
    simulation.stepper = fussy = Fussy(simulation.stepper, lambda t, dt: t > 0.03)
    message = (
        r"no solution from t = 0.04.*\. Steps are not halved below 0.005 s: try a smaller time.step"
    )
    with pytest.raises(StepFailure, match=message):
        simulation.run()
    assert recorder.times == [0.0, 0.02, 0.04]  # all earlier steps were seen
    assert recorder.finished == 1
    sizes = [dt for t, dt in fussy.tried if t > 0.03]
    assert sizes == pytest.approx([0.02, 0.01, 0.005], rel=1e-12)


def test_a_real_failure_ends_the_run_too(rotor):
    options = SolverOptions(linear_solver="lu", max_iterations=1)
    stepper = EnergyMomentum(rotor, options=options)
    with pytest.raises(
        StepFailure,
        match=r"still too large after .* iteration.*not halved below .*: try a smaller time.step",
    ):
        Simulation(rotor, 0.02, 0.06, stepper=stepper, smallest_step=0.5).run()


def test_observers_are_finished_when_one_of_them_fails(rotor):
    recorders = [Recorder(), Recorder(fail_at=2)]
    with pytest.raises(RuntimeError, match="disk full"):
        Simulation(rotor, 0.02, 0.1, recorders).run()
    assert [r.finished for r in recorders] == [1, 1]
    assert recorders[0].times == [0.0, 0.02, 0.04]


@pytest.mark.parametrize("step", [0.0, -0.02, float("nan")])
def test_the_step_must_be_positive(rotor, step):
    with pytest.raises(ValueError, match=rf"^dt must be (positive|a number), got {step}$"):
        Simulation(rotor, step, 1.0)


@pytest.mark.parametrize("end", [-1e-9, -12.0, float("nan")])
def test_the_end_must_not_be_negative(rotor, end):
    with pytest.raises(ValueError, match=rf"^end must (not be negative|be a number), got {end}$"):
        Simulation(rotor, 0.02, end)


@pytest.mark.parametrize(("step", "end"), [(np.inf, 1.0), (0.02, np.inf)])
def test_times_must_be_finite(rotor, step, end):
    """Not refused, an infinite step ends the run at t = 0, an infinite end in an OverflowError."""
    with pytest.raises(ValueError, match=r"^(dt|end) must"):
        Simulation(rotor, step, end)


def test_statistics_keep_the_worst_of_all_steps_not_the_last(rotor):
    """Of three snapshots the one in the middle has the largest errors and energies."""
    last, *_ = simulate(rotor, 0.02, 0.02)
    statistics = Statistics()
    for factor in (1.0, 3.0, 2.0):
        statistics.observe(
            replace(
                last,
                energy_error=-1e-6 * factor,
                constraint_error=1e-9 * factor,
                balance=replace(last.balance, kinetic=100.0 * factor),
            )
        )
    assert statistics.worst_energy_error == pytest.approx(3e-6, rel=1e-12)
    assert statistics.worst_constraint == pytest.approx(3e-9, rel=1e-12)
    assert statistics.largest_energy == 300.0  # the potential counts from t = 0
    assert statistics.steps == 3

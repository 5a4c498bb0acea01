"""The estimated error of a step is the true one, and steps that follow it are as good as asked."""

from itertools import pairwise

import numpy as np
import pytest

from turbine_fenicsx import Gravity, JointTorque, Revolute
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.simulation.step_error import StepError
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

END = 1.2
TOLERANCES = (4e-4, 5e-5, 6.25e-6)


def spinning(comm, speed=2.0):
    """A free body that turns about its first axis and flies along e2."""
    body = RigidBody(
        "body", 3.0, (0.3, 0.4, 0.5), velocity=(0.0, 1.0, 0.0), angular_velocity=(speed, 0.0, 0.0)
    )
    return MultibodySystem(comm, [body])


def tumbling(comm):
    """A free body that turns about its middle axis, nearly: it tumbles."""
    return MultibodySystem(
        comm, [RigidBody("body", 3.0, (0.1, 0.5, 1.0), angular_velocity=(0.1, 3.0, 0.1))]
    )


def pendulum(comm):
    """A compound pendulum of length 1 m that is let go with the arm horizontal."""
    bob = RigidBody("bob", 2.0, (0.02, 0.03, 0.04), position=(1.0, 0.0, 0.0))
    pin = Revolute("pin", None, bob, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    return MultibodySystem(comm, [bob, pin, Gravity()])


class Recorder:
    """Writes down times, coordinates and energy errors."""

    def __init__(self):
        self.times, self.q, self.energy_errors = [], [], []

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, snapshot):
        self.times.append(snapshot.state.time)
        self.q.append(snapshot.state.q.copy())
        self.energy_errors.append(snapshot.energy_error)

    def finish(self):
        pass


def run(system, step, end, error=None, **options):
    """Run, and return what was seen, and the simulation."""
    seen = Recorder()
    simulation = Simulation(system, step, end, [seen], step_error=error, **options)
    simulation.run()
    return seen, simulation


def history(system, dt, n=4):
    """States of some equal steps, the first one included, and the solver."""
    solver = EnergyMomentum(system)
    states = [system.initial_state() for _ in range(n + 1)]
    for state, new in pairwise(states):
        solver.advance(state, dt, new)
        new.time = state.time + dt
    return states, solver


def taught(comm, states, dt, *tolerances):
    """An estimate that has accepted all steps but the last."""
    error = StepError(comm, *tolerances)
    for state, new in pairwise(states[:-1]):
        error.estimate(state, new, dt)
        error.accept(dt)
    return error


def errors_of_a_step(system, dt, last_dt=None, begin=0.4):
    """Estimate and true local error of a step of dt that begins at some time: (estimated, true).

    Both are the largest component in the coordinates of rigid bodies; lengths count like angles.
    The step before it is ``last_dt`` long, or dt. The truth are 64 small steps from the same state,
    which have 1/4096 of the error.
    """
    last_dt = last_dt or dt
    n = round((begin - last_dt) / 0.005)
    solver, error = EnergyMomentum(system), StepError(system.comm, 1.0, 1.0)
    state, new = system.initial_state(), system.initial_state()
    for size in [(begin - last_dt) / n] * n + [last_dt]:
        solver.advance(state, size, new)
        error.estimate(state, new, size)
        error.accept(size)
        state, new = new, state
    solver.advance(state, dt, new)
    estimated = error.estimate(state, new, dt)
    fine, finer = state.copy(), state.copy()
    for _ in range(64):
        solver.advance(fine, dt / 64, finer)
        fine, finer = finer, fine
    return estimated, float(np.max(np.abs(new.q - fine.q)))


@pytest.mark.parametrize("make", [spinning, tumbling])
@pytest.mark.parametrize("dt", [0.02, 0.04])
def test_estimate_is_the_true_local_error_within_a_factor_of_two(comm, make, dt):
    estimated, true = errors_of_a_step(make(comm), dt)
    assert true > 1e-6  # far above the round-off of the solver
    assert 0.5 <= estimated / true <= 2.0


@pytest.mark.parametrize("begin", [0.2, 0.4, 0.6, 0.8])
def test_estimate_with_constraints_is_never_far_below_the_true_error(comm, begin):
    """It counts what the constraints correct, too: five times the error while that is small."""
    estimated, true = errors_of_a_step(pendulum(comm), 0.02, begin=begin)
    assert 0.5 <= estimated / true <= 6.0


def test_estimate_of_a_steady_rotation_is_a_formula(comm):
    """A director on a circle has |x'''| = w^3; its largest component is 0.71 of that or more."""
    w, dt = 2.0, 0.05
    estimated, true = errors_of_a_step(spinning(comm, w), dt)
    assert 0.45 <= estimated / ((w * dt) ** 3 / 12.0) <= 1.0
    assert 0.6 <= true / (w * dt - 2.0 * np.arctan(w * dt / 2.0)) <= 1.0


@pytest.mark.parametrize("make", [tumbling, pendulum])
def test_half_the_step_has_an_eighth_of_the_error(comm, make):
    large, small = (errors_of_a_step(make(comm), dt)[0] for dt in (0.02, 0.01))
    assert 7.0 <= large / small <= 9.0  # a second order would be 4


@pytest.mark.parametrize(("dt", "last_dt"), [(0.02, 0.04), (0.04, 0.02), (0.02, 0.005)])
def test_estimate_holds_for_unequal_steps(comm, dt, last_dt):
    estimated, true = errors_of_a_step(tumbling(comm), dt, last_dt)
    assert 0.4 <= estimated / true <= 2.5


def test_each_tolerance_limits_its_own_coordinates(comm):
    """A body that turns, and whose centre moves at constant speed."""
    states, _ = history(spinning(comm), 0.05)
    found = {}
    for angle, displacement in ((1.0, None), (0.5, None), (None, 1e-9), (1.0, 1e-9)):
        error = taught(comm, states, 0.05, angle, displacement)
        found[angle, displacement] = error.estimate(*states[-2:], 0.05)
    assert found[1.0, None] > 1e-5
    assert found[0.5, None] == pytest.approx(2.0 * found[1.0, None], rel=1e-14)
    assert found[None, 1e-9] < 1e-3  # round-off
    assert found[1.0, 1e-9] == max(found[1.0, None], found[None, 1e-9])


@pytest.mark.parallel
def test_nodes_of_flexible_bodies_count_as_displacements(comm, machine):
    """The nodes of a beam whose root turns jerk more than the centres of rigid bodies."""
    states, _ = history(machine(spin=3.0).system(Gravity()), 0.02)
    found = taught(comm, states, 0.02, None, 1.0).estimate(*states[-2:], 0.02)

    def jerk(rates):
        """Largest dt^3/12 x''' from the mean velocities of the last three steps."""
        w = [0.5 * (rates(x) + rates(y)) for x, y in pairwise(states[1:])]
        return float(0.02 / 12.0 * np.max(np.abs(w[2] - 2.0 * w[1] + w[0]), initial=0.0))

    nodes = max(comm.allgather(jerk(lambda s: s.v[0].array)))
    assert nodes > 3.0 * jerk(lambda s: s.q_dot.reshape(-1, 4, 3)[:, 0])
    assert 0.3 <= found / nodes <= 3.0
    assert comm.allgather(found) == [found] * comm.size  # or ranks would take different steps


def test_first_step_has_no_estimate(comm):
    system = spinning(comm)
    state, new = system.initial_state(), system.initial_state()
    EnergyMomentum(system).advance(state, 0.5, new)
    assert StepError(comm, 1e-12, 1e-12).estimate(state, new, 0.5) == 0.0


def test_a_step_that_was_not_accepted_leaves_no_trace(comm):
    states, solver = history(pendulum(comm), 0.02)
    *_, state, new = states
    found = []
    for tried in ((), (0.3, 0.1)):
        error = taught(comm, states, 0.02, 1.0)
        for dt in (*tried, 0.02):
            solver.advance(state, dt, new)
            last = error.estimate(state, new, dt)
        found.append(last)
    assert found[0] == found[1] > 0.0


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, float("nan")])
@pytest.mark.parametrize("name", ["angle", "displacement"])
def test_tolerances_must_be_positive(comm, name, tolerance):
    with pytest.raises(ValueError, match=f"the {name} tolerance must be positive, got"):
        StepError(comm, **{name: tolerance})


@pytest.mark.parallel
def test_what_is_saved_gives_the_same_estimate(comm, machine):
    states, _ = history(machine(spin=3.0).system(Gravity()), 0.02)
    first, second = taught(comm, states, 0.02, 1e-3, 1e-3), StepError(comm, 1e-3, 1e-3)
    assert not second.save()
    second.restore(first.save())
    for dt in (0.01, 0.03):
        found = [error.estimate(*states[-2:], dt) for error in (first, second)]
        assert found[0] == found[1] > 0.0
        for error in (first, second):
            error.accept(dt)


@pytest.fixture(scope="module")
def reference(comm):
    """The pendulum with very small steps."""
    return run(pendulum(comm), 2e-3, END)[0]


@pytest.fixture(scope="module")
def runs(comm):
    """Runs with tolerances that decrease by factors of 8."""
    return [run(pendulum(comm), 0.1, END, StepError(comm, angle=tol)) for tol in TOLERANCES]


def test_smaller_tolerance_makes_smaller_errors(runs, reference):
    """An eighth of the tolerance is half the step and a quarter of the error, more or less: steps
    are halves of halves."""
    right, errors = np.array(reference.q), []
    for seen, _ in runs:
        full = [k for k, t in enumerate(seen.times) if abs(t - 0.1 * round(10.0 * t)) < 1e-9]
        assert len(full) == 13
        errors.append(np.max(np.abs(np.array(seen.q)[full] - right[::50])))
    assert errors[0] <= 10.0 * TOLERANCES[0]
    assert errors[0] / errors[1] > 2.0
    assert errors[1] / errors[2] > 2.0


def test_steps_are_as_many_as_the_order_of_the_error_needs(runs):
    """Half as long for an eighth of the tolerance; if what drives them were of first order in dt,
    as the alternation of velocities after a change of dt is, they would be eight times as many."""
    counts = [len(seen.times) for seen, _ in runs]
    assert 1.4 <= counts[1] / counts[0] <= 3.0
    assert 1.4 <= counts[2] / counts[1] <= 3.0


def test_energy_balances_exactly(runs):
    for seen, _ in runs:
        assert np.max(np.abs(seen.energy_errors)) <= 1e-11  # of energies around 20 J


def test_halvings_are_counted(runs):
    for seen, simulation in runs:
        sizes = np.diff(seen.times)
        assert simulation.halvings >= np.count_nonzero(sizes[1:] < 0.9 * sizes[:-1]) > 0
        # steps do not grow only to be halved again
        assert simulation.halvings <= 0.1 * len(seen.times)


def test_all_multiples_of_the_step_are_met(runs):
    for seen, _ in runs:
        assert np.isin(0.1 * np.arange(12), seen.times).all()


def test_accepted_steps_keep_the_tolerance(comm):
    accepted = []

    class Spy(StepError):
        def estimate(self, *arguments):
            self.found = super().estimate(*arguments)
            return self.found

        def accept(self, dt):
            accepted.append(self.found)
            super().accept(dt)

    run(pendulum(comm), 0.1, 0.5, Spy(comm, angle=5e-5))
    assert accepted[0] == 0.0
    assert 0.1 < max(accepted) <= 1.0


def test_a_loose_tolerance_changes_no_full_step(comm):
    free, _ = run(tumbling(comm), 0.05, 0.5)
    loose, simulation = run(tumbling(comm), 0.05, 0.5, StepError(comm, 1.0, 1.0))
    assert simulation.halvings == 0
    assert loose.times[-6:] == free.times[-6:]


def test_steps_follow_a_short_torque_and_grow_back(comm):
    """The rotor turns slowly, is struck, and turns slowly again, backwards."""
    body = RigidBody("rotor", 2.0, (0.02, 0.03, 0.04), angular_velocity=(0.0, 0.0, 0.3))
    pin = Revolute("pin", None, body, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    # the moment of inertia is 0.05 kg m^2, so that the speed changes by 0.6 rad/s
    pulse = JointTorque(
        "torque on pin", "pin", 1.0, lambda t: -0.15 * max(0.0, 1.0 - abs(t - 1.1) / 0.2)
    )
    system = MultibodySystem(comm, [body, pin, pulse])
    seen, _ = run(system, 0.1, 2.6, StepError(comm, angle=1e-4))
    begins, sizes = np.array(seen.times[:-1]), np.diff(seen.times)
    before, during = (begins > 0.35) & (begins < 0.75), (begins > 1.05) & (begins < 1.15)
    assert sizes[before] == pytest.approx(0.1)
    assert np.max(sizes[during]) < 0.06
    assert sizes[-3:] == pytest.approx(0.1)
    assert np.max(np.abs(seen.energy_errors)) <= 1e-12


def test_a_second_run_starts_again(comm):
    """Nothing of the first one counts as the step before its first."""
    seen = Recorder()
    error = StepError(comm, angle=5e-5)
    simulation = Simulation(pendulum(comm), 0.1, 0.3, [seen], step_error=error)
    simulation.run()
    simulation.run()
    half = len(seen.times) // 2
    assert seen.times[:half] == seen.times[half:]
    assert np.array_equal(seen.q[:half], seen.q[half:])


@pytest.mark.parallel
def test_a_tolerance_out_of_reach_ends_in_one_sentence(comm):
    error = StepError(comm, 1e-14)
    simulation = Simulation(pendulum(comm), 0.1, 0.5, step_error=error, smallest_step=0.125)
    words = r"times the allowed error\. .* look at time\.angle_tolerance and time\.displacement_tol"
    with pytest.raises(StepFailure, match=words) as caught:
        simulation.run()
    assert "\n" not in str(caught.value)

"""Claims about the first guess from the last steps: where it is exact and what it saves."""

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import Gravity, JointTorque, Revolute, Table
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import E3
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum, EnergyMomentumStep
from turbine_fenicsx.time_stepping.first_guess import WEIGHTS, FirstGuess
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

DT = 0.02
N = len(WEIGHTS)
EPS = np.finfo(float).eps


class Past:
    """A first guess that is told the unknowns of its steps, as many as an example has."""

    def __init__(self):
        body = RigidBody("body", 1.0, (1.0, 1.0, 1.0))
        self.guess = FirstGuess(EnergyMomentumStep(MultibodySystem(MPI.COMM_SELF, [body])))

    def extrapolate(self, time, dt):
        return self.guess.extrapolate(time, dt)

    def learn(self, time, dt, r):
        self.guess._step.rigid_unknowns = lambda: r
        self.guess.learn(time, dt)


def known(steps=N, dt=DT, r=lambda n: np.array([n, n**2.0]), start=0.0):
    """A first guess that has seen some steps, and the time of their end."""
    past = Past()
    for n in range(steps):
        past.learn(start + n * dt, dt, r(n))
    return past, start + steps * dt


@pytest.mark.parametrize("degree", range(6))
def test_polynomials_of_degree_four_are_continued_exactly(degree):
    past, time = known(r=lambda n: np.array([(n - 2.5) ** degree]))
    error = abs(past.extrapolate(time, DT)[0] - 3.5**degree)
    if degree < 5:
        assert error <= 20 * EPS * 3.5**degree  # the sum of all weights is 19
    else:
        assert error == pytest.approx(2 * 120, rel=1e-12)  # twice the fifth derivative


def test_an_alternating_part_is_continued_exactly():
    """Velocities and multipliers have one after a jump of a load."""
    past, time = known(r=lambda n: np.array([1e3 + (-1.0) ** n, (-1.0) ** n]))
    assert past.extrapolate(time, DT).tolist() == [1e3 + (-1.0) ** N, (-1.0) ** N]


def test_there_is_no_guess_before_enough_steps():
    for steps in range(N):
        past, time = known(steps)
        assert past.extrapolate(time, DT) is None
    for steps in (N, N + 1, 3 * N):
        past, time = known(steps)
        assert past.extrapolate(time, DT) == pytest.approx([steps, steps**2], rel=1e-12)


@pytest.mark.parametrize(("later", "dt"), [(0.0, 0.5 * DT), (0.0, 2 * DT), (DT, DT), (-DT, DT)])
def test_another_step_or_a_gap_is_no_continuation(later, dt):
    past, time = known()
    assert past.extrapolate(time + later, dt) is None
    past.learn(time + later, dt, np.zeros(2))
    for n in range(1, N):
        assert past.extrapolate(time + later + n * dt, dt) is None
        past.learn(time + later + n * dt, dt, np.zeros(2))
    assert past.extrapolate(time + later + N * dt, dt).tolist() == [
        0.0,
        0.0,
    ]  # nothing of the old ones


def test_round_off_of_the_time_is_no_gap():
    past, time = known(start=1e4, dt=1e-3)
    assert past.extrapolate(np.nextafter(time, 0.0), 1e-3 * (1 + EPS)) is not None


def test_forgotten_steps_are_needed_anew():
    past, time = known()
    past.guess.forget()
    assert past.extrapolate(time, DT) is None
    past.learn(time, DT, np.zeros(2))
    assert past.extrapolate(time + DT, DT) is None


@pytest.mark.parametrize("steps", [0, 1, N - 1, N, N + 3])
def test_what_is_saved_gives_the_same_guesses_bit_for_bit(steps):
    rng = np.random.default_rng(3)
    size = Past().guess._step.system.rigid_model.size
    past, time = known(steps, r=lambda n: rng.normal(size=size))
    again, _ = known(N)
    again.guess.restore(past.guess.save())
    for _ in range(N + 1):
        guesses = [p.extrapolate(time, DT) for p in (past, again)]
        assert guesses[0] is guesses[1] is None or np.array_equal(*guesses)
        r = rng.normal(size=size)
        for p in (past, again):
            p.learn(time, DT, r)
        time += DT


def pendulum(comm, *loads):
    """A pendulum of 2 m that starts horizontally."""
    bob = RigidBody("bob", 3.0, (0.1, 0.2, 0.3), position=(2.0, 0.0, 0.0))
    return MultibodySystem(
        comm, [bob, Revolute("hinge", None, bob, point=(0, 0, 0), axis=E3), Gravity(), *loads]
    )


class Run:
    """A solver that makes steps one after the other, from the start of the system."""

    def __init__(self, system, **options):
        self.solver = EnergyMomentum(system, options=SolverOptions(**options))
        self.state, self._out = system.initial_state(), system.initial_state()

    def steps(self, n, dt=DT):
        """Newton iterations of each of some more steps."""
        found = []
        for _ in range(n):
            found.append(self.solver.advance(self.state, dt, self._out).newton_iterations)
            self.state, self._out = self._out, self.state
        return found

    def forget(self):
        """Go on from the state alone."""
        self.solver.restore(RestartData())


def values(state):
    return np.concatenate([state.q, state.q_dot, state.joint_coordinates, state.multipliers])


def test_in_smooth_motion_one_newton_iteration_is_enough(comm):
    with_past, without = Run(pendulum(comm)), Run(pendulum(comm))
    guessed = with_past.steps(200, 0.005)
    plain = []
    for _ in range(200):
        plain += without.steps(1, 0.005)
        without.forget()
    assert set(guessed[N:]) == {1}
    assert guessed[:N] == plain[:N]
    assert set(plain) == {1, 2} and sum(plain) > 300
    a, b = with_past.state, without.state
    # two hundred steps of tolerance 1e-12, in numbers of order one
    assert np.allclose(a.q, b.q, rtol=0, atol=1e-10)
    assert np.allclose(a.joint_coordinates, b.joint_coordinates, rtol=0, atol=1e-10)


def test_a_jump_of_a_load_costs_iterations_but_no_energy(comm):
    torque = JointTorque("torque on hinge", "hinge", 1.0, Table([0.3, 0.3001], [0.0, 80.0]))
    run = Run(pendulum(comm, torque))
    system = run.solver.step.system
    energy = system.balance(run.state).total
    iterations = run.steps(60, 0.005)
    angle = run.state.joint_coordinates[0]
    iterations += run.steps(5 * N, 0.005)
    assert max(iterations[N:]) <= 3
    assert iterations[-1] == 1  # the jump is behind
    work = 80.0 * (run.state.joint_coordinates[0] - angle)
    assert abs(work) > 1.0
    assert system.balance(run.state).total - energy == pytest.approx(work, rel=1e-11)


def test_a_useless_guess_costs_an_attempt_and_is_forgotten(comm):
    run, expected = Run(pendulum(comm)), Run(pendulum(comm))
    run.steps(N)
    expected.steps(N)
    expected.forget()
    time = run.state.time
    for n in range(N):  # as if it had come here by leaps
        r = 1e3 * np.arange(run.solver.step.system.rigid_model.size) ** (n % 3)
        run.solver._guess._steps.add(time + (n - N) * DT, DT, r)
    assert run.solver._guess.extrapolate(time, DT) is not None
    more, plain = run.steps(1), expected.steps(1)
    assert more[0] > plain[0]
    assert np.array_equal(values(run.state), values(expected.state))
    assert run.solver._guess.extrapolate(run.state.time, DT) is None
    assert run.steps(1) == expected.steps(1)


@pytest.mark.parametrize("dt", [0.5 * DT, 2.0 * DT])
def test_a_step_of_another_length_depends_on_the_state_alone(comm, dt):
    run, fresh = Run(pendulum(comm)), Run(pendulum(comm))
    for r in (run, fresh):
        r.steps(2 * N)
    fresh.forget()
    run.steps(N, dt)
    fresh.steps(N, dt)
    assert np.array_equal(values(run.state), values(fresh.state))


def test_a_start_from_another_state_depends_on_that_state_alone(comm):
    """A solver may serve again."""
    run, fresh = Run(pendulum(comm)), Run(pendulum(comm))
    run.steps(N + 3)
    run.state = run.solver.step.system.initial_state()
    assert run.steps(N + 3) == fresh.steps(N + 3)
    assert np.array_equal(values(run.state), values(fresh.state))


def test_a_step_that_fails_leaves_no_past(comm):
    run = Run(pendulum(comm))
    run.steps(N)
    assert run.solver._guess.extrapolate(run.state.time, DT) is not None
    run.state.q_dot[:] = np.nan
    with pytest.raises(StepFailure):
        run.steps(1)
    assert run.solver._guess.extrapolate(run.state.time, DT) is None
    assert not run.solver.save().part("guess")


@pytest.mark.parallel
def test_flexible_bodies_are_not_extrapolated(machine):
    run = Run(machine(spin=3.0).system())
    run.steps(N)
    assert run.solver._guess.extrapolate(run.state.time, DT) is None

"""Claims about errors of first guesses: which motions tell them in advance, and what that saves."""

from mpi4py import MPI

import numpy as np
import pytest
from newton_steps import DT, equal, options, run, values

from turbine_fenicsx import JointTorque, Ramp
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.rotations import E3, rotation_about
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentumStep
from turbine_fenicsx.time_stepping.first_guess import TERMS, FirstGuess

N = TERMS + 1
EPS = np.finfo(float).eps


class Past:
    """Errors of the guesses of a step, and what they add to the next guess.

    The machine turns by ``turn`` [rad] about e3 from step to step.
    """

    def __init__(self, system, turn=0.0):
        self.system, self.step, self.turn = system, EnergyMomentumStep(system), turn
        self.errors = FirstGuess(self.step)
        n = self.errors._increments().size
        rng = np.random.default_rng(system.comm.rank)
        self.fields = rng.normal(size=(40, n))

    def begin(self, n, dt=DT, later=0.0):
        """Begin step n; returns what is added to its guess."""
        state = self.system.initial_state()
        state.time = n * DT + later
        R = rotation_about(E3, n * self.turn)
        state.q = (state.q.reshape(-1, 3) @ R.T).ravel()
        self.step.start_step(state, dt)
        self.step.guess(True)
        self.time, self.dt = state.time, dt
        guess = self.errors._increments()
        self.errors.correct(self.time, dt)
        return self.errors._increments() - guess

    def end(self, error):
        """The step ends with this error of its guess."""
        self.errors._write(self.errors._guess + error)
        self.errors.learn(self.time, self.dt)

    def turned(self, field, n):
        """What is a field at the start, carried by the machine for n steps."""
        turned = field.copy()
        vectors = turned.size
        if self.step.n_r:
            vectors -= self.step.n_r - self.system.rigid_model.n_q
        R = rotation_about(E3, n * self.turn)
        turned[:vectors] = (field[:vectors].reshape(-1, 3) @ R.T).ravel()
        return turned


SMOOTH = [
    lambda n, f: f[0],
    lambda n, f: f[0] + n * f[1],
    lambda n, f: f[0] + n * f[1] + (-1.0) ** n * f[2],
    lambda n, f: 0.9**n * f[0] + 1.1**n * f[1] + (-0.8) ** n * f[2],
    lambda n, f: np.cos(0.3 * n) * f[0] + np.sin(0.3 * n) * f[1],
]


@pytest.mark.parametrize("motion", SMOOTH)
@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_smooth_errors_are_told_in_advance(machine, motion, turn):
    past = Past(machine().system(), turn)
    for n in range(N + 4):
        error = past.turned(motion(n, past.fields), n)
        added = past.begin(n)
        if n < N:
            assert not added.any()
        else:
            # least squares by products: half the digits where fields are nearly alike
            assert np.allclose(added, error, rtol=0, atol=1e-4)
        past.end(error)


def test_errors_that_do_not_follow_from_each_other_are_not_used(machine):
    past = Past(machine().system())
    for n in range(3 * N):
        assert not past.begin(n).any()
        past.end(past.fields[n])


def test_a_sudden_error_is_not_continued(machine):
    past = Past(machine().system())
    smooth, sudden = past.fields[0], 3.0 * past.fields[1]
    for n in range(3 * N):
        added = past.begin(n)
        if n == N + 1:
            assert not added.any()
        elif n in (N, 3 * N - 1):
            assert np.allclose(added, smooth, rtol=0, atol=1e-9)
        past.end(smooth + (sudden if n == N else 0.0))


def test_no_errors_add_nothing(machine):
    past = Past(machine().system())
    for n in range(2 * N):
        assert not past.begin(n).any()
        past.end(0.0 * past.fields[0])


@pytest.mark.parametrize(("dt", "later"), [(0.5 * DT, 0.0), (DT, DT), (DT, -DT)])
def test_another_step_or_a_gap_is_no_continuation(machine, dt, later):
    past = Past(machine().system())
    for n in range(N):
        past.begin(n)
        past.end(past.fields[0])
    assert not past.begin(N, dt, later).any()
    assert past.errors.save()
    past.end(past.fields[0])
    assert "u_1" not in past.errors.save().nodal  # nothing of the old ones


@pytest.mark.parametrize("steps", [0, 1, N - 1, N, N + 2])
def test_what_is_saved_gives_the_same_guesses_bit_for_bit(machine, steps):
    system = machine().system()
    first, second = Past(system, 0.1), Past(system, 0.1)
    errors = [1.1**n * first.fields[0] + 0.1 * first.fields[n] for n in range(steps + N + 1)]
    for n in range(steps):
        first.begin(n)
        first.end(errors[n])
    second.errors.restore(first.errors.save())
    for n in range(steps, steps + N + 1):
        assert np.array_equal(first.begin(n), second.begin(n))
        for past in (first, second):
            past.end(errors[n])


def swaying(m):
    """The machine, on which a torque acts that grows slowly."""
    torque = JointTorque("torque on rotor", "rotor", 1.0, Ramp(4.0, 1.0, smooth=True))
    return m.system(torque)


def without_past(solver, system, steps, dt):
    """`run`, where each step forgets the ones before."""
    real, guess = FirstGuess.correct, solver._guess
    guess.correct = lambda *time: (guess.forget(), real(guess, *time))
    return run(solver, system, steps, dt)


def test_in_smooth_motion_iterations_are_saved_and_nothing_else_changes(machine, solve):
    system, counts, states = swaying(machine()), [], []
    for make in (run, without_past):
        state, reports = make(solve(system, options("frozen")), system, 60, 0.01)
        counts.append(sum(report.newton_iterations for report in reports))
        states.append(values(state))
    assert counts[0] <= 0.85 * counts[1]
    for a, b in zip(*states, strict=True):
        assert np.abs(a - b).max(initial=0.0) <= 1e-8 * max(np.abs(b).max(initial=0.0), 1.0)


def test_a_step_that_fails_leaves_no_past(machine, solve):
    system = swaying(machine())
    solver = solve(system, options("frozen"))
    state, _ = run(solver, system, N, 0.01)
    assert solver.save().part("guess")
    state.q_dot[:] = np.nan
    with pytest.raises(StepFailure):
        solver.advance(state, 0.01, state.copy())
    assert not solver.save().part("guess")


@pytest.mark.parallel
def test_a_solver_goes_on_bit_for_bit(machine, solve):
    system = swaying(machine())
    first, second, third = (solve(system, options("frozen")) for _ in range(3))
    state, _ = run(first, system, 20, 0.01)
    saved, found = first.save(), []
    poorer = RestartData(
        *({k: v for k, v in part.items() if "guess." not in k} for part in saved._parts())
    )
    second.restore(saved)
    third.restore(poorer)
    for solver in (first, second, third):
        out = state.copy()
        solver.advance(state, 0.01, out)
        found.append(values(out))
    assert equal(found[0], found[1])
    assert not equal(found[0], found[2])  # from another guess it would not be the same


@pytest.mark.parallel
def test_ranks_do_not_matter(machine, solve, comm):
    """Except for round-off, at which these iterations end."""
    counts, ends = [], []
    for on in (comm, MPI.COMM_SELF):
        system = swaying(machine(comm=on))
        state, reports = run(solve(system, options("frozen")), system, 40, 0.01)
        counts.append(sum(report.newton_iterations for report in reports))
        ends.append(np.concatenate([state.q, state.q_dot, state.joint_coordinates]))
    assert abs(counts[0] - counts[1]) <= 0.05 * counts[1]
    assert np.abs(ends[0] - ends[1]).max() < 1e-9


@pytest.mark.parametrize("name", ["lu", "monolithic"])
def test_exact_tangents_start_where_velocities_lead(machine, solve, name):
    """From a better guess they would end just below the tolerance, not digits below."""
    system = swaying(machine())
    solver = solve(system, options(name))
    run(solver, system, 2 * N)
    assert not solver.save().part("guess")

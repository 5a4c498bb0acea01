"""A run that goes on from a checkpoint is the run without one, bit for bit."""

import pytest
from recorded_runs import Fussy, Keeper, Recorder, equal, goes_on_everywhere, simulate

from turbine_fenicsx import Gravity, Hat, JointTorque
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.linear_solvers import quasi_newton
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.simulation.step_error import StepError
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.first_guess import FirstGuess
from turbine_fenicsx.time_stepping.solver_options import SolverOptions


@pytest.fixture
def flexible(machine):
    """The machine under gravity and torques, strongly deformed."""
    loads = [
        Gravity(),
        JointTorque("torque on rotor", "rotor", 1.0, Hat(40.0, 0.4)),
        JointTorque("torque on yaw", "yaw", 1.0, Hat(5.0, 1.0)),
    ]
    return machine(spin=3.0).system(*loads)


@pytest.mark.parallel
@pytest.mark.parametrize("name", ["frozen", "iterative", "lu", "monolithic"])
def test_a_run_goes_on_bit_for_bit_with_any_linear_solver(flexible, name):
    def stepper(chosen=name):
        return EnergyMomentum(flexible, options=SolverOptions(linear_solver=chosen))

    whole, *_ = goes_on_everywhere(flexible, lambda: {"stepper": stepper()}, every=3)
    if name == "frozen":  # without its factor it would not be the same
        other, *_ = simulate(flexible, stepper=stepper("lu"))
        assert not equal(whole[8], other[8])


def test_a_run_goes_on_with_the_factor_it_had(flexible, monkeypatch):
    """The factor of a later state gives other digits: it must be the one of the whole run."""
    whole, saved, _ = simulate(flexible)
    monkeypatch.setattr(QuasiNewton, "restore", lambda self, data: None)
    part, *_ = simulate(flexible, saved[5])
    assert not equal(part[6], whole[6])


def test_a_run_goes_on_bit_for_bit_after_and_before_a_refreshed_factor(flexible, monkeypatch):
    """A step of many iterations is followed by a refresh, with or without a stop in between."""
    refreshed = []
    real_begin = QuasiNewton.start_iteration

    def start_iteration(self):
        refreshed.append(self._excess >= quasi_newton.RENEWAL)
        real_begin(self)

    monkeypatch.setattr(QuasiNewton, "start_iteration", start_iteration)
    monkeypatch.setattr(quasi_newton, "BASELINE_STEPS", 0)
    monkeypatch.setattr(quasi_newton, "RENEWAL", 12)
    _, saved, _ = goes_on_everywhere(flexible, dict)
    assert 0 < sum(refreshed[:8]) < 8  # sometimes, but not always
    due = [saved[k].numbers["solver.linear.excess"] >= 12 for k in range(1, 9)]
    assert set(due) == {True, False}  # checkpoints just before a refresh, and others


def test_a_run_goes_on_bit_for_bit_while_the_exact_solver_stands_in(flexible, monkeypatch):
    """Which solver goes first, and for how long, is part of what a run saves."""
    real = FrozenElimination.solve

    def poor_solve(self, b, x):
        real(self, b, x)
        if self._step.start.state.time < 0.045:
            x.scale(-1e9)

    monkeypatch.setattr(FrozenElimination, "solve", poor_solve)
    _, saved, simulation = goes_on_everywhere(flexible, dict)
    assert simulation.stepper.fallbacks >= 2
    waits = [data.numbers["solver.attempts.wait"] for data in saved.values()]
    assert 0 < min(filter(None, waits)) and 0 in waits


@pytest.mark.parallel
def test_a_run_goes_on_bit_for_bit_in_the_middle_of_halved_steps(flexible):
    def options():
        return {"fails": lambda t, dt: 0.045 < t < 0.12 and dt > 0.003, "end": 0.18}

    _, saved, simulation = goes_on_everywhere(flexible, options, every=2)
    assert simulation.halvings >= 3
    assert len({m.numbers["level"] for m in saved.values()}) >= 3
    assert sum(m.numbers["ticks"] > 0 for m in saved.values()) >= 5


@pytest.fixture
def rigid(comm, machine):
    """The rigid part of the machine; its first guesses come from the last steps."""
    m = machine(spin=3.0)
    torque = JointTorque("torque on rotor", "rotor", 1.0, Hat(40.0, 0.2))
    return MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity(), torque])


def test_a_rigid_run_goes_on_bit_for_bit(rigid, monkeypatch):
    whole, saved, _ = goes_on_everywhere(rigid, lambda: {"end": 0.3})
    monkeypatch.setattr(FirstGuess, "restore", lambda self, data: None)
    part, *_ = simulate(rigid, saved[9], end=0.3)
    assert not equal(part[10], whole[10])  # from another guess it would not be the same


def test_a_rigid_run_goes_on_bit_for_bit_in_the_middle_of_halved_steps(rigid):
    def options():
        return {"fails": lambda t, dt: 0.145 < t < 0.2 and dt > 0.003, "end": 0.3}

    _, _, simulation = goes_on_everywhere(rigid, options, every=2)
    assert simulation.halvings >= 3


def test_a_rigid_run_goes_on_bit_for_bit_from_a_file(rigid, shared_tmp_path):
    whole, saved, _ = simulate(rigid, end=0.3)
    Checkpoints(rigid, shared_tmp_path).write(9, 0.18, 0.0, saved[9])
    part, *_ = simulate(rigid, Checkpoints(rigid, shared_tmp_path).load(), end=0.3)
    assert all(equal(record, whole[k]) for k, record in part.items())


def test_a_run_goes_on_bit_for_bit_with_steps_that_follow_a_tolerance(comm, flexible):
    def options():
        return {"step_error": StepError(comm, 5e-5, 5e-5), "step": 0.04}

    _, saved, _ = goes_on_everywhere(flexible, options, every=3)
    assert len({m.numbers["level"] for m in saved.values()}) >= 2
    assert sum(m.numbers["ticks"] > 0 for m in saved.values()) >= 5


@pytest.mark.parametrize("step", [0.02, 0.1])
@pytest.mark.parametrize("n", [3, 7])
def test_a_run_that_is_extended_is_as_long_from_the_start(comm, machine, step, n):
    """Also where n dt is not quite the end that the user wrote, such as 0.3 and 3 * 0.1."""
    m = machine(spin=3.0)
    system = MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity()])
    whole, *_ = simulate(system, step=step, end=round(10 * step, 9))
    first, saved, _ = simulate(system, step=step, end=round(n * step, 9))
    rest, *_ = simulate(system, saved[n], step=step, end=round(10 * step, 9))
    for k in range(11):
        for part in (first, rest):
            assert k not in part or equal(part[k], whole[k]), k


def test_an_end_between_two_steps_can_be_extended(flexible):
    first, saved, _ = simulate(flexible, end=0.05)
    rest, *_ = simulate(flexible, saved[3], end=0.1)
    assert first[3][0][0] == 0.05
    times = [rest[k][0][0] for k in sorted(rest)]
    assert times == pytest.approx([0.05, 0.07, 0.09, 0.1], rel=1e-14)
    assert times[0] == 0.05 and times[-1] == 0.1
    assert abs(rest[6][0][3]) <= 1e-10  # the energy balances over the whole run


def test_the_step_can_change_when_a_run_goes_on(flexible):
    _, saved, _ = simulate(flexible, end=0.06)
    rest, *_ = simulate(flexible, saved[3], step=0.01, end=0.1)
    times = [rest[k][0][0] for k in sorted(rest)]
    assert times == pytest.approx([0.06, 0.07, 0.08, 0.09, 0.1], rel=1e-14)
    assert abs(rest[7][0][3]) <= 1e-10


def test_the_linear_solver_can_change_when_a_run_goes_on(flexible):
    whole, saved, _ = simulate(flexible)
    for name in ("frozen", "lu"):
        other = EnergyMomentum(flexible, options=SolverOptions(linear_solver=name))
        rest, *_ = simulate(flexible, saved[4], stepper=other)
        assert rest[8][1][0] == pytest.approx(whole[8][1][0], abs=1e-9)


@pytest.mark.parametrize("end", [0.06, 0.03])
def test_a_run_that_is_at_its_end_or_beyond_stays_there(flexible, end):
    _, saved, _ = simulate(flexible, end=0.06)
    rest, *_ = simulate(flexible, saved[3], end=end)
    assert sorted(rest) == [3]
    assert rest[3][0][0] == 0.06


@pytest.mark.parallel
def test_a_step_that_fails_leaves_a_checkpoint_of_the_last_good_one(flexible):
    keeper, recorder = Keeper(), Recorder()
    keeper.due = lambda time, wall_time: False
    simulation = Simulation(
        flexible, 0.02, 0.16, [recorder], smallest_step=0.25, checkpoints=keeper
    )
    simulation.stepper = Fussy(simulation.stepper, lambda t, dt: t > 0.05)
    with pytest.raises(StepFailure, match="Steps are not halved below"):
        simulation.run()
    assert sorted(keeper.saved) == [0, max(recorder.seen)]
    rest, _, again = simulate(flexible, keeper.saved[max(recorder.seen)], smallest_step=0.25)
    assert rest[max(rest)][0][0] == 0.16
    assert again.halvings == 2  # those of the failed run

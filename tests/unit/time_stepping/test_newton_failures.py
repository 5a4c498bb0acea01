"""Claims about steps that fail, and about what takes over."""

import logging

import numpy as np
import pytest
from newton_steps import DT, all_solvers, equal, loaded, options, spinning_top, values

from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.linear_solvers.frozen import FrozenElimination

pytestmark = pytest.mark.parallel


@all_solvers
def test_a_failed_step_says_why_in_words_and_changes_nothing(solve, machine, name):
    system = loaded(machine(spin=3.0))
    solver = solve(system, options(name, max_iterations=1))
    state, out = system.initial_state(), system.initial_state()
    state.time = 0.25
    before = values(state), values(out)
    message = (
        r"^the step from t = 0\.25 s by 0\.02 s did not converge: the residual is still too large "
        r"after 1 iteration; the residual is largest in beam near \(1(\.5)?, .*, .*\) m$"
    )
    with pytest.raises(StepFailure, match=message):
        solver.advance(state, DT, out)
    assert equal(before[0], values(state))
    assert equal(before[1], values(out))


@all_solvers
def test_a_successful_step_does_not_change_the_state_it_starts_from(solve, machine, name):
    system = loaded(machine(spin=3.0))
    solver = solve(system, options(name))
    state = system.initial_state()
    before = values(state)
    solver.advance(state, DT, system.initial_state())
    assert equal(before, values(state))


@all_solvers
def test_a_failed_step_leaves_no_trace_in_the_next(solve, machine, name):
    system = loaded(machine(spin=3.0))
    fresh, used = (solve(system, options(name)) for _ in range(2))
    state, out, expected = (system.initial_state() for _ in range(3))
    with pytest.raises(StepFailure):
        used.advance(state, 100.0, out)  # many turns in one step
    used.advance(state, DT, out)
    fresh.advance(state, DT, expected)
    for a, b in zip(values(out), values(expected), strict=True):
        # forces are increments times 2/dt^2, of order ten, and converge less far
        assert np.allclose(a, b, rtol=1e-8, atol=1e-8)


def test_a_state_of_no_numbers_is_a_step_failure_on_all_ranks(solve, comm, machine):
    system = loaded(machine())
    solver = solve(system, options())
    state = system.initial_state()
    state.q_dot[:] = np.nan
    with pytest.raises(StepFailure, match=r"converge: the residual is not a number$"):
        solver.advance(state, DT, system.initial_state())
    assert comm.allreduce(1) == comm.size


def test_an_angle_on_the_wrong_branch_is_rejected(solve, comm):
    """Half a turn and more within a step is beyond what the constraint can tell apart.

    The step itself has a solution with tan(D/2) = spin dt/2: D = 2.2 for spin dt = 4.
    """
    system = spinning_top(comm, spin=4.0)
    solver = solve(system, options())
    out = system.initial_state()
    with pytest.raises(StepFailure, match="a joint turns by a quarter of a revolution or more"):
        solver.advance(system.initial_state(), 1.0, out)
    assert out.joint_coordinates.tolist() == [0.0]
    solver.advance(system.initial_state(), 0.4, out)  # D = 1.35 < pi/2
    assert out.joint_coordinates[0] == pytest.approx(2 * np.arctan(0.8), rel=1e-12)


def test_exact_newton_takes_over_where_the_frozen_factor_fails(solve, machine, monkeypatch, caplog):
    """A preconditioner that makes things worse costs iterations, not the step."""
    system = loaded(machine(spin=3.0))
    solvers = [solve(system, options(name)) for name in ("lu", "frozen")]
    expected, found = system.initial_state(), system.initial_state()
    exact = solvers[0].advance(system.initial_state(), DT, expected)
    frozen_solve = FrozenElimination.solve

    def poor_solve(self, b, x):
        frozen_solve(self, b, x)
        x.scale(-1e3)

    monkeypatch.setattr(FrozenElimination, "solve", poor_solve)
    caplog.set_level(logging.INFO, "turbine_fenicsx")
    report = solvers[1].advance(system.initial_state(), DT, found)
    assert report.newton_iterations > exact.newton_iterations  # failed attempts included
    assert report.work == pytest.approx(exact.work, rel=1e-9)
    assert np.allclose(found.q, expected.q, rtol=0, atol=1e-10)
    assert [solver.fallbacks for solver in solvers] == [0, 1]
    (line,) = (m for m in caplog.messages if m.startswith("the step from"))
    assert line == (
        "the step from t = 0 s by 0.02 s: the residual grows with 'frozen' from the extrapolated "
        "start; now 'lu' from the extrapolated start"
    )


def test_a_frozen_factor_that_fails_is_renewed_before_exact_newton(
    solve, machine, monkeypatch, caplog
):
    system = loaded(machine(spin=3.0))
    frozen_solve, refresh, old = FrozenElimination.solve, FrozenElimination.refresh, []

    def poor_solve(self, b, x):
        frozen_solve(self, b, x)
        if old:
            x.scale(-1e9)

    def renew(self):
        old.clear()
        refresh(self)

    monkeypatch.setattr(FrozenElimination, "solve", poor_solve)
    monkeypatch.setattr(FrozenElimination, "refresh", renew)
    solver, state, out = solve(system, options("frozen")), *(system.initial_state() for _ in "ab")
    solver.advance(state, DT, out)
    old.append("a step ago")
    caplog.set_level(logging.INFO, "turbine_fenicsx")
    solver.advance(out, DT, state)
    assert solver.fallbacks == 1
    assert caplog.messages[:2] == [
        "the step from t = 0.02 s by 0.02 s: the residual grows with 'frozen' from the "
        "extrapolated start; now with a new factor",
        "new factor at t = 0.02 s for steps of 0.02 s",
    ]


def test_a_solver_that_fails_again_and_again_is_asked_less_and_less(solve, machine, monkeypatch):
    """And the state of that is saved."""
    system = loaded(machine(spin=3.0))
    asked = []

    def poor_solve(self, b, x):
        asked.append(state.time)
        b.copy(x)
        x.scale(-1e9)

    monkeypatch.setattr(FrozenElimination, "solve", poor_solve)
    state, out = system.initial_state(), system.initial_state()
    solver, data = solve(system, options("frozen")), None
    for k in range(12):
        solver.advance(state, DT, out)
        state, out = out, state
        if k == 5:
            data = solver.save()
    # the first is followed at once by a try with a new factor
    assert np.unique(np.round(np.array(asked) / DT)).tolist() == [0, 1, 3, 7]
    assert solver.fallbacks == 4
    other = solve(system, options("frozen"))
    other.restore(data)
    assert other.fallbacks == 3
    asked.clear()
    for _ in range(2):
        other.advance(state, DT, out)
        state, out = out, state
    assert np.unique(np.round(np.array(asked) / DT)).tolist() == [13]

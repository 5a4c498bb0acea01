"""Times of steps are whole multiples of dt and of its binary fractions, whatever happens."""

import numpy as np
import pytest

from turbine_fenicsx.simulation.step_grid import StepGrid


def walk(grid, refine_at=(), limit=100_000):
    """Make all steps; those that begin at one of the times are halved first, one level for each
    mention. Returns the times, the sizes, and the levels of the steps."""
    times, sizes, levels = [grid.time], [], []
    left = sorted(refine_at)
    while not grid.done:
        while left and grid.time >= left[0] - 1e-12:
            assert grid.refine()
            left.pop(0)
        sizes.append(grid.dt)
        levels.append(grid.level)
        target = grid.target
        grid.advance()
        assert grid.done or grid.time == target
        times.append(target)
        assert len(times) < limit
    return np.array(times), np.array(sizes), levels


def test_ten_thousand_steps_do_not_drift():
    times, sizes, _ = walk(StepGrid(0.02, 200.0))
    assert np.array_equal(times, 0.02 * np.arange(10_001))
    assert np.all(sizes == 0.02)  # one dt, or each new one is factorised anew


@pytest.mark.parametrize(("step", "end"), [(0.1, 0.3), (0.1, 0.7), (0.05, 12.0), (1 / 30, 1.0)])
def test_round_off_at_the_end_makes_no_other_step(step, end):
    times, sizes, _ = walk(StepGrid(step, end))
    assert len(sizes) == round(end / step)
    assert np.all(sizes == step)
    assert times[-1] == pytest.approx(end, rel=1e-15)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
def test_an_end_just_before_a_multiple_of_the_step_is_met_exactly(gap):
    """Only round-off, a billionth of a step, is taken for a multiple."""
    end = (5.0 - gap) * 0.02
    times, sizes, _ = walk(StepGrid(0.02, end))
    assert times[-1] == end
    assert sizes == pytest.approx([0.02] * 4 + [(1.0 - gap) * 0.02], rel=1e-12)


@pytest.mark.parametrize("step", [0.02, 0.1, 0.05, 0.07, 1 / 30, 1e-3])
def test_a_later_end_does_not_move_earlier_times(step):
    """Or else a run that is extended differs from one that was as long from the start."""
    long, *_ = walk(StepGrid(step, 40 * step))
    for n in range(1, 40):
        end = float(f"{n * step:.6g}")  # as one would write it, such as 0.3 and not 3 * 0.1
        if abs(end - n * step) > 1e-15:
            continue
        times, *_ = walk(StepGrid(step, end))
        assert np.array_equal(times, long[: n + 1]), end


def test_the_last_cell_is_shortened_and_may_be_halved():
    times, sizes, _ = walk(StepGrid(0.02, 0.05), refine_at=[0.04])
    assert times == pytest.approx([0.0, 0.02, 0.04, 0.045, 0.05], rel=1e-15)
    assert times[-1] == 0.05
    assert sizes == pytest.approx([0.02, 0.02, 0.005, 0.005], rel=1e-12)


def test_halved_steps_grow_back_step_by_step():
    times, sizes, levels = walk(StepGrid(1.0, 3.0), refine_at=[1.0] * 3)
    assert levels == [0, 3, 2, 1, 0] or levels == [0, 3, 3, 2, 1, 0]
    assert np.array_equal(np.diff(times), sizes)  # binary fractions: exact
    assert times[-2] == 2.0  # back on the grid of full steps as soon as possible


def test_a_step_grows_only_where_it_fits_the_grid():
    """Each step begins at a multiple of its length."""
    grid = StepGrid(1.0, 8.0)
    random = np.random.default_rng(3)
    while not grid.done:
        for _ in range(random.integers(0, 3)):
            grid.refine()
        assert grid.time % grid.dt == 0.0
        assert grid.target == grid.time + grid.dt
        grid.advance(grow=bool(random.integers(0, 2)))


def test_steps_that_must_not_grow_do_not():
    grid = StepGrid(1.0, 2.0)
    grid.refine()
    grid.refine()
    sizes = []
    while not grid.done:
        sizes.append(grid.dt)
        grid.advance(grow=False)
    assert sizes == [0.25] * 8


def test_full_steps_do_not_grow():
    grid = StepGrid(0.5, 2.0)
    for _ in range(3):
        grid.advance(grow=True)
        assert grid.dt == 0.5


def test_the_smallest_step_cannot_be_halved():
    grid = StepGrid(1.0, 2.0, deepest=3)
    assert [grid.refine() for _ in range(4)] == [True, True, True, False]
    assert grid.dt == 1.0 / 8.0


def test_every_multiple_of_dt_is_met_exactly_however_steps_are_halved():
    random = np.random.default_rng(7)
    refine_at = sorted(random.uniform(0.0, 2.0, 40))
    times, *_ = walk(StepGrid(0.02, 2.0), refine_at)
    assert np.isin(0.02 * np.arange(101), times).all()
    assert len(times) > 141  # and they were halved
    assert np.all(np.diff(times) > 0.0)


def test_a_grid_goes_on_from_its_position_bit_for_bit():
    random = np.random.default_rng(11)
    grid = StepGrid(0.07, 1.0, deepest=4, origin=0.013)
    while not grid.done:
        if random.uniform() < 0.6:
            grid.refine()
        again = StepGrid(0.07, 1.0, 4, grid.cell, grid.ticks, grid.level, grid.origin)
        assert (again.time, again.dt, again.target) == (grid.time, grid.dt, grid.target)
        grid.advance()


def test_an_origin_shifts_all_times():
    times, sizes, _ = walk(StepGrid(0.02, 0.1, origin=0.05))
    assert times == pytest.approx([0.05, 0.07, 0.09, 0.1], rel=1e-15)
    assert times[0] == 0.05 and times[-1] == 0.1
    assert sizes == pytest.approx([0.02, 0.02, 0.01], rel=1e-12)


@pytest.mark.parametrize("origin", [0.0, 0.3])
def test_a_grid_that_ends_where_it_begins_or_before_is_done(origin):
    assert StepGrid(0.02, origin, origin=origin).done
    assert StepGrid(0.02, max(origin - 0.1, 0.0), origin=origin).done

"""Cycles are those of ASTM E1049 and of py-fatigue; matrices and corrected means keep damage."""

import csv

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.cycles import (
    CELLS,
    Cycles,
    correct_means,
    count_cycles,
    equivalent_range,
    format_markov,
    join_cycles,
)

# ASTM E1049-85, figure 6 and the table of its rainflow count
STANDARD = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
COUNTS = {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}

ULTIMATE = 2000.0
# py-fatigue 2.1.1: sums of n S^4, and of n S^10 after Goodman's correction to zero mean, of walks
# np.cumsum(default_rng(seed).integers(-9, 10, 2000)) for the seeds 0 to 19
PY_FATIGUE = [
    (51517714214.5, 5.913970321875032e27),
    (37935497008.5, 2.2055326807320426e27),
    (3944396656.0, 6.309522359588145e23),
    (42182065973.0, 2.951182251476688e27),
    (7634615150.5, 8.198954602031237e24),
    (9816479523.5, 4.267941857917708e25),
    (4446244487.0, 1.497003632729064e24),
    (6183269992.5, 1.3111418728484777e25),
    (4484951714.0, 1.249480736183289e24),
    (4398209842.0, 1.8190871095011673e24),
    (9324388983.0, 1.2956688972673114e25),
    (18870946632.5, 2.2649911372073115e26),
    (30589822956.0, 1.1528799255538512e27),
    (31236145182.0, 4.1924966459832276e26),
    (10557770174.0, 1.0312363803479688e25),
    (13626981609.0, 4.448835617693909e25),
    (12723663125.0, 2.738680357881505e25),
    (8573901606.5, 1.6675196578832175e25),
    (9160361859.5, 7.241986413993537e24),
    (134261659558.5, 1.0399397063402179e29),
]


def add_up(cycles):
    return {
        size: float(cycles.counts[cycles.ranges == size].sum()) for size in np.unique(cycles.ranges)
    }


def walk(seed):
    return np.cumsum(np.random.default_rng(seed).integers(-9, 10, 2000)).astype(float)


def test_count_of_the_standard():
    assert add_up(count_cycles(np.array(STANDARD, dtype=float))) == COUNTS


def test_points_between_the_turning_points_do_not_count():
    dense = np.interp(np.linspace(0, 8, 801), np.arange(9), STANDARD)
    assert add_up(count_cycles(dense)) == COUNTS


def test_equivalent_range_of_the_standard():
    cycles = count_cycles(np.array(STANDARD, dtype=float))
    damage = sum(n * size**3 for size, n in COUNTS.items())
    assert equivalent_range(cycles, 3.0, 2.0) == pytest.approx((damage / 2.0) ** (1 / 3))


def test_damages_of_random_walks_are_those_of_another_library():
    for seed, (plain, corrected) in enumerate(PY_FATIGUE):
        cycles = count_cycles(walk(seed))
        assert cycles.counts @ cycles.ranges**4 == pytest.approx(plain, rel=1e-9)
        zero = correct_means(cycles, ULTIMATE, "x")
        assert zero.counts @ zero.ranges**10 == pytest.approx(corrected, rel=1e-9)
        assert not zero.means.any()


def test_an_ultimate_load_that_is_reached_is_told():
    cycles = Cycles(np.array([2.0]), np.array([-5.0]), np.array([1.0]))
    with pytest.raises(InputError, match=r"load of 'x' is 6: expected more than .* 6"):
        correct_means(cycles, 6.0, "x")


def test_a_matrix_has_all_cycles_in_cells_that_hold_them():
    one, two = count_cycles(walk(0)), count_cycles(walk(1)).weigh(1000.0)
    both = join_cycles([one, two])
    rest = Cycles(np.zeros(0), np.zeros(0), np.zeros(0))
    rows = list(csv.DictReader(format_markov({"x": both, "rests": rest}).splitlines()))
    found = Cycles(*(np.array([float(r[k]) for r in rows]) for k in ("range", "mean", "cycles")))
    assert {row["column"] for row in rows} == {"x"} and len(rows) <= CELLS**2
    assert found.counts.sum() == pytest.approx(one.counts.sum() + two.counts.sum())
    cell = both.ranges.max() / CELLS
    assert found.ranges.max() == pytest.approx(both.ranges.max() - 0.5 * cell)
    assert equivalent_range(found, 4.0, 1.0) == pytest.approx(
        equivalent_range(both, 4.0, 1.0), rel=0.02
    )
    assert found.counts @ found.means == pytest.approx(
        both.counts @ both.means, abs=0.5 * np.ptp(both.means) / CELLS * both.counts.sum()
    )


def test_a_matrix_of_one_cycle_and_of_none():
    one = Cycles(np.array([2.0]), np.array([1.0]), np.array([0.5]))
    (row,) = csv.DictReader(format_markov({"x": one}).splitlines())
    assert (float(row["cycles"]), float(row["mean"])) == (0.5, pytest.approx(1.0, abs=1e-6))
    assert format_markov({}) == ""

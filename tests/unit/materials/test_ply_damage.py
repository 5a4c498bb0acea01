"""Damage of plies: one cell by hand, cycles as others count them, and what is left out."""

from dataclasses import replace
from math import inf

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.ply import Ply, PlyMaterial, Strengths
from turbine_fenicsx.materials.ply_damage import DamageCode
from turbine_fenicsx.materials.ply_fatigue import (
    FatigueTable,
    PlyFatigue,
    find_usual_slope,
)
from turbine_fenicsx.materials.ply_table import PlyTable

STRENGTHS = Strengths((600e6, 40e6, 40e6), (480e6, 110e6, 110e6), (20e6, 20e6, 20e6))
GLASS = PlyMaterial("glass", 1.9e3, (44e9, 17e9, 17e9), (3e9,) * 3, (0.26,) * 3, STRENGTHS)
FATIGUE = PlyFatigue(10.0, STRENGTHS)


@pytest.fixture(scope="module")
def code():
    """The compiled code."""
    return DamageCode(MPI.COMM_SELF)


def tabulate(fatigue=FATIGUE, number=1):
    """Some plies of one material."""
    return FatigueTable(PlyTable([[Ply(GLASS, 1e-3)] * number]), {"glass": fatigue})


def shake(mean, amplitude, cycles, along=0):
    """A sine of one stress, shape (1, 3, m)."""
    stresses = np.zeros((1, 3, 20 * cycles + 1))
    stresses[0, along] = mean + amplitude * np.sin(np.arange(20 * cycles + 1) * np.pi / 10.0)
    return stresses


# N = (min(R_t - M, R_c + M)/A)^m; the first and the last quarter of a sine are halves of cycles
@pytest.mark.parametrize("mean", [100e6, -200e6])
def test_a_sine_does_the_damage_of_the_shifted_goodman_diagram(code, mean):
    cycles, A = 50, 90e6
    found = code.find(tabulate(), shake(mean, A, cycles))
    damage = [
        number * (amplitude / min(600e6 - M, 480e6 + M)) ** 10.0
        for number, amplitude, M in (
            (cycles - 0.5, A, mean),
            (0.5, 0.5 * A, mean + 0.5 * A),
            (0.5, 0.5 * A, mean - 0.5 * A),
        )
    ]
    assert found.damage[0, 0] == pytest.approx(sum(damage), rel=1e-12)
    assert found.cycles[0, 0] == cycles + 0.5
    assert found.range[0, 0] == pytest.approx(2.0 * A)


def test_goodman_reduces_amplitudes_by_means(code):
    fatigue = replace(FATIGUE, diagram="goodman", first=500e6)
    zero, up, down = (fatigue.lives[0].find_cycles(90e6, mean) for mean in (0.0, 300e6, -240e6))
    assert zero == pytest.approx((500 / 90) ** 10.0)
    assert [up, down] == pytest.approx([zero / 2.0**10] * 2)  # half of each strength
    stresses = np.array([[[300e6 - 90e6, 300e6 + 90e6, 300e6 - 90e6], [0.0] * 3, [0.0] * 3]])
    assert code.find(tabulate(fatigue), stresses).damage[0, 0] == pytest.approx(1.0 / up)


def test_partial_factors_multiply_means_and_amplitudes():
    life = replace(FATIGUE, strength_factor=1.5, fatigue_factor=1.2).lives[0]
    assert life.find_cycles(50e6, 100e6) == pytest.approx(FATIGUE.lives[0].find_cycles(60e6, 150e6))


def test_cycles_and_damage_are_those_of_the_library(code):
    rainflow = pytest.importorskip("rainflow")
    noise = np.random.default_rng(1).normal(size=(4, 3, 3000))
    stresses = np.cumsum(noise, axis=2) * np.array([4e6, 3e5, 2e5])[:, None]
    stresses[1] = np.round(stresses[1], -6)  # many that are equal
    found = code.find(tabulate(number=4), stresses)
    for ply, of_ply in enumerate(stresses):
        for k, series in enumerate(of_ply):
            cycles = np.array([c[:3] for c in rainflow.extract_cycles(series.tolist())])
            N = FATIGUE.lives[k].find_cycles(0.5 * cycles[:, 0], cycles[:, 1])
            assert found.cycles[ply, k] == cycles[:, 2].sum()
            assert found.damage[ply, k] == pytest.approx(np.sum(cycles[:, 2] / N), rel=1e-9)
            assert found.range[ply, k] == np.ptp(series)


def test_exertion_is_that_of_tsai_and_hill_with_the_sign_of_what_is_nearest_to_failure(code):
    stresses = np.zeros((1, 3, 3))
    stresses[0, :, 1] = 300e6, 10e6, 8e6
    stresses[0, :, 2] = -240e6, 10e6, 0.0
    e1 = np.sqrt(0.25 - 300.0 * 10.0 / 600.0**2 + 0.25**2 + 0.4**2)
    e2 = np.sqrt(0.25 + 240.0 * 10.0 / 480.0**2 + 0.25**2)
    found = code.find(tabulate(), stresses)
    assert found.range[0, 3] == pytest.approx(e1 + e2)
    life = FATIGUE.lives[3]
    halves = [0.5 / life.find_cycles(0.5 * e1, 0.5 * e1)]
    halves.append(0.5 / life.find_cycles(0.5 * (e1 + e2), 0.5 * (e1 - e2)))
    assert found.damage[0, 3] == pytest.approx(sum(halves))


def test_stresses_without_strengths_do_not_count_but_the_others_do(code):
    strengths = Strengths((600e6, inf, inf), (480e6, inf, inf))
    found = code.find(tabulate(PlyFatigue(10.0, strengths)), 50e6 + shake(0.0, 90e6, 5))
    assert found.cycles[0].tolist() == [5.5, 0.0, 0.0, 5.5]
    assert found.damage[0, [1, 2]].tolist() == [0.0, 0.0]
    other = FatigueTable(tabulate().plies, {})
    assert not code.find(other, shake(0.0, 90e6, 5)).cycles.any()


def test_each_cycle_that_reaches_the_strength_breaks_the_ply(code):
    assert code.find(tabulate(), shake(700e6, 1e6, 3)).damage[0, 0] == 3.5
    assert FATIGUE.lives[0].find_cycles(1e6, 700e6) == 1.0


def test_histories_that_surely_do_less_damage_are_left_out(code):
    stresses = np.concatenate([shake(0.0, A, 20) for A in (20e6, 40e6, 80e6)])
    whole = code.find(tabulate(number=3), stresses)
    least = 5.0 * whole.damage[1, 0]
    some = code.find(tabulate(number=3), stresses, least)
    left_out = some.cycles[:, 0] == -1.0
    assert left_out.tolist() == [True, False, False]  # the bound counts a cycle at two times
    assert np.all(whole.damage[left_out, 0] < least)
    assert np.array_equal(some.damage[~left_out], whole.damage[~left_out])


def test_stresses_that_are_not_finite_are_refused(code):
    stresses = shake(0.0, 1e6, 2)
    stresses[0, 1, 3] = np.nan
    with pytest.raises(ModelError, match="not finite"):
        code.find(tabulate(), stresses)


def test_slopes_of_families():
    carbon = replace(GLASS, young=(130e9, 9e9, 9e9))
    biaxial = replace(GLASS, young=(11e9, 11e9, 16e9))
    foam = replace(GLASS, young=(1e8, 1e8, 1e8), shear=(4e7,) * 3)
    found = [find_usual_slope(x) for x in (GLASS, carbon, biaxial, foam)]
    assert found == [10.0, 14.0, 9.0, None]
    with pytest.raises(ModelError, match="must be positive"):
        PlyFatigue(0.0, STRENGTHS)

"""Claims about turbulence of Kaimal's and Mann's models, over the waves of 20 seeds."""

from itertools import pairwise

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.box_grid import BoxGrid
from turbine_fenicsx.wind.gusts import TurbineClass
from turbine_fenicsx.wind.kaimal import KaimalModel
from turbine_fenicsx.wind.mann_model import LENGTH, SHEAR, MannModel
from turbine_fenicsx.wind.mann_tensor import one_point_spectra, spectral_tensor

SPEED, SIZE, SEEDS = 12.0, 42.0, 20
DEVIATION = TurbineClass("I", "B").normal_deviation(SPEED)
BANDS = (1, 10, 20, 40, 80, 160, 320, 589)
"""Waves along the wind over which means are taken; the first one has more than its share."""


class Boxes:
    """Boxes of all seeds."""

    def __init__(self, model, time_step, width, across):
        self.model = model(SPEED, DEVIATION, SIZE)
        self.grid = BoxGrid.covering(300.0, time_step, SPEED, width, across)
        self.values = [self.model.make(self.grid, seed) for seed in range(SEEDS)]
        self.f = self.grid.waves * SPEED / (2.0 * np.pi)
        n = self.grid.points[0]
        self._waves = [np.fft.rfft(box, axis=0)[1:590] / n for box in self.values]

    def cross_spectrum(self, k, m, shift=0):
        """Means of that of two components, so many points apart across the wind, in bands."""
        found = 0.0
        for waves in self._waves:
            a, b = waves[:, :, : waves.shape[2] - shift, k], waves[:, :, shift:, m]
            found = found + 2.0 * (a * b.conj()).real.mean(axis=(1, 2)) / self.f[0] / SEEDS
        return self.average(found)

    def average(self, values):
        """Means over bands."""
        return np.array([values[a:b].mean() for a, b in pairwise(BANDS)])


@pytest.fixture(scope="module")
def kaimal():
    return Boxes(KaimalModel, 0.1, 60.0, 4)


@pytest.fixture(scope="module")
def mann():
    return Boxes(MannModel, 0.25, 132.0, 12)


@pytest.mark.parametrize(("name", "v", "w"), [("kaimal", 0.8, 0.5), ("mann", 0.7, 0.5)])
def test_standard_deviations_are_those_of_the_standard(name, v, w, request):
    values = request.getfixturevalue(name).values
    found = np.sqrt(np.mean([box.var(axis=(0, 1, 2)) for box in values], axis=0))
    assert found == pytest.approx(DEVIATION * np.array([1.0, v, w]), rel=0.05)
    assert np.abs(np.mean(values, axis=(1, 2, 3))).max() < 1e-5


@pytest.mark.parametrize("name", ["kaimal", "mann"])
def test_spectra_of_all_components_are_those_of_the_model(name, request):
    boxes = request.getfixturevalue(name)
    for k, expected in enumerate(boxes.model.spectra(boxes.f)[:3]):
        found = boxes.cross_spectrum(k, k)
        assert found == pytest.approx(boxes.average(expected), rel=0.05)


def test_kaimals_coherence_is_that_of_the_standard_and_v_and_w_have_none(kaimal):
    power = kaimal.cross_spectrum(0, 0)
    for shift in (1, 2, 3):
        found = kaimal.cross_spectrum(0, 0, shift) / power
        coherence = np.array([kaimal.model.coherence(20.0 * shift, f) for f in kaimal.f])
        S = kaimal.model.spectra(kaimal.f)[0]
        expected = kaimal.average(S * coherence) / kaimal.average(S)
        assert found == pytest.approx(expected, abs=0.05)
    for k in (1, 2):
        found = kaimal.cross_spectrum(k, k, 1) / kaimal.cross_spectrum(k, k)
        assert np.abs(found).max() < 0.1


def test_manns_wind_along_and_upwards_belong_together(mann):
    expected = mann.average(mann.model.spectra(mann.f)[3])
    assert mann.cross_spectrum(0, 2) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("shift", [1, 2, 5])
def test_manns_coherence_is_that_of_the_tensor(mann, shift):
    L, logs = LENGTH * SIZE, np.linspace(-7.0, 9.0, 300)[:, None]
    angles = 2.0 * np.pi * (np.arange(400) + 0.5) / 400
    k2, k3 = np.exp(logs) * np.cos(angles), np.exp(logs) * np.sin(angles)
    found = mann.cross_spectrum(0, 0, shift) / mann.cross_spectrum(0, 0)
    for (a, b), mean in list(zip(pairwise(BANDS), found, strict=True))[1:]:
        k1 = 2.0 * np.pi * np.sqrt(mann.f[a] * mann.f[b - 1]) * L / SPEED
        parts = spectral_tensor(np.full((1, 1), k1), k2, k3, SHEAR)[0] * np.exp(2.0 * logs)
        expected = np.sum(parts * np.cos(k2 * 12.0 * shift / L)) / np.sum(parts)
        assert mean == pytest.approx(expected, abs=0.05)


def test_the_tensor_is_without_divergence_and_isotropic_without_shear():
    k = np.random.default_rng(0).normal(size=(3, 200)) * np.geomspace(0.1, 30.0, 200)
    for shear in (0.0, SHEAR):
        P11, P22, P33, P12, P13, P23 = spectral_tensor(*k, shear)
        Phi = np.array([[P11, P12, P13], [P12, P22, P23], [P13, P23, P33]])
        size = np.linalg.norm(k, axis=0) * np.trace(Phi)
        assert np.abs(np.einsum("in,ijn->jn", k, Phi) / size).max() < 1e-9
    # von Karman's spectrum
    k1 = np.array([0.1, 1.0, 5.0])
    F = one_point_spectra(k1, 0.0)
    assert F[0] == pytest.approx(9.0 / 55.0 * (1.0 + k1**2) ** (-5.0 / 6.0), rel=1e-3)


def test_seeds_give_other_winds_and_the_same_seed_the_same():
    grid = BoxGrid.covering(20.0, 0.5, SPEED, 60.0, 3)
    for model in (KaimalModel, MannModel):
        one, again, other = (model(SPEED, DEVIATION, SIZE).make(grid, s) for s in (1, 1, 2))
        assert np.array_equal(one, again) and np.abs(one - other).max() > 0.1 * DEVIATION
        assert one.shape == (40, 3, 3, 3) and one.dtype == np.float32


def test_a_grid_lasts_as_long_as_asked_and_impossible_ones_are_refused():
    grid = BoxGrid.covering(599.9, 0.2, 10.0, 100.0, 11)
    assert grid.points == (3000, 11, 11) and grid.spacing == pytest.approx((2.0, 10.0, 10.0))
    y, z = grid.sides
    assert y[[0, -1]] == pytest.approx([-50.0, 50.0]) and np.array_equal(y, z)
    for points, spacing, words in [
        ((2, 4, 4), (1.0, 1.0, 1.0), "must be 4, 2 and 2 or more"),
        ((8, 4, 4), (1.0, 0.0, 1.0), "spacing of a turbulence box must be positive"),
        ((10**7, 64, 64), (1.0, 1.0, 1.0), "GiB is too large, at most 1: take fewer points"),
    ]:
        with pytest.raises(ModelError, match=words):
            BoxGrid(points, spacing)

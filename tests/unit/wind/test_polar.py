"""Claims about polars and their tables."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.aero_blade import AeroBlade
from turbine_fenicsx.wind.polar import Polar, PolarTable

ANGLES = np.radians([-180.0, -90.0, 0.0, 10.0, 90.0, 180.0])


def polar(name="p", angle=ANGLES, scale=1.0, **change):
    lift = scale * np.interp(angle, ANGLES, [0.0, -1.0, 0.2, 1.1, 1.0, 0.0])
    drag = np.interp(angle, ANGLES, [0.02, 1.3, 0.01, 0.02, 1.3, 0.02])
    values = {"lift": lift, "drag": drag, "moment": 0.0 * lift, **change}
    return Polar(name, angle, **values)


def test_between_angles_coefficients_are_linear_and_angles_count_by_the_circle():
    table = PolarTable([polar()])
    for turns in (0, 1, -2):
        found = table(np.radians([4.0 + 360.0 * turns]))
        assert found.lift[0] == pytest.approx(0.2 + 0.4 * 0.9, rel=1e-12)
        assert found.drag[0] == pytest.approx(0.014, rel=1e-12)


def test_polars_with_different_angles_keep_their_values_in_one_table():
    fine = polar("fine", np.sort(np.append(ANGLES, np.radians([3.0, 47.0]))), scale=0.5)
    table = PolarTable([polar(), fine, polar()])
    angles = np.random.default_rng(1).uniform(-np.pi, np.pi, (40, 3))
    found = table(angles)
    for k, one in enumerate((polar(), fine, polar())):
        assert found.lift[:, k] == pytest.approx(one.coefficients(angles[:, k])[0], abs=1e-14)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: polar(angle=ANGLES[1:]), "'p' must go from -180 to 180 degrees, got -90 to 180"),
        (lambda: polar(angle=ANGLES[::-1]), "angles of polar 'p' must rise"),
        (lambda: polar(lift=np.arange(6.0)), "lift of polar 'p' must be the same at -180 and 180"),
        (lambda: polar(drag=np.full(6, np.nan)), "'p' has values of drag that are not finite"),
        (lambda: polar(lift=np.full(6, -1e40)), "lift of polar 'p' reaches 1e\\+40, more than 100"),
        (lambda: polar(moment=np.zeros(3)), r"has 6 angles and values of moment of shape \(3,\)"),
    ],
)
def test_tables_that_are_no_polars_are_refused(make, words):
    with pytest.raises(ModelError, match=words):
        make()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"radius": np.array([1.0, 5.0])}, "stations .* must lie between 2 and 10 m, got 1 to 5"),
        ({"radius": np.array([5.0, 5.0])}, "two or more stations with rising radius"),
        ({"chord": np.array([1.0, 0.0])}, "chords must be positive, got 0 m at 9 m"),
        (
            {"chord": np.array([1.0, 11.0])},
            "chord of .* reaches 11 m, more than its tip radius of 10",
        ),
        ({"prebend": np.array([0.0, -1e20])}, "prebend of an aerodynamic blade reaches 1e.20 m"),
        ({"twist": np.array([1.0])}, "twist of an aerodynamic blade must be 2 finite numbers"),
        ({"polars": (polar(),)}, "a polar for each of its 2 stations, got 1"),
        ({"hub_radius": 12.0}, "must end outside its hub, got radii of 12 and 10 m"),
    ],
)
def test_blades_that_cannot_be_are_refused(change, words):
    two = {"radius": np.array([3.0, 9.0]), "chord": np.ones(2), "twist": np.zeros(2)}
    given = {"hub_radius": 2.0, "tip_radius": 10.0, "polars": (polar(), polar()), **two, **change}
    with pytest.raises(ModelError, match=words):
        AeroBlade(**given)

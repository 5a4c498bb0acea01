"""Claims about the wind near a tower: a flow without sources around it, and a wake behind it."""

import numpy as np
import pytest
from turning_rotors import aerodynamics, plain_blade, turning

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.wind.tower_shadow import TowerShadow

BASE, TOP, HEIGHTS, RADII = (0.0, 0.0, 0.0), (0.0, 0.0, 100.0), (0.0, 100.0), (4.0, 2.0)
TOWER = TowerShadow(BASE, TOP, HEIGHTS, RADII)
V = 10.0


def at(*places, tower=TOWER, wind=(V, 0.0, 0.0)):
    p = np.array(places, dtype=float)
    return tower.disturb(np.tile(np.asarray(wind, dtype=float), (len(p), 1)), p)


def test_wind_stops_before_the_tower_and_is_twice_as_fast_beside_it():
    # the radius is 3 m at half the height
    before, beside, behind = at((-3.0, 0.0, 50.0), (0.0, 3.0, 50.0), (3.0, 0.0, 50.0))
    assert before == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert beside == pytest.approx([2.0 * V, 0.0, 0.0], abs=1e-12)
    assert behind == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_on_its_surface_the_wind_blows_along_the_tower():
    angles = np.linspace(0.1, 6.2, 30)
    places = [(3.0 * np.cos(a), 3.0 * np.sin(a), 50.0) for a in angles]
    through = np.sum(at(*places) * np.array(places), axis=1)
    assert through == pytest.approx(np.full(30, through[0]), abs=1e-10)
    assert np.max(np.abs(through)) < 1e-10


def test_the_flow_around_it_has_neither_sources_nor_vortices():
    # at one height of a tower that is no cone
    tower = TowerShadow(BASE, TOP, (0.0,), (3.0,))
    h, p = 1e-4, np.array([-5.0, 2.5, 40.0])
    dx, dy = np.array([h, 0, 0]), np.array([0, h, 0])
    W, E, S, N = at(p - dx, p + dx, p - dy, p + dy, tower=tower)
    assert (E - W)[0] + (N - S)[1] == pytest.approx(0.0, abs=1e-8)
    assert (E - W)[1] - (N - S)[0] == pytest.approx(0.0, abs=1e-8)


def test_upwind_on_the_axis_wind_lacks_the_square_of_radius_over_distance():
    found = at((-12.0, 0.0, 50.0))[0]
    assert found[0] == pytest.approx(V * (1.0 - (3.0 / 12.0) ** 2), rel=1e-13)


def test_powles_wake_is_as_deep_and_as_wide_as_published():
    wake = TowerShadow(BASE, TOP, (0.0,), (2.0,), potential=False, drag=0.6)
    # 8 m behind are 4 radii: the wake is 2 radii wide to each side and takes 0.6/2 of the wind
    found = at((8.0, 0, 50), (8.0, 2.0, 50), (8.0, 5.0, 50), (-8.0, 0, 50), tower=wake)[:, 0] / V
    assert found[[0, 2, 3]] == pytest.approx([0.7, 1.0, 1.0], rel=1e-13)
    r = np.hypot(4.0, 1.0)
    depth = 0.6 / np.sqrt(r) * np.cos(0.5 * np.pi / np.sqrt(r)) ** 2
    assert found[1] == pytest.approx(1.0 - depth, rel=1e-13)
    deep = TowerShadow(BASE, TOP, (0.0,), (2.0,), potential=False, drag=1.5)
    assert at((2.1, 0.0, 50.0), tower=deep)[0, 0] == pytest.approx(0.5 * V)


def test_it_fades_within_one_radius_above_the_top():
    full, half, none = at((-6.0, 0, 100.0), (-6.0, 0, 101.0), (-6.0, 0, 102.0))[:, 0]
    assert full == pytest.approx(V * (1.0 - 1.0 / 9.0))
    assert half == pytest.approx(V * (1.0 - 0.5 / 9.0))
    assert none == V


def test_in_turned_axes_it_is_the_same_tower():
    turn = rotation_about((1.0, 2.0, 3.0), 0.7)
    tower = TowerShadow(turn @ BASE, turn @ TOP, HEIGHTS, RADII, drag=0.4)
    plain = TowerShadow(BASE, TOP, HEIGHTS, RADII, drag=0.4)
    places, wind = np.array([(7.0, 1.0, 30.0), (-5.0, 3.0, 70.0)]), np.array([6.0, 3.0, 1.0])
    found = at(*places @ turn.T, tower=tower, wind=turn @ wind)
    assert found == pytest.approx(at(*places, tower=plain, wind=wind) @ turn.T, rel=1e-12)


def test_inside_of_the_tower_and_in_no_wind_numbers_stay_finite():
    assert np.all(np.isfinite(at((0.0, 0.0, 50.0), (0.1, 0.1, 50.0))))
    assert not np.any(at((5.0, 0.0, 50.0), wind=(0.0, 0.0, 0.0)))


def test_a_blade_that_passes_the_tower_feels_less_wind():
    # the tower stands 6 m downwind of a rotor whose blades point down at half a turn
    tower = TowerShadow((6.0, 0, 0), (6.0, 0, 145.0), (0.0, 145.0), (3.0, 2.0))
    blade = plain_blade()
    source, free = aerodynamics(blade, tower=tower), aerodynamics(blade)
    for azimuth, least, most in ((0.5 * np.pi, 0.98, 1.02), (np.pi, 0.8, 0.97)):
        time = azimuth / 0.75
        found, expected = (
            each.loads(turning(blade, time), time)[0][:20] for each in (source, free)
        )
        assert least < np.sum(found[:, 0]) / np.sum(expected[:, 0]) < most


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"top": BASE}, "base and top of the tower must be two points"),
        ({"radii": (3.0, 0.0)}, "radii of the tower must be positive, got 0 m"),
        ({"radii": (3.0,)}, "radii of the tower must be 2 numbers, one for each height"),
        ({"heights": (5.0, 5.0)}, "heights of the tower must rise"),
        ({"drag": -0.1}, "drag of the tower must not be negative"),
        ({"base": (0.0, np.nan, 0.0)}, "base of the tower must be three numbers"),
    ],
)
def test_towers_that_cannot_be_are_refused(change, words):
    given = {"base": BASE, "top": TOP, "heights": HEIGHTS, "radii": RADII}
    with pytest.raises(ModelError, match=words):
        TowerShadow(**{**given, **change})

"""Claims about dynamic stall: Kirchhoff's flow, a delay in closed form, loops around the polar."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from rosco_blades import iea_blade
from turning_rotors import ANGLES, DT, TURN, aerodynamics, line_loads, plain_blade, run, turning

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.polar import Polar, PolarTable
from turbine_fenicsx.wind.stall import OeyeStall, separate, tabulate_separation

F_ST = np.clip((np.radians(25.0) - np.abs(ANGLES)) / np.radians(15.0), 0.0, 1.0)
INVISCID = 2.0 * np.pi * np.sin(ANGLES)
STILL = {"wind": SteadyWind(0.0), "unsteady": False}
NEAR = np.abs(ANGLES) < np.radians(29.0)


def kirchhoff():
    """A polar that sepaomega between 10 and 25 degrees."""
    lift = INVISCID * (0.5 + 0.5 * np.sqrt(F_ST)) ** 2
    return Polar("k", ANGLES, lift, 0.01 + 0.0 * ANGLES, 0.0 * ANGLES)


def stalling_blade():
    return replace(plain_blade(), polars=(kirchhoff(),) * 20, twist=np.zeros(20))


def test_the_attached_part_is_that_which_made_the_polar():
    f, difference = separate(ANGLES, kirchhoff().lift)
    assert f[NEAR] == pytest.approx(F_ST[NEAR], abs=1e-12)
    # C_l = f C_l,inv + (1 - f) C_l,sep holds for the polar
    separated = INVISCID - difference
    balance = f * INVISCID + (1.0 - f) * separated
    assert balance[NEAR] == pytest.approx(kirchhoff().lift[NEAR], abs=1e-12)


def test_camber_moves_the_angle_without_lift():
    shifted = np.interp(ANGLES + np.radians(3.0), ANGLES, kirchhoff().lift, period=2.0 * np.pi)
    f, _ = separate(ANGLES, shifted)
    expected = np.interp(ANGLES + np.radians(3.0), ANGLES, F_ST)
    near = np.abs(ANGLES) < np.radians(20.0)
    assert f[near] == pytest.approx(expected[near], abs=1e-9)


def test_what_has_no_lift_has_no_stall_and_far_angles_have_no_delay():
    f, difference = separate(ANGLES, np.full(361, 1e-4))
    assert np.all(f == 1.0) and not np.any(difference)
    _, difference = separate(ANGLES, kirchhoff().lift)
    assert not np.any(difference[np.abs(ANGLES) > np.radians(61.0)])


@pytest.mark.parametrize("station", [12, 25, 45])
def test_for_polars_of_real_aerofoils_the_parts_lie_between_0_and_1(station):
    table = PolarTable([iea_blade().polars[station]])
    f, difference = separate(table.angles, table.values[0, :, 0])
    assert f.min() == 0.0 and f.max() > 0.99
    attached = np.abs(table.angles - np.radians(2.0)) < np.radians(5.0)
    assert np.all(f[attached] > 0.7)
    assert np.all(difference[attached & (table.angles > 0.0)] >= 0.0)
    *coefficients, f_found, _ = tabulate_separation(table)(np.radians([5.0]))[0]
    assert f_found == pytest.approx(np.interp(np.radians(5.0), table.angles, f))
    assert coefficients == pytest.approx(np.ravel(table(np.radians([5.0]))))


def test_the_attached_part_follows_in_closed_form_whatever_the_steps():
    stall, c, W = OeyeStall(), np.array([2.0, 3.0]), np.array([40.0, 60.0])
    f_0, f_st = np.array([1.0, 0.2]), np.array([0.3, 0.9])
    expected = f_st + (f_0 - f_st) * np.exp(-0.5 * W / (4.0 * c))
    f = f_0
    for _ in range(7):
        f = stall.follow(f, f_st, 0.5 / 7.0, c, W)
    assert f == pytest.approx(expected, rel=1e-13)
    assert np.array_equal(stall.follow(f_0, f_st, np.inf, c, 0.0 * W), f_st)


def test_after_a_step_lift_comes_to_the_polar_with_four_chords_over_the_speed():
    # no wind, and blades that flap downwind at once, to negative angles of attack: so no wake
    blade, flap = stalling_blade(), 5.0
    source = aerodynamics(blade, stall=OeyeStall(), **STILL)
    static = aerodynamics(blade, **STILL)
    run(source, blade, 2)
    gaps = []
    for k in range(2, 6):
        times = StepTimes.from_start(k * DT, DT)
        motion = turning(blade, times.middle, flap=flap)
        source.start_step(times)
        normal, _ = line_loads(source, blade, source.loads(motion, 0.0)[0], times.middle)
        polar, _ = line_loads(source, blade, static.loads(motion, 0.0)[0], times.middle)
        gaps.append(normal - polar)
        source.accept(motion, times)
    W = np.hypot(TURN * blade.radius, flap)
    stalled = np.abs(gaps[0]) > 1.0
    assert 3 < np.sum(stalled) < 15
    decay = np.exp(-DT * W / (4.0 * blade.chord))[stalled]
    for before, after in pairwise(gaps):
        assert after[stalled] / before[stalled] == pytest.approx(decay, rel=1e-8)


def test_in_a_step_lift_is_that_of_its_middle():
    blade = stalling_blade()
    source, static = (aerodynamics(blade, stall=stall, **STILL) for stall in (OeyeStall(), None))
    run(source, blade, 2)
    motion = turning(blade, 0.0, flap=5.0)
    polar = static.loads(motion, 0.0)[0]
    gaps = []
    for dt in (1e-9, DT):
        source.start_step(StepTimes.from_start(2 * DT, dt))
        gaps.append((source.loads(motion, 0.0)[0] - polar)[:20, 0])
    stalled = np.abs(gaps[0]) > 1.0
    W = np.hypot(TURN * blade.radius, 5.0)
    expected = np.exp(-0.5 * DT * W / (4.0 * blade.chord))
    assert (gaps[1] / gaps[0])[stalled] == pytest.approx(expected[stalled], rel=1e-7)


def test_lift_lags_behind_an_angle_that_goes_up_and_down():
    # where it rises there is more of it than the polar has, where it falls less; negative angles,
    # by blades that flap downwind, make no wake
    blade = stalling_blade()
    source = aerodynamics(blade, stall=OeyeStall(), **STILL)
    static = aerodynamics(blade, **STILL)
    station, omega = 10, np.pi / 4.0
    run(static, blade, 1, flap=5.0)  # else each call looks for a balance
    over = {True: [], False: []}
    for k in range(320):
        times = StepTimes.from_start(k * DT, DT)
        t = times.middle
        angle = np.radians(16.0 - 4.0 * np.cos(omega * t))
        flap = TURN * blade.radius[station] * np.tan(angle)
        motion = turning(blade, t, flap=flap)
        source.start_step(times)
        normal, _ = line_loads(source, blade, source.loads(motion, t)[0], t)
        polar, _ = line_loads(source, blade, static.loads(motion, t)[0], t)
        source.accept(motion, times)
        rate = np.sin(omega * t)
        if k > 80 and abs(rate) > 0.7:
            over[bool(rate > 0.0)].append((polar - normal)[station])
    assert min(over[True]) > 0.0 > max(over[False])


def test_where_nothing_changes_lift_is_that_of_the_polar():
    blade = stalling_blade()
    source, static = aerodynamics(blade, stall=OeyeStall()), aerodynamics(blade)
    for each in (source, static):
        run(each, blade, 5)
    found, expected = (each.loads(turning(blade, 0.0), 0.0)[0] for each in (source, static))
    assert found == pytest.approx(expected, abs=1e-12 * np.max(np.abs(expected)))


def test_a_delay_that_is_not_positive_is_refused():
    with pytest.raises(ModelError, match="lag of the stall must be positive"):
        OeyeStall(0.0)

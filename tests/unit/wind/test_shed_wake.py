"""Claims about shed vorticity: Theodorsen's function, half of the lift at first, turned forces."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import hankel2
from turning_rotors import ANGLES, DT, TURN, aerodynamics, frames, plain_blade, run, turning

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.polar import Polar
from turbine_fenicsx.wind.shed_wake import RATES, SHARES

STILL = {"wind": SteadyWind(0.0), "induction": False}
CHORD = 2.0


def theodorsen(k):
    return hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k))


def plates():
    """Plates of 2 m without twist, drag and moment."""
    polar = Polar("plate", ANGLES, plain_blade().polars[0].lift, 0.0 * ANGLES, 0.0 * ANGLES)
    return replace(
        plain_blade(), polars=(polar,) * 20, twist=np.zeros(20), chord=np.full(20, CHORD)
    )


def step(source, blade, k, flap, dt=DT):
    """Forces of a step along normal and way of the first blade [N]; the step is accepted."""
    times, n = StepTimes.from_start(k * dt, dt), len(blade.radius)
    motion = turning(blade, 0.0, flap=flap)
    source.start_step(times)
    force = source.loads(motion, 0.0)[0][:n]
    source.accept(motion, times)
    return force @ frames()[0, 2], force @ frames()[0, 1]


def test_the_terms_are_theodorsens_function():
    k = np.geomspace(0.02, 0.5, 50)
    found = 1.0 - np.sum(SHARES * 1j * k[:, None] / (1j * k[:, None] + RATES), axis=1)
    assert np.max(np.abs(found / theodorsen(k) - 1.0)) < 4.5e-3
    # at once there is half of the lift
    assert np.sum(SHARES) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize("omega", [1.0, 2.2])
def test_sections_that_heave_have_the_lift_of_theodorsen(omega):
    blade, dt, n = plates(), 2.0 * np.pi / omega / 160.0, 160
    amplitudes = []
    for unsteady in (True, False):
        source, found = aerodynamics(blade, unsteady=unsteady, **STILL), 0.0
        for step_number in range(7 * n):
            swing = np.exp(1j * omega * (step_number + 0.5) * dt)
            normal, _ = step(source, blade, step_number, 0.01 * swing.real, dt)
            if step_number >= 6 * n:  # the last cycle
                found = found + normal * np.conj(swing) / n
        amplitudes.append(found)
    k = omega * CHORD / (2.0 * TURN * blade.radius)
    assert k.min() < 0.05 and k.max() > 0.2
    seen = k <= 0.5
    assert np.max(np.abs(amplitudes[0] / amplitudes[1] / theodorsen(k) - 1.0)[seen]) < 0.01


def test_after_a_sudden_change_half_of_the_lift_is_there_and_the_rest_follows_in_closed_form():
    blade, flap = plates(), 0.2
    source, other = aerodynamics(blade, **STILL), aerodynamics(blade, unsteady=False, **STILL)
    run(source, blade, 2)
    gaps = [
        step(source, blade, k, flap)[0] / step(other, blade, k, flap)[0] - 1.0 for k in range(2, 30)
    ]
    passed = (np.arange(28)[:, None] + 0.5) * DT * 2.0 * np.hypot(TURN * blade.radius, flap) / CHORD
    expected = -np.exp(-passed[:, :, None] * RATES) @ SHARES
    assert np.array(gaps) == pytest.approx(expected, abs=2e-3)


def test_lift_stands_across_the_flow_with_the_induced_velocity():
    # at once, half of the velocity up remains: forces turn back by half of the angle
    blade, flap = plates(), 2.0
    source = aerodynamics(blade, **STILL)
    run(source, blade, 2)
    normal, along = step(source, blade, 2, flap, dt=1e-9)
    half_of_angle = -0.5 * flap / (TURN * blade.radius)
    assert along / normal == pytest.approx(half_of_angle, rel=1e-3)


@pytest.mark.parametrize("kind", ["cylinder", "deep stall"])
def test_cylinders_and_sections_in_deep_stall_follow_at_once(kind):
    blade, pitch = plates(), 0.0
    if kind == "cylinder":
        polar = Polar("c", ANGLES, 0.0 * ANGLES, 0.5 + 0.0 * ANGLES, 0.0 * ANGLES)
        blade = replace(blade, polars=(polar,) * 20)
    else:
        pitch = np.radians(65.0)
    forces = []
    for unsteady in (True, False):
        source = aerodynamics(blade, unsteady=unsteady, **STILL)
        run(source, blade, 2, pitch=pitch)
        source.start_step(StepTimes.from_start(2 * DT, DT))
        forces.append(source.loads(turning(blade, 0.0, pitch=pitch, flap=0.1), 0.0)[0])
    assert np.max(np.abs(forces[0] - forces[1])) < 1e-12 * np.max(np.abs(forces[1]))


def test_where_nothing_changes_lift_is_that_of_the_polar():
    blade = plain_blade()
    source, other = aerodynamics(blade), aerodynamics(blade, unsteady=False)
    for each in (source, other):
        run(each, blade, 5)
    found, expected = (each.loads(turning(blade, 0.0), 0.0)[0] for each in (source, other))
    assert found == pytest.approx(expected, abs=1e-12 * np.max(np.abs(expected)))

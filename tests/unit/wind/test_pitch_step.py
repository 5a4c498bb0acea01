"""A sudden step of pitch: at once the wake is that of before, at last that of the new pitch.

The measurements of the Tjaereborg turbine (case II.4 of the Joint Investigation of Dynamic Inflow
Effects: 8.7 m/s, from 0.07 to 3.7 degrees and back) are published as curves alone; the two ends of
what they show, which theory gives in numbers, are tested here.
"""

from dataclasses import replace

import numpy as np
import pytest
from rosco_blades import nrel_blade
from turning_rotors import DT, SHAFT, TURN, aerodynamics, run, turning

from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_section_loads

STEP, SPEED = np.radians(3.7), 6.5


def line_loads_with_frozen_wake(blade, pitch):
    """Blade elements at a pitch in the wake of zero pitch, along and about the shaft [N/m]."""
    steady = find_section_loads(Rotor(blade), Operation(SPEED, TURN), np.zeros(1)).induction
    V_x, V_y = (1.0 - steady.axial[0]) * SPEED, (1.0 + steady.tangential[0]) * TURN * blade.radius
    C = blade.table(np.arctan2(V_x, V_y) - blade.twist - pitch)
    q_c = 0.5 * 1.225 * np.hypot(V_x, V_y) * blade.chord
    return q_c * (C.lift * V_y + C.drag * V_x), q_c * (C.lift * V_x - C.drag * V_y)


def thrust_and_torque(source, blade, pitch):
    motion = turning(blade, 0.0, pitch=-pitch)  # towards feather
    force, _ = source.loads(motion, 0.0)
    torque = np.sum(np.cross(motion.position - [0.0, 0.0, 150.0], force) @ SHAFT)
    return np.array([np.sum(force @ SHAFT), torque])


@pytest.fixture(scope="module")
def history():
    """Thrust and torque before the step, at once, and after each step until nothing changes."""
    blade = replace(nrel_blade(), prebend=None, reference=0.25)
    source = aerodynamics(blade, wind=SteadyWind(SPEED), unsteady=False)
    run(source, blade, 3)
    found = [thrust_and_torque(source, blade, 0.0), thrust_and_torque(source, blade, STEP)]
    for k in range(200):
        run(source, blade, 1, first=3 + k, dt=2 * DT, pitch=-STEP)
        found.append(thrust_and_torque(source, blade, STEP))
    run(source, blade, 400, dt=0.5, pitch=-STEP)
    found.append(thrust_and_torque(source, blade, STEP))
    back = thrust_and_torque(source, blade, 0.0)
    return blade, source._lengths[: len(blade.radius)], np.array(found), back


def test_at_once_loads_are_those_of_the_new_pitch_in_the_wake_of_the_old(history):
    blade, lengths, found, _ = history
    normal, way = line_loads_with_frozen_wake(blade, STEP)
    expected = [3.0 * np.sum(lengths * normal), 3.0 * np.sum(lengths * way * blade.radius)]
    assert found[1] == pytest.approx(expected, rel=1e-9)


def test_at_last_loads_are_those_of_the_steady_rotor(history):
    blade, lengths, found, _ = history
    steady = find_section_loads(Rotor(blade), Operation(SPEED, TURN, STEP), np.zeros(1))
    expected = [
        3.0 * np.sum(lengths * steady.normal[0]),
        3.0 * np.sum(lengths * steady.tangential[0] * blade.radius),
    ]
    assert found[-1] == pytest.approx(expected, rel=1e-6)


def test_loads_overshoot_and_come_back_in_the_time_that_the_wake_takes(history):
    _, _, found, back = history
    before, at_once, last = found[0], found[1], found[-1]
    overshoot = (at_once - before) / (last - before)
    assert overshoot == pytest.approx([1.58, 3.06], rel=0.01)
    # and to the other side when the blades turn back
    assert np.all(back > before)
    # the larger time constant is 1.1/(1 - 1.3 a) R/V, some eight seconds here
    gap = np.abs(found[1:, 0] - last[0])
    half = 2 * DT * np.argmax(gap < 0.5 * gap[0])
    assert 1.0 < half < 8.0

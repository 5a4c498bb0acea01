"""Claims about the air in continuous time: steps follow its rates, and balance has none."""

from dataclasses import replace

import numpy as np
from turning_rotors import ANGLES, CENTRE, SHAFT, TURN, aerodynamics, plain_blade, turning

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.load_states import StateLoad, WithoutStates, find_states
from turbine_fenicsx.forces.section_loads import LineLoad
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.wind.polar import Polar
from turbine_fenicsx.wind.stall import OeyeStall
from turbine_fenicsx.wind.turning_start import TurningAtRest


def rotor(**options):
    """A rotor with all states, whose inner sections separate."""
    lift = 2.0 * np.pi * np.sin(ANGLES) * np.cos(ANGLES) ** 8
    polar = Polar("p", ANGLES, lift, 0.01 + np.sin(ANGLES) ** 2, 0.0 * ANGLES)
    blade = replace(plain_blade(), polars=(polar,) * 20)
    return blade, aerodynamics(blade, stall=OeyeStall(), **options)


def flapping(blade, time):
    """Motion of blades that flap up and down at 0.7 Hz, by velocities alone."""
    return turning(blade, time, flap=3.0 * np.sin(2.0 * np.pi * 0.7 * time))


def test_in_balance_nothing_changes_and_loads_are_those_of_a_first_step():
    blade, air = rotor()
    assert isinstance(air, StateLoad)
    still = turning(blade, 0.0)
    states = air.balance(still, 0.0)
    assert states.shape == (60, len(air.state_models)) == (60, 8)
    found = air.respond(still, 0.0, states)
    expected = air.loads(still, 0.0)
    assert np.array_equal(found.force, expected[0]) and np.array_equal(found.moment, expected[1])
    # the largest rates are those of states that would follow within a second
    assert np.max(np.abs(found.rates)) < 1e-6 * np.max(np.abs(states))


def test_steps_follow_the_rates_to_second_order():
    end, errors = 0.6, []
    blade, air = rotor()
    state, h = air.balance(flapping(blade, 0.0), 0.0), 0.005

    def rate(t, x):
        return air.respond(flapping(blade, t), 0.0, x).rates

    start = state.copy()
    for k in range(round(end / h)):
        t = k * h
        k1 = rate(t, state)
        k2 = rate(t + 0.5 * h, state + 0.5 * h * k1)
        k3 = rate(t + 0.5 * h, state + 0.5 * h * k2)
        k4 = rate(t + h, state + h * k3)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    moved = np.max(np.abs(state - start), axis=0)
    for dt in (0.02, 0.01):
        _, stepping = rotor()
        stepping.accept(flapping(blade, 0.0), StepTimes.from_start(-1e-9, 1e-9))
        for k in range(round(end / dt)):
            times = StepTimes.from_start(k * dt, dt)
            stepping.start_step(times)
            stepping.accept(flapping(blade, times.middle), times)
        errors.append(np.max(np.abs(stepping.read_states() - state), axis=0) / moved)
    # the wake's derivative of w_qs is one of first order
    assert np.all(errors[1][:4] < 0.6 * errors[0][:4])
    assert np.all(errors[1][4:] < 0.35 * errors[0][4:])


def test_models_that_are_left_out_have_no_states():
    blade, air = rotor(unsteady=False, induction=False)
    assert air.state_models == ("stall",)
    still = turning(blade, 0.0)
    assert air.respond(still, 0.0, air.balance(still, 0.0)).rates.shape == (60, 1)


def test_a_source_that_knows_no_equations_has_no_states():
    class Spring(LineLoad):
        def start_step(self, times):
            assert times.dt == 0.0

        def loads(self, motion, time):
            return -motion.position, 0.0 * motion.position

        def accept(self, motion, times):
            raise AssertionError

        def save(self):
            return RestartData()

        def restore(self, data):
            pass

    motion = turning(plain_blade(), 0.0)
    spring = TurningAtRest(Spring(), [0, 20, 40], SHAFT, CENTRE, TURN)
    assert isinstance(find_states(spring.source), WithoutStates)
    states = spring.balance(motion, 0.0)
    found = spring.respond(motion, 0.0, states)
    assert states.shape == found.rates.shape == (60, 0)
    assert np.array_equal(found.force, -motion.position)

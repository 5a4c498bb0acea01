"""Claims about modes in the air where theory knows them: flutter of a wing, a blade that flaps."""

import numpy as np
import pytest
from wings import Wings

from turbine_fenicsx import turning_equilibrium
from turbine_fenicsx.analysis.air_modes import AirProblem
from turbine_fenicsx.wind.shed_wake import RATES, SHARES

DENSITY = 1.225


def find(wings, speed=0.0, state=None, count=6):
    """Eigenvalues of the slowest modes."""
    state = wings.system.initial_state() if state is None else state
    problem = AirProblem(wings.system, "rotor", speed, state, None, motions=60)
    values = np.array([mode.eigenvalue for mode in problem.find(count).modes])
    problem.destroy()
    return values


def test_a_wing_of_goland_flutters_at_its_published_speed():
    """Goland and Luke (1948): 137.2 m/s, 70.7 rad/s. Air that moves along is added to the mass."""
    chord, half = 1.8288, 0.9144
    along = np.pi * DENSITY * half**2
    behind = 0.17 * chord  # the middle behind the elastic axis at 33 % of the chord
    mass, moment = 35.72 + along, 6.53 + along * behind
    second = 8.64 + along * (half**2 / 8.0 + behind**2)
    inertia = np.diag([mass, mass, mass, 0.05, second, second + 0.05])
    inertia[2, 4] = inertia[4, 2] = -moment
    stiffness = np.diag([1e9, 1e9, 1e10, 9.77e6, 1e9, 0.987e6])
    wings = Wings(stiffness, inertia, 6.096, chord, axis=0.33, twist=0.5 * np.pi)
    speeds, found = (125.0, 150.0), []
    for speed in speeds:
        wings.wind.set_speed(speed)
        found.append(max(find(wings), key=lambda s: s.real))
    (a, b), (low, high) = found, speeds
    assert a.real < 0.0 < b.real
    part = a.real / (a.real - b.real)
    assert low + part * (high - low) == pytest.approx(137.2, rel=0.02)
    assert a.imag + part * (b.imag - a.imag) == pytest.approx(70.7, rel=0.02)


LENGTH, CHORD, MASS, SPEED = 20.0, 0.8, 40.0, 3.0
"""Of a stiff blade that flaps: length and chord [m], mass [kg/m], speed of the rotor [rad/s]."""


def flap(**air):
    """A stiff blade on a hinge, its second moment about it, and the eigenvalues of flap."""
    inertia = np.diag([MASS, MASS, MASS, 2e-2, 4e-2, 6e-2])
    stiffness = np.diag([1e11, 1e11, 1e12, 1e12, 1e12, 1e11])
    wings = Wings(stiffness, inertia, LENGTH, CHORD, hinged=True, speed=SPEED, **air)
    state = turning_equilibrium(wings.system, "rotor", SPEED, wings.system.initial_state())
    found = find(wings, SPEED, state, 3)
    state.destroy()
    return wings, MASS * ((0.5 + LENGTH) ** 3 - 0.5**3) / 3.0, found


def test_a_hinged_blade_flaps_with_the_damping_of_strip_theory():
    """The decay is gamma/16 of the speed, with gamma = rho a c R^4/I for a blade to the axis."""
    wings, second, found = flap(pitch_rate=False, unsteady=False)
    decay = np.pi * DENSITY * CHORD * np.sum(wings.radius**3 * wings.parts) * SPEED / second / 2.0
    gamma = 2.0 * np.pi * DENSITY * CHORD * (0.5 + LENGTH) ** 4 / second
    assert decay == pytest.approx(gamma / 16.0 * SPEED, rel=0.01)
    assert -found.real == pytest.approx(decay, rel=1e-3)
    assert np.abs(found) == pytest.approx(SPEED, rel=1e-3)


def test_lift_that_takes_time_has_the_eigenvalues_of_its_equations():
    wings, second, found = flap(pitch_rate=False)
    n, r = len(wings.radius), wings.radius
    W = SPEED * r
    # angle and rate of the flap, then three states at each strip, whose flow is v = -r beta'
    A = np.zeros((2 + 3 * n,) * 2)
    A[0, 1], A[1, 0] = 1.0, -(SPEED**2)
    arms = np.pi * DENSITY * CHORD * W * r * wings.parts / second
    A[1, 1] = arms @ -r * (1.0 - np.sum(SHARES))
    A[1, 2:] = np.repeat(arms, 3)
    rates = np.outer(2.0 * W / CHORD, RATES)
    A[2:, 1] = (rates * np.outer(-r, SHARES)).ravel()
    A[range(2, len(A)), range(2, len(A))] = -rates.ravel()
    values = np.linalg.eigvals(A)
    wanted = max(values[np.abs(values.imag) > 0.1], key=lambda s: s.imag)
    assert np.abs(found - wanted) == pytest.approx(0.0, abs=1e-3 * abs(wanted))

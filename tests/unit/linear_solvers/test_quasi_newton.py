"""Claims about Broyden's method and about what it keeps for a restart."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.linear_solvers.quasi_newton import BASELINE_STEPS, RENEWAL, QuasiNewton

pytestmark = pytest.mark.parallel


@pytest.fixture
def make(comm):
    """Makes the method for some masses, with an approximate solver that does nothing."""

    class Solver:
        begin = staticmethod(lambda: False)
        refresh = staticmethod(lambda: None)
        save = staticmethod(RestartData)
        restore = staticmethod(lambda data: None)

    def method(masses=(1.0,)):
        # all unknowns on each rank, and a part of their masses
        weights = np.asarray(masses) / comm.size
        step = type("Step", (), {"system": type("System", (), {"comm": comm})})
        step.mass_weights = staticmethod(lambda: weights)
        return QuasiNewton(step, Solver())

    return method


def residual(x):
    """Nonlinear, of unknowns of different sizes; its root is one."""
    A = np.array(
        [[2.0, 0.3, 0.0, 0.1], [0.2, 3.0, 0.4, 0.0], [0.0, -0.3, 2.5, 0.2], [0.1, 0.0, 0.0, 2.0]]
    )
    return A @ (x - 1.0) + 0.2 * np.sin(x - 1.0) ** 2 + 0.1 * (x - 1.0) * np.roll(x - 1.0, 1)


def test_steps_are_those_of_broydens_formula(make):
    """H <- H + (s - H y) (s . H) / (s . H y), with products weighted by masses."""
    masses, H = np.array([1.0, 30.0, 0.2, 4.0]), np.diag([0.6, 0.3, 0.3, 0.7])
    method, P = make(masses), H.copy()
    x = expected = np.array([1.5, 0.2, 1.3, 0.4])
    for _ in range(7):
        s = -H @ residual(expected)
        R, expected = residual(expected), expected + s
        Hy = H @ (residual(expected) - R)
        H = H + np.outer(s - Hy, (masses * s) @ H) / ((masses * s) @ Hy)
        x = x + method._improve(-P @ residual(x))
        assert np.allclose(x, expected, rtol=0, atol=1e-12)
    assert np.max(np.abs(x - 1.0)) < 1e-4


@pytest.mark.parametrize("past", [3, BASELINE_STEPS + 40])
def test_a_restored_method_renews_the_factor_when_the_first_one_does(make, past):
    """Whether its usual number of iterations is known already or not."""
    more, counts = int(RENEWAL) // 3, [15, 13, 16, 14] * 20

    def resume(method, counts):
        """Whether the factor is due after each step."""
        due = []
        for n in counts:
            method._iterations = n
            method.end_iteration(True)
            due.append(method.save().numbers["excess"] >= RENEWAL)
        return due

    one, other = make(), make()
    assert not any(resume(one, counts[:past]))
    other.restore(one.save())
    later = [14 + more, 19, 18, 19, 18, 14 + more, 20, 19]
    found, expected = resume(other, later), resume(one, later)
    assert found == expected and True in found and False in found
    assert other.save() == one.save()

"""Claims about the balance of blade elements and momentum in one annulus."""

import numpy as np
import pytest

from turbine_fenicsx.wind.momentum import (
    HALVINGS,
    Annuli,
    _find_root,
    axial_induction,
    find_induction_share,
    induction_of_thrust,
    solve_momentum,
)

NO_LOSS = Annuli(np.array(50.0), np.array(0.05), 10**7, 100.0, 1.0)


def thrust_coefficient(a, F):
    """C_T of momentum theory with losses, and Buhl's above a = 0.4."""
    buhl = 8.0 / 9.0 + (4.0 * F - 40.0 / 9.0) * a + (50.0 / 9.0 - 4.0 * F) * a * a
    return np.where(a <= 0.4, 4.0 * F * a * (1.0 - a), buhl)


@pytest.mark.parametrize("F", [1.0, 0.8, 0.3])
def test_thrust_of_the_blade_elements_is_that_of_the_wake(F):
    kappa = np.array([0.05, 0.3, 0.5, 0.6666, 0.6667, 1.0, 3.0, 50.0])
    a = axial_induction(kappa, np.full(8, F))
    # C_T of the elements is 4 F kappa (1 - a)^2
    assert 4.0 * F * kappa * (1.0 - a) ** 2 == pytest.approx(thrust_coefficient(a, F), rel=1e-9)
    assert np.all(np.diff(a) > 0.0)


def test_the_wind_is_slowed_by_a_third_at_a_thrust_coefficient_of_eight_ninths():
    assert axial_induction(np.array(0.5), np.array(1.0)) == pytest.approx(1.0 / 3.0)


def test_losses_are_those_of_prandtl_and_end_at_tip_and_hub():
    annuli = Annuli(np.array([2.0001, 30.0, 99.999]), np.full(3, 0.05), 3, 100.0, 2.0)
    F = annuli.loss(np.full(3, 0.1))
    exponent = 1.5 * (100.0 - 30.0) / (30.0 * np.sin(0.1))
    assert F[1] == pytest.approx(2.0 / np.pi * np.arccos(np.exp(-exponent)), rel=1e-12)
    assert F[0] < 0.05 and F[2] < 0.05


@pytest.mark.parametrize(
    ("V_x", "V_y"), [(10.0, 40.0), (1.0, 90.0), (30.0, 5.0), (-3.0, 60.0), (30.0, -8.0)]
)
def test_a_balance_is_found_in_any_wind(V_x, V_y):
    setting = np.radians(2.0)

    def polars(phi):
        return 2.0 * np.pi * np.sin(phi - setting), 0.01 + 0.0 * phi

    phi, a, a_prime = solve_momentum(NO_LOSS, np.array(V_x), np.array(V_y), polars)
    # the inflow angle is that of the slowed wind
    assert np.tan(phi) == pytest.approx(V_x * (1.0 - a) / (V_y * (1.0 + a_prime)), rel=1e-9)


def test_without_blades_the_wind_is_as_before():
    annuli = NO_LOSS._replace(solidity=np.array(0.0))
    phi, a, a_prime = solve_momentum(
        annuli, np.array(8.0), np.array(50.0), lambda phi: (np.ones(()), np.zeros(()))
    )
    assert (a, a_prime) == (0.0, 0.0)
    assert np.tan(phi) == pytest.approx(8.0 / 50.0)


def test_the_thrust_of_eight_ninths_slows_the_wind_by_a_third_in_motion_too():
    assert induction_of_thrust(np.array(8.0 / 9.0), np.array(1.0)) == pytest.approx(1.0 / 3.0)


@pytest.mark.parametrize("F", [1.0, 0.8, 0.3])
def test_induction_of_a_thrust_is_the_inverse_of_the_thrust_of_an_induction(F):
    a = np.array([0.0, 0.1, 0.3, 0.39, 0.41, 0.6, 0.9])
    C_T = thrust_coefficient(a, F)
    assert induction_of_thrust(C_T, np.full(7, F)) == pytest.approx(a, abs=1e-12)


@pytest.mark.parametrize("V_y", [0.0, 1e-9, -1e-9])
def test_a_section_that_stands_has_the_balance_of_its_neighbours(V_y):
    def flat_plate(phi):
        return 2.0 * np.sin(phi - 1.2) * np.cos(phi - 1.2), 2.0 * np.sin(phi - 1.2) ** 2

    found = [solve_momentum(NO_LOSS, np.array(20.0), np.array(V), flat_plate) for V in (V_y, 1e-3)]
    assert found[0].axial == pytest.approx(found[1].axial, abs=1e-3)
    assert found[0].phi == pytest.approx(found[1].phi, abs=1e-3)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_induced_velocity_exceeds_the_wind(sign):
    annuli = NO_LOSS._replace(solidity=np.array(0.8))
    for V_y in np.linspace(-90.0, 90.0, 61):
        a, a_prime = solve_momentum(
            annuli, np.array(5.0), V_y, lambda phi: (sign * np.full_like(phi, 4.0), 0.1 + 0.0 * phi)
        )[1:]
        assert abs(a) <= 1.0 and abs(a_prime) <= 1.0


def test_induction_fades_in_between_tip_speed_ratios_of_one_and_two():
    shares = [find_induction_share(30.0 * x, 30.0) for x in (0.0, 0.9, 1.0, 1.5, 2.0, 9.0, -2.0)]
    assert shares == pytest.approx([0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0], abs=1e-15)
    assert find_induction_share(0.0, 0.0) == 1.0  # calm: there is no wind that would be slowed


@pytest.mark.parametrize(("size", "end"), [(1.0, 0.0), (-1.0, 3.0)])
def test_without_a_change_of_sign_the_end_is_found(size, end):
    found = _find_root(lambda x: np.full_like(x, size), np.zeros(2), np.full(2, 3.0))
    assert found == pytest.approx([end, end], abs=1e-14)


def test_a_root_at_a_jump_is_found_within_the_halvings():
    calls = []

    def jump(x):
        calls.append(x)
        return np.where(x > 1.1, 1e6, -1e-6)

    found = _find_root(jump, np.zeros(1), np.full(1, np.pi))
    assert found == pytest.approx(1.1, abs=1e-14)
    assert len(calls) <= 2 + HALVINGS

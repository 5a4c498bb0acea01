"""A run says so where its energy balance is worse than tolerance and round-off explain."""

import pytest

from turbine_fenicsx.turbine.energy_check import allowed_energy_error, judge_energy


def checked(error, energy=1e6, mass=1e3, steps=100, tolerance=1e-12):
    allowed = allowed_energy_error(energy, mass, steps, tolerance)
    return judge_energy(
        {
            "worst_energy_error_[J]": error,
            "allowed_energy_error_[J]": allowed,
            "largest_energy_[J]": energy,
        }
    )


def test_what_the_tolerance_explains_is_no_fault():
    assert checked(1e-12 * 1e6) == ""
    # a hundred steps of 1e-6, each with a hundred times this share of the energy
    assert checked(0.5e-2 * 1e6, tolerance=1e-6, steps=50) == ""
    assert checked(0.5e-2 * 1e6, tolerance=1e-6, steps=10) != ""
    assert checked(0.5e-2 * 1e6) != ""


def test_round_off_is_no_fault():
    assert checked(4e-8 * 1e6) == ""
    assert checked(1e-15, energy=1e-15) == ""  # a body at rest


@pytest.mark.parametrize("tolerance", [1e-12, 0.99])
def test_half_of_the_energy_is_never_explained(tolerance):
    found = checked(0.58e6, tolerance=tolerance)
    assert "wrong by 5.8e+05 J, 58 % of the largest energy" in found
    assert "do not trust this run" in found


def test_no_number_is_a_fault():
    assert checked(float("nan")) != ""

"""A run says so where its energy balance is worse than tolerance and round-off explain."""

import warnings

import numpy as np
import pytest

from turbine_fenicsx import (
    EnergyMomentum,
    GeneralisedAlpha,
    Gravity,
    ModelWarning,
    MultibodySystem,
    RigidBody,
    Simulation,
)
from turbine_fenicsx.simulation.energy_check import (
    EnergyWatch,
    allowed_energy_error,
    judge_energy,
    write_share,
)
from turbine_fenicsx.time_stepping.discrete_gradients import mean_stress


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
    assert checked(0.5e-3 * 1e6, tolerance=1e-7, steps=50) == ""
    assert checked(0.5e-3 * 1e6, tolerance=1e-7, steps=10) != ""
    assert checked(0.5e-3 * 1e6) != ""
    assert checked(1e-6 * 1e6) != ""


def test_round_off_is_no_fault():
    assert checked(4e-8 * 1e6) == ""
    assert checked(1e-15, energy=1e-15) == ""  # a body at rest


@pytest.mark.parametrize("tolerance", [1e-12, 0.99])
def test_a_hundredth_of_the_energy_is_never_explained(tolerance):
    found = checked(3.3e4, tolerance=tolerance)
    assert "wrong by 3.3e+04 J, 3.3 % of the largest energy" in found
    assert "do not trust this run" in found


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (1.0, "100 % of"),
        (1e-7, "0.00001 % of"),
        (0.0333, "3.3 % of"),
        (12.3, "12 times"),
        (1e9, "more than a thousand times"),
    ],
)
def test_shares_are_written_as_people_do(share, text):
    assert write_share(share) == text


@pytest.mark.parametrize("reach", [1.0, 1e5])
def test_round_off_of_positions_far_away_is_no_fault(comm, reach):
    """Two bodies at rest: their energies are the work of their weight along a round-off."""
    bodies = [RigidBody(name, 10.0, (1.0, 1.0, 1.0)) for name in "ab"]
    system = MultibodySystem(comm, [*bodies, Gravity()])
    watch = EnergyWatch()
    watch.worst = watch.largest = 1e-8
    watch.reach = reach
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        watch.warn(system, EnergyMomentum(system), 10)
    assert len(caught) == (reach == 1.0 and comm.rank == 0)


@pytest.mark.parametrize("height", [0.0, 1e6])
def test_energies_count_from_the_start_wherever_the_origin_is(comm, height):
    body = RigidBody("stone", 2.0, (1.0,) * 3, position=(0.0, height, 0.0), velocity=(3.0, 0, 0))
    system = MultibodySystem(comm, [body, Gravity((0.0, -10.0, 0.0))])
    last = Simulation(system, 0.01, 0.5).run()
    assert last.stored_energy == pytest.approx(0.5 * 2.0 * (3.0**2 + 5.0**2), rel=1e-6)
    watch = EnergyWatch()
    watch.take(last)
    assert watch.largest == last.stored_energy


def test_no_number_is_a_fault():
    assert checked(float("nan")) != ""


def spinning(comm):
    """A free rigid body that turns about no axis of its own."""
    inertia = np.diag([1.0, 2.0, 3.0])
    body = RigidBody.from_inertia("top", 2.0, inertia, angular_velocity=(1.0, 2.0, 3.0))
    return MultibodySystem(comm, [body])


class Leaking(EnergyMomentum):
    """A scheme that loses energy."""

    def advance(self, state, dt, out):
        report = super().advance(state, dt, out)
        out.q_dot *= 1.0 - 1e-6
        return report


def run(system, kind, **options):
    Simulation(system, 0.01, 0.1, stepper=kind(system, **options)).run()


def test_a_run_from_python_warns_of_its_balance_once_for_all_ranks(comm):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run(spinning(comm), Leaking)
    assert len(caught) == (comm.rank == 0)
    if caught:
        assert caught[0].category is ModelWarning
        assert "the energy balance is wrong by" in str(caught[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ModelWarning, match=r"0\.00. % of the largest energy"):
            run(spinning(comm), Leaking)  # on all ranks


def test_a_good_run_and_a_scheme_that_promises_nothing_do_not_warn(comm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(spinning(comm), EnergyMomentum)
        run(spinning(comm), Leaking, stress=mean_stress)
        run(spinning(comm), GeneralisedAlpha, spectral_radius=0.5)

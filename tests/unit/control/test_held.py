"""Held torques and brakes: exact works, and a halved step sees the same torque."""

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx import (
    JointSpring,
    ModelError,
    MultibodySystem,
    Revolute,
    RigidBody,
    Simulation,
)
from turbine_fenicsx.control.step_torques import HeldBrake, HeldTorque
from turbine_fenicsx.system.start import initial_motion

pytestmark = pytest.mark.parallel

J1, J2 = 50.0, 8.0


def make_drivetrain(comm, *forces):
    """A rotor on the ground and a generator on a shaft behind it."""
    rotor, generator = (
        RigidBody(name, 10.0, (0.5 * J, 0.5 * J, 0.1 * J))
        for name, J in (("rotor", J1), ("generator", J2))
    )
    joints = [
        Revolute("main", None, rotor, point=(0, 0, 0), axis=(0, 0, 1)),
        Revolute("shaft", rotor, generator, point=(0, 0, 0), axis=(0, 0, 1)),
    ]
    parts = [rotor, generator, *joints, JointSpring("torsion", "shaft", 1e4), *forces]
    return MultibodySystem(comm, parts)


def times_and_rates(snapshot):
    s = snapshot.state
    return s.time, *s.joint_coordinates, *s.joint_rates, snapshot.energy_error


def test_a_torque_on_a_sum_of_angles_does_the_work_of_torque_times_increment(comm):
    torque = HeldTorque("generator", {"main": 2.0, "shaft": 2.0}, torque=-30.0)
    system = make_drivetrain(comm, torque)
    last = Simulation(
        system, 0.01, 1.0, start=initial_motion(system, {"main": 5.0, "shaft": 0.0})
    ).run()
    turned = float(np.sum(last.state.joint_coordinates))
    assert np.isclose(last.works[0], -30.0 * 2.0 * turned, rtol=1e-13)
    assert abs(last.energy_error) < 1e-10 * last.balance.kinetic
    # the reaction is on the ground: the momentum falls by the torque times the time, but for the
    # angle's discrete gradient, which is of second order
    momentum = 5.0 * (J1 + J2) - 60.0 * 1.0
    assert np.isclose(last.balance.angular[2], momentum, rtol=1e-4)


def test_a_torque_on_an_unknown_coordinate_is_a_sentence(comm):
    with pytest.raises(ModelError, match="no joint coordinate 'mast'; there are"):
        make_drivetrain(comm, HeldTorque("generator", {"mast": 1.0}))


def test_a_brake_stops_a_rotor_and_turns_its_energy_into_heat(comm):
    brake, recorder = HeldBrake("brake", ["main", "shaft"], strength=100.0), Seen(times_and_rates)
    system = make_drivetrain(comm, brake)
    start = initial_motion(system, {"main": 2.0, "shaft": 0.0})
    energy = system.balance(start).total
    last = Simulation(system, 0.01, 3.0, [recorder], start=start).run()
    time, main, shaft, *_ = np.array(recorder.values).T
    # Coulomb's friction: constant deceleration M/J until it stands, in the mean of the vibration
    early = time < 0.9
    slope = np.polyfit(time[early], ((J1 * main + J2 * (main + shaft)) / (J1 + J2))[early], 2)[0]
    assert np.isclose(2.0 * slope, -100.0 / (J1 + J2), rtol=1e-3)
    assert np.isclose(last.dissipated.sum() + last.balance.total, energy, rtol=1e-12)
    assert last.balance.total < 1e-2 * energy


def test_a_closed_brake_creeps_as_slowly_as_it_says(comm):
    brake = HeldBrake("brake", ["main", "shaft"], speed=1e-3, strength=50.0)
    system = make_drivetrain(comm, brake, HeldTorque("wind", {"main": 1.0}, torque=30.0))
    last = Simulation(system, 0.1, 20.0).run()
    share = 30.0 / 50.0
    creep = 1e-3 * share / np.sqrt(1.0 - share**2)
    turned = float(last.state.joint_coordinates[0])
    assert np.isclose(turned, 20.0 * creep + 30.0 / 1e4, rtol=0.2)  # the shaft is not loaded


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"strength": -1.0}])
def test_wrong_brakes_are_refused(wrong):
    with pytest.raises(ModelError, match="of 'brake' must"):
        HeldBrake("brake", ["main"], **wrong)

"""Claims about loads."""

import numpy as np
import pytest

from turbine_fenicsx.loads import Forces, Gravity, JointTorque, Load
from turbine_fenicsx.time_functions import Hat


def forces():
    return Forces(coordinates={}, torques={"yaw": 0.0, "rotor": 0.0})


def test_loads_are_loads():
    assert isinstance(Gravity(), Load)
    assert isinstance(JointTorque("rotor", Hat(1.0)), Load)
    assert not isinstance(Hat(1.0), Load)


def test_gravity_points_down_along_e2_by_default():
    f = forces()
    Gravity().add_to(f, 0.0)
    assert f.acceleration.tolist() == [0.0, -9.81, 0.0]


def test_loads_add_up():
    f = forces()
    Gravity((1.0, 0.0, 2.0)).add_to(f, 0.0)
    Gravity((0.0, 3.0, 2.0)).add_to(f, 5.0)
    JointTorque("rotor", Hat(4.0, 2.0)).add_to(f, 0.5)
    JointTorque("rotor", Hat(1.0, 2.0)).add_to(f, 1.0)
    assert f.acceleration.tolist() == [1.0, 3.0, 4.0]
    assert f.torques == {"yaw": 0.0, "rotor": 3.0}


def test_forces_start_anew_each_time():
    Gravity().add_to(forces(), 0.0)
    assert np.array_equal(forces().acceleration, np.zeros(3))


def test_a_torque_on_an_unknown_joint_names_the_joints_there_are():
    with pytest.raises(ValueError, match=r"no joint angle 'pitch'; there are \['rotor', 'yaw'\]"):
        JointTorque("pitch", Hat(1.0)).add_to(forces(), 0.0)

"""Claims about the frame that turns with one side of a joint."""

import numpy as np
import pytest

from turbine_fenicsx import (
    Cylindrical,
    Planar,
    Prismatic,
    Revolute,
    Rigid,
    Spherical,
    Universal,
    gear_pair,
)
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import E3, rotation_about, unit
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

POINT, AXIS = np.array([0.3, -2.0, 5.0]), unit([1.0, 2.0, -0.5])
A = RigidBody(
    "a", 2.0, (1, 2, 3), position=(3.0, 5.0, 2.0), directors=rotation_about((1, 0, 2), 0.7)
)
B = RigidBody(
    "b", 1.0, (3, 1, 2), position=(1.0, -1.0, 4.0), directors=rotation_about((0, 1, 2), 0.2)
)


def distance_to_axis(frame, point):
    return np.linalg.norm(np.cross(frame.axis, frame.point - point))


@pytest.mark.parametrize("kind", [Revolute, Cylindrical, Planar])
@pytest.mark.parametrize("first", [None, A])
def test_the_axis_is_that_of_the_joint_where_the_first_partner_is_now(comm, kind, first):
    joint = kind("turns", first, B, point=POINT, **{"normal" if kind is Planar else "axis": AXIS})
    system = MultibodySystem(comm, [B, joint] if first is None else [A, B, joint])
    frame = turning_frame(system, "turns", 3.0)
    assert np.allclose(frame.axis, AXIS, rtol=0, atol=1e-14)
    assert distance_to_axis(frame, POINT) <= 1e-13  # round-off of coordinates of 5 m
    if first is None:
        assert frame.rigid_turns.tolist() == [True]
        return
    assert frame.rigid_turns.tolist() == [False, True]
    # the whole system moved as a rigid body
    state, R, shift = system.initial_state(), rotation_about((2, -1, 1), 1.1), np.array([3, 4, 7])
    moved = state.q.reshape(-1, 4, 3) @ R.T
    moved[:, 0] += shift
    state.q = moved.ravel()
    frame = turning_frame(system, "turns", 3.0, state)
    assert np.allclose(frame.axis, R @ AXIS, rtol=0, atol=1e-14)
    assert distance_to_axis(frame, R @ POINT + shift) <= 1e-13


def test_the_angle_grows_about_the_axis_wherever_it_stands(comm):
    system = MultibodySystem(comm, [A, B, Cylindrical("turns", A, B, point=POINT, axis=AXIS)])
    frame, state = turning_frame(system, "turns", 3.0), system.initial_state()
    for angle in (0.7, 2.0, 3.0, -1.0):
        frame.turn(state, angle)
        assert system.constraint_error(state) <= 1e-13
        again = turning_frame(system, "turns", 3.0, state)
        assert np.allclose(again.axis, AXIS, rtol=0, atol=1e-13)
    assert state.joint_coordinates.tolist() == pytest.approx([4.7, 0.0])


def test_velocities_are_those_of_the_rates_of_the_joints(comm, machine):
    m = machine()
    system = m.system()
    frame, state = turning_frame(system, "rotor", -1.7), system.initial_state()
    assert (frame.rigid_turns.tolist(), frame.flexible_turns) == ([False, True], (True,))
    frame.turn(state, 0.4)
    frame.turn(state, -0.4)
    frame.set_velocities(state)
    expected = initial_motion(system, {"rotor": -1.7, "yaw": 0.0})
    assert np.allclose(state.q_dot, expected.q_dot, rtol=0, atol=1e-13)
    assert np.allclose(state.joint_rates, expected.joint_rates, rtol=0, atol=1e-13)
    assert (state.v[0] - expected.v[0]).norm() <= 1e-13


def test_the_other_side_does_not_turn(comm, machine):
    m = machine()
    frame = turning_frame(m.system(), "yaw", 2.0)
    assert (frame.rigid_turns.tolist(), frame.flexible_turns) == ([True, True], (True,))
    mast = RigidBody("mast", 5.0, (1, 1, 1))
    yaw = Revolute("yaw", mast, m.nacelle, point=(0.0, 0.1, 0.0), axis=(0.0, -1.0, 0.0))
    parts = [m.nacelle, m.hub, mast, yaw, m.rotor, m.beam, Rigid("foot", None, mast, (0, 0, 0))]
    root = type(m.root)("root", m.beam, m.facets(0.5), mast)
    frame = turning_frame(MultibodySystem(comm, [*parts, root]), "rotor", 2.0)
    assert (frame.rigid_turns.tolist(), frame.flexible_turns) == ([False, True, False], (False,))
    state = frame.system.initial_state()
    frame.set_velocities(state)
    force = state.v[0].duplicate()
    frame.body_centrifugal_force(0, state.u[0], force)
    assert state.v[0].norm() == force.norm() == 0.0
    assert not state.q_dot.reshape(-1, 12)[[0, 2]].any()
    for power, size in ((0, None), (1, 0.0), (2, 0.0)):
        M = frame.body_matrix(0, power)
        assert M.norm() > 0.0 if size is None else M.norm() == 0.0
        M.destroy()


def test_matrices_and_forces_are_those_of_the_velocities(comm, machine):
    m = machine(degree=2)
    system = m.system()
    frame, state = turning_frame(system, "rotor", 1.3), system.initial_state()
    state.u[0].array[:] = 0.1 * np.sin(np.arange(state.u[0].array_r.size) + comm.rank)
    frame.set_velocities(state)
    v, p, q = state.v[0], state.u[0].duplicate(), state.u[0].duplicate()
    arms = state.u[0].duplicate()
    arms.array[:] = frame.body_arms(0, state.u[0]).ravel()
    M, MS, MSS = (frame.body_matrix(0, k) for k in range(3))
    system.flexible_models[0].momentum(v, p)
    MS.mult(arms, q)
    assert (p - q).norm() <= 1e-13 * p.norm()
    MS.mult(v, p)
    MSS.mult(arms, q)
    assert (p - q).norm() <= 1e-13 * p.norm()
    frame.body_centrifugal_force(0, state.u[0], p)
    assert (p - q).norm() <= 1e-13 * p.norm()
    # kinetic energy, and the work of centrifugal forces: v.M v = -x.M S^2 x
    assert q.dot(arms) == pytest.approx(-v.dot(M * v), rel=1e-12)

    x = frame.rigid_arms(state.q).ravel()
    full = np.concatenate([x, np.zeros(2)])
    assert np.allclose(frame.rigid_matrix(0)[:24, :24], np.diag(system.rigid_model.masses))
    momenta = system.rigid_model.masses * state.q_dot
    assert np.allclose((frame.rigid_matrix(1) @ full)[:24], momenta, rtol=0, atol=1e-14)
    forces = frame.rigid_centrifugal_force(state.q)
    assert np.allclose((frame.rigid_matrix(2) @ full)[:24], forces, rtol=0, atol=1e-13)
    assert frame.rigid_matrix(2).shape == (26, 26) and forces.any()


def test_a_turned_state_has_the_same_energy_and_turned_joint_forces(comm, machine):
    m = machine()
    system = m.system()
    frame, state = turning_frame(system, "rotor", 1.3), system.initial_state()
    state.u[0].array[:] = 0.1 * np.sin(np.arange(state.u[0].array_r.size) + comm.rank)
    state.multipliers[:] = 0.0
    state.multipliers[6:12] = (3.0, 2.0, 1.0, -1.0, 0.0, 2.0)  # stresses inside the hub
    before = system.balance(state)
    forces, G = system.rigid_model.constraint_forces(
        state.q, state.joint_coordinates, state.multipliers
    )
    R_T = rotation_about(E3, 0.9).T
    wanted = (forces @ G).reshape(-1, 4, 3)[1] @ R_T
    state.coupling[0].array[:] = np.cos(np.arange(state.coupling[0].array_r.size))
    held = state.coupling[0].array_r.reshape(-1, 3) @ R_T
    frame.turn(state, 0.9)
    assert np.allclose(state.coupling[0].array_r.reshape(-1, 3), held, rtol=0, atol=1e-14)
    after = system.balance(state)
    assert after.strain == pytest.approx(before.strain, rel=1e-12)
    forces, G = system.rigid_model.constraint_forces(
        state.q, state.joint_coordinates, state.multipliers
    )
    assert np.allclose((forces @ G).reshape(-1, 4, 3)[1], wanted, rtol=0, atol=1e-12)


def test_what_cannot_turn_is_refused_in_one_sentence(comm):
    def refusal(*parts, joint="j", speed=1.0):
        system = MultibodySystem(comm, [A, B, *parts])
        with pytest.raises(ModelError) as error:
            turning_frame(system, joint, speed)
        assert "\n" not in str(error.value)
        return str(error.value)

    revolute = Revolute("j", A, B, point=POINT, axis=AXIS)
    assert refusal(revolute, joint="k") == "no joint 'k'; there are ['j']"
    assert refusal(revolute, speed=np.nan) == "speed of 'j' must be a number, got nan"
    for other in (
        Prismatic("j", A, B, point=POINT, axis=AXIS),
        Spherical("j", A, B, POINT),
        Universal("j", A, B, point=POINT, first_axis=(1, 0, 0), second_axis=(0, 1, 0)),
        Rigid("j", A, B, POINT),
        Revolute("j", A, B, point=POINT, axis=AXIS, with_coordinates=False),
    ):
        assert refusal(other) == ("joint 'j' has no angle about one axis, as a revolute joint has")
    assert "the ground; exchange the partners" in refusal(
        Revolute("j", B, None, point=POINT, axis=AXIS)
    )
    tied = "other joints or couplings tie its second side to its first or to the ground"
    assert tied in refusal(revolute, Spherical("k", A, B, POINT))
    assert tied in refusal(revolute, Spherical("k", None, B, POINT))
    other = Revolute("k", None, A, point=POINT, axis=AXIS)
    assert "'gear' ties the angle of joint 'j' to other joint coordinates" in refusal(
        revolute, other, gear_pair("gear", "j", "k", 2.0)
    )

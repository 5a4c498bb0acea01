"""Claims about loads on joints and rigid bodies."""

import numpy as np
import pytest

from turbine_fenicsx import FollowerForce, Gravity, JointTorque, PointForce, Revolute, Torque
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.force import Force, Layout, StepTimes
from turbine_fenicsx.forces.prescribed_force import ForceSum, PrescribedForce
from turbine_fenicsx.forces.time_functions import Hat, Ramp
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

TURN = rotation_about((1, 0, 2), 0.7)
A = RigidBody(
    "a",
    2.0,
    (1, 2, 3),
    position=(1, 2, 3),
    directors=TURN,
    velocity=(0.1, 0.2, -0.3),
    angular_velocity=(0.5, -1.0, 0.4),
)
B = RigidBody("b", 3.0, (4, 2, 3), position=(-1, 0, 2), directors=rotation_about((0, 1, 2), -1.9))
P, F, M = np.array([2.0, 0.5, -1.0]), np.array([3.0, -1.0, 2.0]), np.array([1.0, 5.0, -2.0])
LAYOUT = Layout({B: 0, A: 12}, {})
FOLLOWERS = {
    "follower force": FollowerForce("f", A, point=P, force=F, function=Ramp(1.0, 2.0)),
    "torque": Torque("f", A, M, Ramp(1.0, 2.0)),
    "follower torque": Torque("f", A, M, Ramp(1.0, 2.0), follower=True),
}
all_followers = pytest.mark.parametrize("load", FOLLOWERS.values(), ids=FOLLOWERS)


def forces(*bodies):
    q = {b: np.zeros(12) for b in bodies}
    return ForceSum(coordinates=q, torques={"yaw": 0.0, "rotor": 0.0})


def test_loads_are_loads():
    assert isinstance(Gravity(), PrescribedForce)
    assert isinstance(JointTorque("torque on rotor", "rotor", 1.0, Hat(1.0)), PrescribedForce)
    assert isinstance(PointForce("f", A, point=P, force=F), PrescribedForce)
    assert not isinstance(Hat(1.0), PrescribedForce)
    assert all(isinstance(x, Force) and x.kind == "external" for x in FOLLOWERS.values())


def test_gravity_points_down_along_e2_by_default():
    f = forces()
    Gravity().add_to(f, 0.0)
    assert f.acceleration.tolist() == [0.0, -9.81, 0.0]


def test_loads_add_up():
    f = forces()
    Gravity((1.0, 0.0, 2.0)).add_to(f, 0.0)
    Gravity((0.0, 3.0, 2.0)).add_to(f, 5.0)
    JointTorque("torque on rotor", "rotor", 1.0, Hat(4.0, 2.0)).add_to(f, 0.5)
    JointTorque("torque on rotor", "rotor", 1.0, Hat(1.0, 2.0)).add_to(f, 1.0)
    assert f.acceleration.tolist() == [1.0, 3.0, 4.0]
    assert f.torques == {"yaw": 0.0, "rotor": 3.0}


def test_forces_start_anew_each_time():
    Gravity().add_to(forces(), 0.0)
    assert np.array_equal(forces().acceleration, np.zeros(3))


def test_a_torque_on_an_unknown_joint_names_the_joints_there_are():
    with pytest.raises(ValueError, match=r"no joint .* 'pitch'; there are \['rotor', 'yaw'\]"):
        JointTorque("torque on pitch", "pitch", 1.0, Hat(1.0)).add_to(forces(), 0.0)


def test_power_of_a_point_force_is_force_times_velocity_of_the_point():
    f = forces(A, B)
    PointForce("f", A, point=P, force=F, function=Hat(2.0, 4.0)).add_to(f, 1.0)
    velocity = np.asarray(A.velocity) + np.cross(A.angular_velocity, P - A.position)
    assert f.coordinates[A] @ A.rates == pytest.approx(F @ velocity, rel=1e-14)
    assert np.array_equal(f.coordinates[B], np.zeros(12))
    PointForce("g", A, point=P, force=F).add_to(f, 1.0)  # no function: always
    assert f.coordinates[A] @ A.rates == pytest.approx(2 * F @ velocity, rel=1e-14)


def resultant(load, y, time=1.0):
    """Force, moment about the origin, and power over rate of a load at coordinates of A."""
    bound = load.bind(LAYOUT)
    f = np.zeros(24)
    f[bound.index] = bound.force(
        *(np.concatenate([B.coordinates, y])[bound.index],) * 2, StepTimes(0.1, time, time + 0.05)
    )[0]
    rows = f[12:].reshape(4, 3)
    return rows[0], np.cross(y.reshape(4, 3), rows).sum(axis=0), f[12:]


def turned(R, shift=(0, 0, 0)):
    y = A.coordinates.reshape(4, 3) @ R.T
    y[0] += shift
    return y.ravel()


@pytest.mark.parametrize("R", [np.eye(3), rotation_about((1, 2, 3), 2.0)], ids=["start", "turned"])
def test_follower_force_turns_with_the_body_and_acts_at_its_point(R):
    force, moment, _ = resultant(FOLLOWERS["follower force"], turned(R, (5, 0, 1)))
    assert np.allclose(force, 0.5 * R @ F, rtol=0, atol=1e-13)  # half-way up the ramp
    point = R @ P + [5, 0, 1]
    assert np.allclose(moment, np.cross(point, 0.5 * R @ F), rtol=0, atol=1e-12)


@pytest.mark.parametrize("R", [np.eye(3), rotation_about((1, 2, 3), 2.0)], ids=["start", "turned"])
def test_torque_has_no_resultant_and_stays_in_space_unless_it_follows(R):
    y = turned(R, (5, 0, 1))
    for name, expected in (("torque", M), ("follower torque", R @ M)):
        force, moment, f = resultant(FOLLOWERS[name], y)
        assert np.array_equal(force, np.zeros(3))
        assert np.allclose(moment, 0.5 * expected, rtol=0, atol=1e-13)
        w = np.array([0.3, -0.5, 0.8])
        spin = np.cross(w, y.reshape(4, 3)).ravel()
        assert f @ spin == pytest.approx(0.5 * expected @ w, rel=1e-13)  # power M . w


def test_torque_is_exact_for_directors_that_are_not_orthonormal():
    """As in the middle of a step."""
    y = A.coordinates + 0.3 * np.random.default_rng(1).normal(size=12)
    assert np.allclose(resultant(FOLLOWERS["torque"], y)[1], 0.5 * M, rtol=0, atol=1e-13)


@all_followers
def test_follower_tangents_agree_with_finite_differences(load):
    bound, rng, h = load.bind(LAYOUT), np.random.default_rng(2), 1e-6
    y = np.concatenate([B.coordinates, A.coordinates])[bound.index]
    y0, y1 = y + 0.2 * rng.normal(size=(2, y.size))
    step = StepTimes(0.1, 1.0, 1.05)
    columns = [
        (bound.force(y0, y1 + h * e, step)[0] - bound.force(y0, y1 - h * e, step)[0]) / (2 * h)
        for e in np.eye(y.size)
    ]
    assert np.allclose(bound.force(y0, y1, step)[1], np.column_stack(columns), rtol=0, atol=1e-8)
    assert bound.energy(y0) == 0.0


@all_followers
def test_followers_act_at_the_middle_of_a_step(load):
    bound, rng = load.bind(LAYOUT), np.random.default_rng(3)
    y = np.concatenate([B.coordinates, A.coordinates])[bound.index]
    y0, y1 = y + 0.2 * rng.normal(size=(2, y.size))
    middle, step = 0.5 * (y0 + y1), StepTimes(0.1, 1.0, 1.05)
    there = bound.force(middle, middle, step)[0]
    assert np.allclose(bound.force(y0, y1, step)[0], there, rtol=0, atol=1e-13)


def run(comm, parts, steps=20, dt=0.05):
    """Advance; yields works, balance and both states of each step."""
    system = MultibodySystem(comm, parts)
    solver = EnergyMomentum(system)
    state = system.initial_state()
    before = system.balance(state)
    for _ in range(steps):
        other = state.copy()
        report = solver.advance(state, dt, other)
        after = system.balance(other)
        yield report, before, after, state, other
        state, before = other, after
    solver.destroy()


def test_torque_adds_exactly_torque_times_time_to_the_angular_momentum_of_a_free_body(comm):
    hat = Hat(7.0, 2.0)
    for _, before, after, state, _ in run(comm, [A, Torque("M", A, M, hat)]):
        gained = 0.05 * hat(state.time + 0.025) * M
        assert np.allclose(after.angular - before.angular, gained, rtol=0, atol=1e-12)
        assert np.allclose(after.linear, before.linear, rtol=0, atol=1e-13)


def test_point_force_adds_its_momentum_and_its_moment_at_the_middle(comm):
    xi = A.body_coordinates(P)
    for report, before, after, state, other in run(
        comm, [A, B, PointForce("f", A, point=P, force=F)]
    ):
        point = [s.q[:3] + xi @ s.q[3:12].reshape(3, 3) for s in (state, other)]
        moment = np.cross(0.5 * (point[0] + point[1]), F)
        assert np.allclose(after.linear - before.linear, 0.05 * F, rtol=0, atol=1e-12)
        assert np.allclose(after.angular - before.angular, 0.05 * moment, rtol=0, atol=1e-12)
        assert report.works == pytest.approx([F @ (point[1] - point[0])], rel=1e-11, abs=1e-13)


@all_followers
def test_work_of_a_follower_closes_the_balance_of_energy(comm, load):
    works = 0.0
    for report, before, after, *_ in run(comm, [A, load]):
        assert after.total - before.total == pytest.approx(report.work, abs=1e-12)
        works += abs(report.work)
    assert works > 0.1


SCALAR = "must be three numbers, got"


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: PointForce("f", A, point=P, force=(1, 2)),
            ValueError,
            rf"force of 'f' {SCALAR} \(1, 2\)",
        ),
        (
            lambda: PointForce("f", A, point=(0, np.nan, 1), force=F),
            ValueError,
            f"point of 'f' {SCALAR}",
        ),
        (
            lambda: FollowerForce("f", A, point=P, force=3.0),
            ValueError,
            f"force of 'f' {SCALAR} 3.0",
        ),
        (lambda: Torque("f", A, 5.0), ValueError, f"torque of 'f' {SCALAR} 5.0"),
        (
            lambda: PointForce("f", None, point=P, force=F),
            TypeError,
            "'f' needs a rigid body, got None",
        ),
        (
            lambda: FollowerForce("f", "a", point=P, force=F),
            TypeError,
            "'f' needs a rigid body, got str 'a'",
        ),
        (lambda: Torque("f", Gravity(), M), TypeError, "a rigid body, got Gravity 'gravity'"),
        (
            lambda: PointForce("f", A, point=P, force=F, function=3.0),
            TypeError,
            "'f' needs a function of time, for",
        ),
        (lambda: Torque("f", A, M, 2.0), TypeError, r"Constant\(2.0\), got float 2.0"),
        (lambda: JointTorque("f", "j", 1.0, 2.0), TypeError, "'f' needs a function of time"),
        (
            lambda: JointTorque("f", "j", Hat(1.0)),
            ValueError,
            "torque of 'f' must be a number, got",
        ),
    ],
)
def test_mistakes_are_refused_in_a_sentence(make, error, words):
    with pytest.raises(error, match=words):
        make()


def test_loads_on_bodies_outside_the_system_are_refused(comm):
    for load in (
        PointForce("f", B, point=P, force=F),
        FollowerForce("f", B, point=P, force=F),
        Torque("f", B, M),
    ):
        with pytest.raises(ValueError, match="rigid body 'b' is not among the parts"):
            MultibodySystem(comm, [A, load])


def test_works_have_the_names_of_their_loads(comm):
    joint = Revolute("j", A, B, point=P, axis=(0, 0, 1))
    torque = JointTorque("torque on j", "j", 1.0)
    parts = [
        A,
        B,
        joint,
        Torque("M", A, M),
        Gravity(),
        PointForce("f", A, point=P, force=F),
        torque,
        torque,
    ]
    names = MultibodySystem(comm, parts).work_names
    assert names == ("gravity", "f", "torque on j", "torque on j 2", "M")

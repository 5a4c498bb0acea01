"""Claims about revolute joints: what they lock, what their angle measures, what they conserve."""

from mpi4py import MPI

import numpy as np
import pytest
from rigid_turbine import rigid_turbine

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.quadratic import QuadraticMap
from turbine_fenicsx.foundation.rotations import rotation_about, unit
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.revolute import Revolute

POINT, AXIS = np.array([0.5, -1.0, 2.0]), np.array([1.0, 2.0, -0.5])
A = RigidBody("a", 2.0, (1, 2, 3), position=(1, 2, 3), directors=rotation_about((1, 0, 2), 0.7))
B = RigidBody("b", 3.0, (4, 2, 3), position=(-1, 0, 2), directors=rotation_about((0, 1, 2), -1.9))
TURN, SHIFT = rotation_about((1.0, -0.3, 0.4), 2.2), np.array([3.0, -5.0, 4.0])
ROUND_OFF = 2e-14
"""Sums of a dozen products of numbers up to about five."""


def joint(first=A, second=B, **changes):
    data = {"name": "j", "first": first, "second": second, "point": POINT, "axis": AXIS}
    return Revolute(**(data | changes))


def frames(bodies):
    index = {id(b): k for k, b in enumerate((A, B))}
    return [BodyFrame(b, -1 if b is None else 4 * index[id(b)]) for b in bodies]


def constraints_of(j):
    return QuadraticMap(j.constraints(*frames(j.bodies)), 24)


def angle_functions(j, *of):
    """Cosine and sine of the joint angle."""
    (angle,) = j.coordinates(*(of or frames(j.bodies))).values()
    return angle


def angle_of(j):
    """The joint angle as a function of q."""
    f = QuadraticMap(angle_functions(j), 24)

    def angle(q):
        c, s = f.value(q)
        return np.arctan2(s, c)

    return angle


def moved(q, R=TURN, shift=SHIFT):
    """Coordinates after a superposed rotation about the origin and a translation."""
    y = q.reshape(-1, 3) @ R.T
    y[::4] += shift
    return y.ravel()


def opened(angle, j=None):
    """A and B in their initial position, B turned about the axis of the joint."""
    j = j or joint()
    R = rotation_about(j.axis, angle)
    b = B.coordinates.reshape(4, 3) @ R.T
    b[0] = R @ (np.asarray(B.position) - j.point) + j.point
    return np.concatenate([A.coordinates, b.ravel()])


def test_revolute_is_a_joint():
    assert isinstance(joint(), Joint)
    assert joint().bodies == (A, B)


@pytest.mark.parametrize("first", [A, None])
def test_revolute_locks_five_of_six_degrees_of_freedom_at_any_angle(first):
    j = joint(first)
    g = constraints_of(j)
    assert g.shape[0] == 5
    internal = [c for f in frames((A, B)) for c in f.internal_constraints()]
    rows = QuadraticMap([*internal, *j.constraints(*frames(j.bodies))], 24)
    for angle in np.linspace(-3, 3, 7):
        G = rows.jacobian(opened(angle))
        assert np.linalg.matrix_rank(G) == 6 + 6 + 5


@pytest.mark.parametrize("first", [A, None])
@pytest.mark.parametrize("reference", [None, (0.0, 0.0, 1.0)])
def test_revolute_constraints_vanish_initially_and_at_any_angle(first, reference):
    g = constraints_of(joint(first, reference=reference))
    for angle in (0.0, 0.3, -2.0, 3.1, 40.0):
        assert np.max(np.abs(g.value(opened(angle)))) <= ROUND_OFF


def test_revolute_notices_every_motion_that_it_locks():
    g = constraints_of(joint())
    frame = opened(0.4)
    for axis in np.eye(3):
        other = frame.copy()
        other[12:15] += 0.1 * axis  # B away from the point
        assert np.linalg.norm(g.value(other)[:3]) == pytest.approx(0.1, abs=ROUND_OFF)
    for axis in (np.cross(AXIS, [1, 0, 0]), np.cross(AXIS, [0, 1, 0])):
        R, other = rotation_about(axis, 0.1), frame.copy()
        b = frame[12:].reshape(4, 3) @ R.T
        b[0] = R @ (frame[12:15] - POINT) + POINT
        other[12:] = b.ravel()  # B tilted about the joint point
        values = g.value(other)
        assert np.max(np.abs(values[:3])) <= ROUND_OFF
        assert np.linalg.norm(values[3:]) == pytest.approx(np.sin(0.1), abs=ROUND_OFF)


@pytest.mark.parametrize("first", [A, None])
def test_revolute_discrete_gradient_is_directional(first):
    g = constraints_of(joint(first))
    rng = np.random.default_rng(8)
    for _ in range(5):
        q0, q1 = rng.normal(size=(2, 24))
        step = g.jacobian(0.5 * (q0 + q1)) @ (q1 - q0)
        assert np.allclose(step, g.value(q1) - g.value(q0), rtol=0, atol=10 * ROUND_OFF)


@pytest.mark.parametrize("first", [A, None])
@pytest.mark.parametrize("reference", [None, (0.0, 0.0, 1.0)])
def test_angle_equals_the_rotation_about_the_axis(first, reference):
    angle = angle_of(joint(first, reference=reference))
    for a in np.linspace(-3.1, 3.1, 25):
        assert angle(opened(a)) == pytest.approx(a, abs=ROUND_OFF)


def test_angle_grows_steadily_over_several_revolutions():
    angle = angle_of(joint())
    turns = np.linspace(0, 20, 400)
    found = np.unwrap([angle(opened(a)) for a in turns])
    assert np.allclose(found, turns, rtol=0, atol=20 * ROUND_OFF)


def test_angle_changes_sign_with_the_axis_and_with_the_order_of_the_bodies():
    assert angle_of(joint(axis=-AXIS))(opened(0.7)) == pytest.approx(-0.7, abs=ROUND_OFF)
    assert angle_of(joint(B, A))(opened(0.7)) == pytest.approx(-0.7, abs=ROUND_OFF)


def test_a_revolute_without_angle_has_none_and_locks_the_same():
    j = joint(with_coordinates=False)
    assert j.coordinates(*frames(j.bodies)) == {}
    q = np.random.default_rng(9).normal(size=24)
    assert np.array_equal(constraints_of(j).value(q), constraints_of(joint()).value(q))


def test_constraints_and_angle_are_frame_invariant():
    """Under a superposed rigid motion the gap turns with it; everything else stays."""
    j = joint()
    f = QuadraticMap([*j.constraints(*frames(j.bodies)), *angle_functions(j)], 24)
    q = np.random.default_rng(10).normal(size=24)  # far from the manifold
    before, after = f.value(q), f.value(moved(q))
    assert np.allclose(after[:3], TURN @ before[:3], rtol=0, atol=10 * ROUND_OFF)
    assert np.linalg.norm(after[:3]) == pytest.approx(np.linalg.norm(before[:3]), rel=ROUND_OFF)
    assert np.allclose(after[3:], before[3:], rtol=0, atol=10 * ROUND_OFF)


def test_a_joint_to_the_ground_is_not_frame_invariant():
    """The claim above is not empty."""
    g = constraints_of(joint(None))
    assert np.max(np.abs(g.value(moved(opened(0.3))))) > 1.0


def test_joint_forces_of_a_step_have_neither_resultant_nor_moment():
    """G(q_mid) maps rigid motions of the whole to zero if both ends of the step fulfil Phi = 0;
    this is what conserves linear and angular momentum, for the joint forces and for the torque."""
    j = joint()
    f = QuadraticMap([*j.constraints(*frames(j.bodies)), *angle_functions(j)], 24)
    q0, q1 = opened(0.3), moved(opened(1.1))
    q_mid = 0.5 * (q0 + q1)
    G = f.jacobian(q_mid)
    for axis in np.eye(3):
        translation = np.tile(np.concatenate([axis, np.zeros(9)]), 2)
        rotation = np.cross(axis, q_mid.reshape(-1, 3)).ravel()
        assert np.max(np.abs(G @ translation)) <= ROUND_OFF
        assert np.max(np.abs(G @ rotation)) <= 10 * ROUND_OFF


def turbine():
    parts = rigid_turbine(MPI.COMM_SELF)
    bodies = [p for p in parts if isinstance(p, RigidBody)]
    joints = {p.name: p for p in parts if isinstance(p, Revolute)}
    slots = {b.name: BodyFrame(b, 4 * k) for k, b in enumerate(bodies)}

    def map_of(j, functions):
        pair = [BodyFrame(None) if b is None else slots[b.name] for b in j.bodies]
        return QuadraticMap(functions(*pair), 60)

    return bodies, joints, map_of


def test_turbine_angles_have_the_signs_of_the_paper():
    """Each bearing opened alone by 0.4 about the outward or inertial axis named in the paper."""
    bodies, joints, map_of = turbine()
    assert [b.name for b in bodies] == ["nacelle", "hub", "blade_1", "blade_2", "blade_3"]
    out = {k: np.asarray(bodies[1 + k].directors)[:, 1] for k in (1, 2, 3)}
    e1, e2, e3 = np.eye(3)
    s60, c60 = np.sin(np.pi / 3), 0.5
    assert np.allclose(out[1], s60 * e1 - c60 * e2, rtol=0, atol=ROUND_OFF)
    assert np.allclose(out[2], e2, rtol=0, atol=ROUND_OFF)
    assert np.allclose(out[3], -s60 * e1 - c60 * e2, rtol=0, atol=ROUND_OFF)
    cases = {
        "yaw": (e2, 0, -0.4),
        "rotor": (e3, 1, 0.4),
        "pitch_1": (out[1], 2, 0.4),
        "pitch_2": (out[2], 3, -0.4),
        "pitch_3": (out[3], 4, 0.4),
    }
    q = np.concatenate([b.coordinates for b in bodies])
    for name, (axis, body, expected) in cases.items():
        j = joints[name]
        y = q.reshape(5, 4, 3).copy()
        R = rotation_about(axis, 0.4)
        y[body, 1:] = y[body, 1:] @ R.T
        y[body, 0] = R @ (y[body, 0] - j.point) + j.point
        c, s = map_of(j, lambda *of, j=j: angle_functions(j, *of)).value(y.ravel())
        assert np.arctan2(s, c) == pytest.approx(expected, abs=ROUND_OFF), name
        assert np.max(np.abs(map_of(j, j.constraints).value(y.ravel()))) <= 10 * ROUND_OFF, name


def test_turbine_angles_are_the_bilinear_forms_of_the_design():
    """Cosine and sine for arbitrary directors, as tabulated beside the resolved misprints."""
    _, joints, map_of = turbine()
    q = np.random.default_rng(11).normal(size=60)
    d = q.reshape(5, 4, 3)  # d[i - 1, j] is d_ij of the paper
    e1, _, e3 = np.eye(3)
    S, C = np.sin(np.pi / 3), 0.5
    table = {
        "yaw": (d[0, 3] @ e3, -d[0, 3] @ e1),
        "rotor": (d[1, 2] @ d[0, 2], -d[1, 2] @ d[0, 1]),
        "pitch_1": (d[2, 3] @ d[1, 3], -d[2, 3] @ (C * d[1, 1] + S * d[1, 2])),
        "pitch_2": (d[3, 3] @ d[1, 3], -d[3, 3] @ d[1, 1]),
        "pitch_3": (d[4, 3] @ d[1, 3], -d[4, 3] @ (C * d[1, 1] - S * d[1, 2])),
    }
    for name, expected in table.items():
        j = joints[name]
        assert np.allclose(
            map_of(j, lambda *of, j=j: angle_functions(j, *of)).value(q),
            expected,
            rtol=0,
            atol=10 * ROUND_OFF,
        )


def test_rigid_turbine_has_full_rank_and_one_degree_of_freedom_per_bearing():
    bodies, joints, map_of = turbine()
    rows = [map_of(j, j.constraints).jacobian for j in joints.values()]
    for k, b in enumerate(bodies):
        rows.append(QuadraticMap(BodyFrame(b, 4 * k).internal_constraints(), 60).jacobian)
    q = np.concatenate([b.coordinates for b in bodies])
    G = np.vstack([f(q) for f in rows])
    G = G / np.linalg.norm(G, axis=1)[:, None]
    assert G.shape == (55, 60)  # the sixty constraints of the paper with the five of the angles
    assert np.linalg.svd(G, compute_uv=False)[-1] > 1e-3  # blades weigh lever arms of 30 m


def test_axis_and_reference_need_no_unit_length():
    """Lengths drop out, so that constraints keep their scale."""
    q = np.random.default_rng(12).normal(size=24)
    a = constraints_of(joint(reference=(0, 0, 1))).value(q)
    b = constraints_of(joint(axis=100 * AXIS, reference=(0, 0, 0.01))).value(q)
    assert np.allclose(a, b, rtol=0, atol=10 * ROUND_OFF)
    assert np.allclose(unit(AXIS), unit(100 * AXIS), rtol=0, atol=ROUND_OFF)


def test_a_reference_along_the_axis_is_refused():
    j = joint(reference=AXIS)
    with pytest.raises(ValueError, match="is parallel to the axis"):
        j.constraints(*frames(j.bodies))

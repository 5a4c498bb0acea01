"""Claims about all joints: what they lock, what their coordinates measure, what they conserve."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import turbine_fenicsx
from turbine_fenicsx import Cylindrical, Planar, Prismatic, Revolute, Rigid, Spherical, Universal
from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.quadratic import QuadraticMap
from turbine_fenicsx.foundation.rotations import frame_with_axis, rotation_about, skew, unit
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.joints.coordinates import Angle

POINT, AXIS = np.array([0.5, -1.0, 2.0]), np.array([1.0, 2.0, -0.5])
T1, T2, N = frame_with_axis(AXIS, (0.0, 0.0, 1.0)).T
SECOND_AXIS = 3.0 * np.cross(AXIS, [1.0, 0.0, 0.3])
A = RigidBody("a", 2.0, (1, 2, 3), position=(1, 2, 3), directors=rotation_about((1, 0, 2), 0.7))
B = RigidBody("b", 3.0, (4, 2, 3), position=(-1, 0, 2), directors=rotation_about((0, 1, 2), -1.9))
TURN, SHIFT = rotation_about((1.0, -0.3, 0.4), 2.2), np.array([3.0, -5.0, 4.0])
INTERNAL = [c for k in (0, 4) for c in BodyFrame(A, k).internal_constraints()]
ROUND_OFF = 1e-13
"""Sums of some dozens of products of numbers up to about five."""


@dataclass
class Kind:
    """What a kind of joint should do.

    ``motion`` maps values of the free motions to the rotation about the joint point and the shift
    of the second partner, seen from the first; the joint coordinates ``names`` are these values.
    """

    make: Any
    locked: int
    names: tuple
    motion: Any


def turn(angle, axis=N):
    return rotation_about(axis, angle)


KINDS = {
    "rigid": Kind(lambda a, b: Rigid("j", a, b, POINT), 6, (), lambda: (np.eye(3), 0 * N)),
    "revolute": Kind(
        lambda a, b: Revolute("j", a, b, point=POINT, axis=AXIS),
        5,
        ("j",),
        lambda x: (turn(x), 0 * N),
    ),
    "prismatic": Kind(
        lambda a, b: Prismatic("j", a, b, point=POINT, axis=AXIS),
        5,
        ("j",),
        lambda x: (np.eye(3), x * N),
    ),
    "cylindrical": Kind(
        lambda a, b: Cylindrical("j", a, b, point=POINT, axis=AXIS, reference=(0, 0, 1)),
        4,
        ("j.angle", "j.displacement"),
        lambda x, y: (turn(x), y * N),
    ),
    "universal": Kind(
        lambda a, b: Universal("j", a, b, point=POINT, first_axis=AXIS, second_axis=SECOND_AXIS),
        4,
        ("j.first", "j.second"),
        lambda x, y: (turn(x) @ turn(y, SECOND_AXIS), 0 * N),
    ),
    "spherical": Kind(
        lambda a, b: Spherical("j", a, b, POINT),
        3,
        (),
        lambda x, y, z: (turn(x) @ turn(y, T1) @ turn(z, T2), 0 * N),
    ),
    "planar": Kind(
        lambda a, b: Planar("j", a, b, point=POINT, normal=AXIS, reference=(0, 0, 1)),
        3,
        ("j.first", "j.second", "j.angle"),
        lambda x, y, z: (turn(z), x * T1 + y * T2),
    ),
}
PARTNERS = {"both": (A, B), "ground first": (None, B), "ground second": (A, None)}
all_kinds = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
all_partners = pytest.mark.parametrize("partners", PARTNERS.values(), ids=PARTNERS)


def frames(bodies):
    slots = {None: -1, A: 0, B: 4}
    return [BodyFrame(b, slots[b]) for b in bodies]


def constraints_of(j):
    return QuadraticMap(j.constraints(*frames(j.bodies)), 24)


def coordinates_of(j):
    return j.coordinates(*frames(j.bodies))


def functions_of(j):
    """Cosines, sines and displacements of all joint coordinates."""
    return QuadraticMap([f for c in coordinates_of(j).values() for f in c], 24)


def measured(j, q):
    """The joint coordinates, angles between -pi and pi."""
    values = []
    for c in coordinates_of(j).values():
        f = QuadraticMap(list(c), 24).value(q)
        values.append(np.arctan2(f[1], f[0]) if isinstance(c, Angle) else f[0])
    return np.array(values)


def moved(q, R=TURN, shift=SHIFT, about=(0.0, 0.0, 0.0)):
    """Coordinates after a superposed rotation about a point and a translation."""
    y = q.reshape(-1, 3) @ R.T
    y[::4] += shift + about - R @ about
    return y.ravel()


def position(partners, R, shift):
    """Both bodies where the second partner has moved by R and shift, seen from the first."""
    a, b = A.coordinates, B.coordinates
    if partners[1] is None:
        a = moved(a, R.T, -R.T @ shift, POINT)
    else:
        b = moved(b, R, shift, POINT)
    return np.concatenate([a, b])


def n_free(kind):
    return 6 - kind.locked


def some_values(kind, count=4, seed=0, size=1.3):
    return np.random.default_rng(seed).uniform(-size, size, (count, n_free(kind)))


def moving(partners):
    """The entries of q, in rows of three, of the partner that moves."""
    return slice(0, 4) if partners[1] is None else slice(4, 8)


def relative_motions(partners, q):
    """Rates of q for translations and rotations, about the joint point, of that partner."""
    y, mine, columns = q.reshape(8, 3), moving(partners), []
    for translation, axis in [*((e, 0 * e) for e in np.eye(3)), *((0 * e, e) for e in np.eye(3))]:
        rates = np.zeros((8, 3))
        rates[mine] = np.cross(axis, y[mine])
        rates[mine][0] += translation - np.cross(axis, POINT)
        columns.append(rates.ravel())
    return np.column_stack(columns)


def test_these_are_all_joints_there_are():
    kinds = {
        name
        for name in turbine_fenicsx.__all__
        if hasattr(getattr(turbine_fenicsx, name), "constraints")
    }
    assert {type(k.make(A, B)).__name__ for k in KINDS.values()} == kinds - {"Joint"}


@all_kinds
@all_partners
def test_joint_is_a_joint_of_its_partners(kind, partners):
    j = kind.make(*partners)
    assert isinstance(j, Joint)
    assert j.bodies == partners
    assert tuple(coordinates_of(j)) == kind.names


@all_kinds
@all_partners
def test_joint_locks_what_it_should_with_full_rank_in_all_positions(kind, partners):
    j = kind.make(*partners)
    rows = QuadraticMap([*INTERNAL, *j.constraints(*frames(partners))], 24)
    assert rows.shape[0] == 12 + kind.locked
    for values in some_values(kind):
        G = rows.jacobian(position(partners, *kind.motion(*values)))
        assert np.linalg.svd(G, compute_uv=False)[-1] > 0.05


@all_kinds
@all_partners
def test_constraints_vanish_in_all_positions_that_the_joint_admits(kind, partners):
    g = constraints_of(kind.make(*partners))
    for values in [np.zeros(n_free(kind)), *some_values(kind, 6, 1, 12.0)]:
        q = position(partners, *kind.motion(*values))
        assert np.max(np.abs(g.value(q))) <= 10 * ROUND_OFF


@all_kinds
@all_partners
def test_joint_notices_each_motion_that_it_locks_and_no_other(kind, partners):
    g = constraints_of(kind.make(*partners))
    for values in some_values(kind, 3, 2):
        q = position(partners, *kind.motion(*values))
        _, s, V = np.linalg.svd(g.jacobian(q) @ relative_motions(partners, q))
        assert np.count_nonzero(s > 0.05) == kind.locked
        for motion in V[: kind.locked]:  # finite ones, which have no first order
            other, mine, length = q.reshape(8, 3).copy(), moving(partners), 0.1
            R = np.eye(3)
            if np.linalg.norm(motion[3:]) > 0.1:
                R = rotation_about(motion[3:], length * np.linalg.norm(motion[3:]))
            other[mine] = moved(other[mine], R, length * motion[:3], POINT).reshape(4, 3)
            assert np.max(np.abs(g.value(other.ravel()))) > 1e-3
        for k in range(n_free(kind)):
            ends = [
                position(partners, *kind.motion(*(values + h * np.eye(n_free(kind))[k])))
                for h in (-1e-5, 1e-5)
            ]
            free = (ends[1] - ends[0]) / 2e-5
            assert np.max(np.abs(g.jacobian(q) @ free)) <= 1e-9  # of second differences


@all_kinds
@all_partners
def test_discrete_gradients_are_directional(kind, partners):
    j = kind.make(*partners)
    rng = np.random.default_rng(8)
    for f in (constraints_of(j), functions_of(j)):
        for _ in range(3):
            q0, q1 = rng.normal(size=(2, 24))
            step = f.jacobian(0.5 * (q0 + q1)) @ (q1 - q0)
            assert np.allclose(step, f.value(q1) - f.value(q0), rtol=0, atol=10 * ROUND_OFF)


WITH_COORDINATES = {name: k for name, k in KINDS.items() if k.names}
with_coordinates = pytest.mark.parametrize("kind", WITH_COORDINATES.values(), ids=WITH_COORDINATES)


@with_coordinates
@all_partners
def test_coordinates_are_the_free_motions_with_their_signs(kind, partners):
    j = kind.make(*partners)
    for values in [np.zeros(n_free(kind)), *some_values(kind, 6, 3, 3.1)]:
        found = measured(j, position(partners, *kind.motion(*values)))
        assert np.allclose(found, values, rtol=0, atol=10 * ROUND_OFF)


@with_coordinates
def test_coordinates_grow_steadily_over_several_turns(kind):
    j, way = kind.make(A, B), np.array([1.0, -0.7, 0.9])[: n_free(kind)]
    parameters = np.linspace(0, 20, 300)
    found = np.array([measured(j, position((A, B), *kind.motion(*(t * way)))) for t in parameters])
    for k, c in enumerate(coordinates_of(j).values()):
        series = np.unwrap(found[:, k]) if isinstance(c, Angle) else found[:, k]
        assert np.allclose(series, parameters * way[k], rtol=0, atol=100 * ROUND_OFF)


@with_coordinates
def test_coordinates_do_not_notice_a_motion_of_both_partners(kind):
    j = kind.make(A, B)
    for values in some_values(kind, 3, 4):
        q = moved(position((A, B), *kind.motion(*values)))
        assert np.allclose(measured(j, q), values, rtol=0, atol=20 * ROUND_OFF)


@pytest.mark.parametrize("name", ["revolute", "prismatic", "cylindrical"])
def test_coordinates_change_sign_with_the_order_of_the_partners(name):
    kind = KINDS[name]
    for values in some_values(kind, 3, 5):
        q = position((A, B), *kind.motion(*values))
        assert np.allclose(measured(kind.make(B, A), q), -values, rtol=0, atol=10 * ROUND_OFF)


@all_kinds
def test_constraints_and_coordinates_are_frame_invariant(kind):
    """Under a superposed rigid motion the gap turns with it; everything else stays."""
    j, q = kind.make(A, B), np.random.default_rng(10).normal(size=24)  # far from the manifold
    before, after = (constraints_of(j).value(x) for x in (q, moved(q)))
    gap = 3 if isinstance(j, Rigid | Revolute | Universal | Spherical) else 0
    assert np.allclose(after[:gap], TURN[:gap, :gap] @ before[:gap], rtol=0, atol=50 * ROUND_OFF)
    assert np.allclose(after[gap:], before[gap:], rtol=0, atol=50 * ROUND_OFF)
    f = functions_of(j)
    assert np.allclose(f.value(moved(q)), f.value(q), rtol=0, atol=50 * ROUND_OFF)


@all_kinds
def test_a_joint_to_the_ground_is_not_frame_invariant(kind):
    """The claim above is not empty."""
    for partners in ((None, B), (A, None)):
        q = position(partners, *kind.motion(*some_values(kind, 1)[0]))
        assert np.max(np.abs(constraints_of(kind.make(*partners)).value(moved(q)))) > 0.5


@all_kinds
def test_joint_forces_of_a_step_have_neither_resultant_nor_moment(kind):
    """G(q_mid) maps rigid motions of the whole to zero where both ends fulfil the constraints."""
    j, (first, last) = kind.make(A, B), some_values(kind, 2, 6)
    q0 = position((A, B), *kind.motion(*first))
    q1 = moved(position((A, B), *kind.motion(*last)))
    q_mid = 0.5 * (q0 + q1)
    for f in (constraints_of(j), functions_of(j)):
        G = f.jacobian(q_mid)
        for axis in np.eye(3):
            translation = np.tile(np.concatenate([axis, np.zeros(9)]), 2)
            rotation = (q_mid.reshape(-1, 3) @ skew(axis).T).ravel()
            assert np.max(np.abs(G @ translation), initial=0.0) <= 10 * ROUND_OFF
            assert np.max(np.abs(G @ rotation), initial=0.0) <= 50 * ROUND_OFF


@pytest.mark.parametrize(
    ("joint", "axes"),
    [
        (Revolute, {"axis": AXIS}),
        (Prismatic, {"axis": AXIS}),
        (Cylindrical, {"axis": AXIS}),
        (Planar, {"normal": AXIS}),
        (Universal, {"first_axis": AXIS, "second_axis": SECOND_AXIS}),
    ],
)
def test_a_joint_without_coordinates_locks_the_same(joint, axes):
    q = np.random.default_rng(9).normal(size=24)
    full = joint("j", A, B, point=POINT, **axes)
    bare = joint("j", A, B, point=POINT, **axes, with_coordinates=False)
    assert coordinates_of(bare) == {}
    assert np.array_equal(constraints_of(bare).value(q), constraints_of(full).value(q))


def test_lengths_of_axes_drop_out():
    q = np.random.default_rng(12).normal(size=24)
    for joint, name in ((Prismatic, "axis"), (Cylindrical, "axis"), (Planar, "normal")):
        short, long = (joint("j", A, B, point=POINT, **{name: s * AXIS}) for s in (0.01, 30.0))
        for of in (constraints_of, functions_of):
            assert np.allclose(of(short).value(q), of(long).value(q), rtol=0, atol=50 * ROUND_OFF)
    assert np.allclose(unit(0.01 * AXIS), N, rtol=0, atol=ROUND_OFF)


def test_axes_of_a_universal_joint_must_be_perpendicular():
    with pytest.raises(ValueError, match="axes of universal joint 'u' must be perpendicular, got"):
        Universal("u", A, B, point=POINT, first_axis=(1, 0, 0), second_axis=(1, 1, 0))


AXES = {Revolute: "axis", Prismatic: "axis", Cylindrical: "axis", Planar: "normal"}


@pytest.mark.parametrize("joint", AXES)
@pytest.mark.parametrize("axis", [(0, 0, 0), (1, 0), (np.nan, 0, 0), (np.inf, 0, 0), "up"])
def test_an_axis_that_is_no_direction_is_refused(joint, axis):
    with pytest.raises(ValueError, match="of 'j' must be a direction, three numbers that are not"):
        joint("j", A, B, point=POINT, **{AXES[joint]: axis})


@pytest.mark.parametrize("joint", [Revolute, Cylindrical, Planar])
def test_a_reference_along_the_axis_is_refused(joint):
    with pytest.raises(ValueError, match="is parallel to the axis"):
        constraints_of(joint("j", A, B, point=POINT, **{AXES[joint]: AXIS}, reference=2.0 * AXIS))


@pytest.mark.parametrize("point", [(1.0, 2.0), (0.0, np.nan, 0.0), 3.0, None])
@pytest.mark.parametrize(
    "joint", [Revolute, Prismatic, Cylindrical, Planar, Spherical, Rigid, Universal]
)
def test_a_point_that_is_none_is_refused(joint, point):
    axes = {AXES[joint]: AXIS} if joint in AXES else {}
    if joint is Universal:
        axes = {"first_axis": (1, 0, 0), "second_axis": (0, 1, 0)}
    with pytest.raises(ValueError, match="point of 'j' must be three numbers, got"):
        joint("j", A, B, point=point, **axes)

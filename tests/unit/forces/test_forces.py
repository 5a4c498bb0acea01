"""Claims about forces that depend on the motion: exact work, energy, dissipation, resultants."""

import numpy as np
import pytest

from turbine_fenicsx import JointDamper, JointSpring, PointDamper, PointSpring
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.force import Force, Layout, StepTimes
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.system import MultibodySystem

A = RigidBody("a", 2.0, (1, 2, 3), position=(1, 2, 3), directors=rotation_about((1, 0, 2), 0.7))
B = RigidBody("b", 3.0, (4, 2, 3), position=(-1, 0, 2), directors=rotation_about((0, 1, 2), -1.9))
P, Q = np.array([2.0, 0.5, -1.0]), np.array([-3.0, 1.5, 0.5])
LAYOUT = Layout({A: 0, B: 12}, {"j": 24})
DT = 0.2
SPRINGS = {
    "joint spring": JointSpring("e", "j", 40.0, 0.3),
    "point spring": PointSpring(
        "e", A, B, first_point=P, second_point=Q, stiffness=40.0, length=3.0
    ),
    "initial length": PointSpring("e", A, B, first_point=P, second_point=Q, stiffness=40.0),
    "no length": PointSpring("e", A, B, first_point=P, second_point=Q, stiffness=40.0, length=0.0),
    "ground first": PointSpring(
        "e", None, B, first_point=P, second_point=Q, stiffness=40.0, length=3.0
    ),
    "ground second": PointSpring(
        "e", A, None, first_point=P, second_point=Q, stiffness=40.0, length=3.0
    ),
}
DAMPERS = {
    "joint damper": JointDamper("e", "j", 7.0),
    "point damper": PointDamper("e", A, B, first_point=P, second_point=Q, damping=7.0),
    "damper to ground": PointDamper("e", None, B, first_point=P, second_point=Q, damping=7.0),
}
ALL = SPRINGS | DAMPERS
ROUND_OFF = 1e-13


def each(elements):
    return pytest.mark.parametrize("element", elements.values(), ids=elements)


def some_steps(element, count=4, size=1.0):
    """The bound element and ends of steps near the initial position, of any length."""
    bound, rng = element.bind(LAYOUT), np.random.default_rng(1)
    y = np.concatenate([A.coordinates, B.coordinates, [0.2]])[bound.index]
    for _ in range(count):
        y0 = y + 0.2 * rng.normal(size=y.size)
        yield bound, y0, y0 + size * rng.normal(size=y.size)


def force(bound, y0, y1, dt=DT):
    return bound.force(y0, y1, StepTimes.from_start(0.0, dt))


def distance(element, bound, y):
    """Distance of both points from the coordinates of the bodies."""
    points, start = [], 0
    for body, point in (
        (element.first, element.first_point),
        (element.second, element.second_point),
    ):
        if body is None:
            points.append(point)
        else:
            q = y[start : start + 12].reshape(4, 3)
            points.append(q[0] + body.body_coordinates(point) @ q[1:])
            start += 12
    return np.linalg.norm(points[1] - points[0])


@each(ALL)
def test_elements_are_elements(element):
    assert isinstance(element, Force)
    kind = "dissipative" if element in DAMPERS.values() else "conservative"
    assert element.kind == kind and element.name == "e"


@each(ALL)
@pytest.mark.parametrize("size", [1.0, 1e-3, 0.0])
def test_derivative_agrees_with_finite_differences(element, size):
    h = 1e-6
    for bound, y0, y1 in some_steps(element, size=size):
        f, K = force(bound, y0, y1)
        columns = [
            (force(bound, y0, y1 + h * e)[0] - force(bound, y0, y1 - h * e)[0]) / (2 * h)
            for e in np.eye(y1.size)
        ]
        assert f.shape == y0.shape
        assert np.allclose(K, np.column_stack(columns), rtol=0, atol=3e-7)


@each(SPRINGS)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_work_of_a_spring_is_exactly_the_loss_of_its_energy(element, size):
    for bound, y0, y1 in some_steps(element, size=size):
        work, energies = force(bound, y0, y1)[0] @ (y1 - y0), (bound.energy(y0), bound.energy(y1))
        assert min(energies) >= 0.0
        assert work == pytest.approx(energies[0] - energies[1], abs=ROUND_OFF * sum(energies))


def test_energy_of_springs_is_half_the_stiffness_times_the_square_of_the_elongation():
    bound = SPRINGS["joint spring"].bind(LAYOUT)
    assert bound.energy(np.array([0.8])) == pytest.approx(20.0 * 0.25, rel=1e-15)
    for name, length in (("point spring", 3.0), ("no length", 0.0), ("ground first", 3.0)):
        for bound, y, _ in some_steps(SPRINGS[name]):
            elongation = distance(SPRINGS[name], bound, y) - length
            assert bound.energy(y) == pytest.approx(20.0 * elongation**2, rel=1e-12)


def test_a_point_spring_without_a_length_is_at_rest_initially():
    spring = SPRINGS["initial length"]
    bound = spring.bind(LAYOUT)
    y = np.concatenate([A.coordinates, B.coordinates])
    assert bound.energy(y) <= 1e-28
    assert np.max(np.abs(force(bound, y, y)[0])) <= 1e-12  # 40 N/m, round-off, levers


@each(DAMPERS)
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_a_damper_dissipates_exactly_the_square_of_its_rate(element, size):
    for bound, y0, y1 in some_steps(element, size=size):
        work = force(bound, y0, y1)[0] @ (y1 - y0)
        if isinstance(element, JointDamper):
            change = float((y1 - y0)[0])
        else:
            change = distance(element, bound, y1) - distance(element, bound, y0)
        assert work <= 0.0 and bound.energy(y1) == 0.0
        assert -work == pytest.approx(7.0 * change**2 / DT, rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("name", ["point spring", "no length", "point damper"])
def test_forces_between_points_have_neither_resultant_nor_moment(name):
    for bound, y0, y1 in some_steps(ALL[name]):
        f, middle = force(bound, y0, y1)[0].reshape(8, 3), 0.5 * (y0 + y1).reshape(8, 3)
        size = np.max(np.abs(f))
        assert size > 0.1
        assert np.max(np.abs(f[::4].sum(axis=0))) <= ROUND_OFF * size
        assert np.max(np.abs(np.cross(middle, f).sum(axis=0))) <= 100 * ROUND_OFF * size


@pytest.mark.parametrize("name", ["point spring", "point damper"])
def test_the_force_acts_along_the_line_of_the_points_at_the_middle(name):
    for bound, y0, y1 in some_steps(ALL[name]):
        f, middle = force(bound, y0, y1)[0].reshape(8, 3), 0.5 * (y0 + y1)
        line = np.zeros(3)
        for sign, body, point, q in ((-1, A, P, middle[:12]), (1, B, Q, middle[12:])):
            q = q.reshape(4, 3)
            line += sign * (q[0] + body.body_coordinates(point) @ q[1:])
        assert np.linalg.norm(np.cross(f[0], line)) <= 1e-13 * np.linalg.norm(f[0]) * 10


EVEN = RigidBody("even", 1.0, (1, 1, 1))  # no round-off in its points
FAR = np.array([31.234, -57.1, 103.3])
FAR_A = RigidBody(
    "a", 2.0, (1, 2, 3), position=(130.0, 5.0, 2.0), directors=rotation_about((1, 0, 2), 0.7)
)
FAR_B = RigidBody(
    "b", 3.0, (4, 2, 3), position=(-41.0, 7.0, 2.0), directors=rotation_about((0, 1, 2), -1.9)
)


@pytest.mark.parametrize("length", [None, 0.0, 0.5])
def test_a_spring_between_points_that_coincide_is_no_number_out_of_nothing(length):
    """Also far from the origin, where the square of the distance may round below zero."""
    layout = Layout({FAR_A: 0, FAR_B: 12}, {})
    y = np.concatenate([FAR_A.coordinates, FAR_B.coordinates])
    spring = PointSpring(
        "s", FAR_A, FAR_B, first_point=FAR, second_point=FAR, stiffness=1e6, length=length
    )
    damper = PointDamper("d", FAR_A, FAR_B, first_point=FAR, second_point=FAR, damping=1e3)
    for element in (spring, damper):
        f, K = force(element.bind(layout), y, y)
        assert np.all(np.isfinite(f)) and np.all(np.isfinite(K))
    energy = spring.bind(layout).energy(y)
    assert energy == pytest.approx(0.5e6 * (length or 0.0) ** 2, rel=1e-12, abs=1e-20)


def test_a_spring_of_no_length_is_stiff_from_the_start():
    """Its force is linear, so it needs no direction: a bushing."""
    for body in (A, EVEN):
        bound = PointSpring("s", None, body, first_point=P, second_point=P, stiffness=40.0).bind(
            Layout({body: 0}, {})
        )
        y = body.coordinates
        f, K = force(bound, y, y)
        assert np.allclose(K[:3, :3], -20.0 * np.eye(3), rtol=0, atol=1e-12)  # half the stiffness
        assert np.allclose(f, 0.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("make", [PointSpring, PointDamper])
def test_points_that_coincide_exactly_have_no_direction_and_no_force(make):
    options = {"stiffness": 40.0, "length": 1.0} if make is PointSpring else {"damping": 40.0}
    options |= {"first_point": P, "second_point": P}
    bound = make("s", None, EVEN, **options).bind(Layout({EVEN: 0}, {}))
    y = EVEN.coordinates
    f, K = force(bound, y, y)
    assert np.all(f == 0.0) and np.all(K == 0.0)


def test_a_short_distance_far_from_the_origin_is_precise():
    """A millimetre at a hundred metres: the energy to ten digits."""
    spring = PointSpring(
        "s",
        None,
        FAR_A,
        first_point=FAR + 1e-3 * np.eye(3)[0],
        second_point=FAR,
        stiffness=2.0,
        length=0.0,
    )
    bound = spring.bind(Layout({FAR_A: 0}, {}))
    assert bound.energy(FAR_A.coordinates) == pytest.approx(1e-6, rel=1e-10)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: JointSpring("s", "j", -1.0), "stiffness of 's' must not be negative, got -1"),
        (lambda: JointSpring("s", "j", np.nan), "stiffness of 's' must not be negative, got nan"),
        (lambda: JointSpring("s", "j", 1.0, np.inf), "rest of 's' must be a number, got inf"),
        (lambda: JointDamper("s", "j", -2.0), "damping of 's' must not be negative, got -2"),
        (
            lambda: PointDamper("s", A, B, first_point=P, second_point=Q, damping=-1),
            "damping of 's' must not be negative, got -1",
        ),
        (
            lambda: PointSpring("s", A, B, first_point=P, second_point=Q, stiffness=-1),
            "stiffness of 's' must not be negative",
        ),
        (
            lambda: PointSpring("s", A, B, first_point=P, second_point=Q, stiffness=1, length=-3),
            "length of 's' must not be negative, got -3",
        ),
        (
            lambda: PointSpring("s", A, B, first_point=P[:2], second_point=Q, stiffness=1),
            "first point of 's' must be three numbers",
        ),
        (
            lambda: PointDamper("s", A, B, first_point=P, second_point=(1, 2, np.nan), damping=1),
            r"second point of 's' must be three numbers, got \(1, 2, nan\)",
        ),
        (
            lambda: PointSpring("s", A, A, first_point=P, second_point=Q, stiffness=1),
            "both ends of 's' are on 'a'",
        ),
        (
            lambda: PointDamper("s", None, None, first_point=P, second_point=Q, damping=1),
            "both ends of 's' are on the ground",
        ),
    ],
)
def test_mistakes_are_refused_in_a_sentence(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize(("body", "got"), [("a", "str 'a'"), (3.0, "float 3.0")])
def test_an_end_must_be_a_rigid_body_or_the_ground(body, got):
    with pytest.raises(TypeError, match=f"'s' needs a rigid body, got {got}"):
        PointSpring("s", body, A, first_point=P, second_point=Q, stiffness=1.0)


def test_unknown_partners_are_refused_by_name(comm):
    stranger = RigidBody("stranger", 1.0, (1, 1, 1))
    for element in (
        PointSpring("s", A, stranger, first_point=P, second_point=Q, stiffness=1.0),
        PointDamper("s", stranger, None, first_point=P, second_point=Q, damping=1.0),
    ):
        with pytest.raises(ValueError, match="rigid body 'stranger' is not among the parts"):
            MultibodySystem(comm, [A, B, element])
    for element in (JointSpring("s", "k", 1.0), JointDamper("s", "k", 1.0)):
        with pytest.raises(ValueError, match=r"no joint coordinate 'k'; there are \[\]"):
            MultibodySystem(comm, [A, B, element])


def test_names_of_elements_must_be_unique(comm):
    parts = [
        A,
        B,
        PointSpring("e", A, B, first_point=P, second_point=Q, stiffness=1.0),
        PointDamper("e", A, B, first_point=P, second_point=Q, damping=1.0),
    ]
    with pytest.raises(ValueError, match=r"names must be unique, but \['e'\] occur more than once"):
        MultibodySystem(comm, parts)

"""Claims about joints that are open, or say nothing new, in the initial configuration."""

import logging
from dataclasses import dataclass

import numpy as np
import pytest

from turbine_fenicsx import Revolute, Spherical
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.quadratic import dot
from turbine_fenicsx.system.system import MultibodySystem

E1, E2, E3 = np.eye(3)
INERTIA = (0.1, 0.2, 0.3)
A = RigidBody("a", 1.0, INERTIA)
B = RigidBody("b", 1.0, INERTIA, position=2.0 * E1)


@dataclass(frozen=True, eq=False)
class Pin:
    """A point of each body in one place, and directions at right angles."""

    name: str
    first: RigidBody | None
    second: RigidBody
    points: tuple = ((1, 0, 0), (1, 0, 0))
    directions: tuple = ()
    cosine: float = 0.0

    @property
    def bodies(self):
        return self.first, self.second

    def constraints(self, a, b):
        rows = list((b.point(self.points[1]) - a.point(self.points[0])).components())
        if self.directions:
            first, second = self.directions
            rows.append(dot(a.direction(first), b.direction(second)) - self.cosine)
        return rows

    def coordinates(self, a, b):
        return {}


@dataclass(frozen=True, eq=False)
class Rod(Pin):
    """Centres of mass that keep a distance."""

    length: float = 2.0

    def constraints(self, a, b):
        gap = b.point(self.second.position) - a.point((0, 0, 0))
        return [dot(gap, gap) - self.length**2]


def warnings(comm, parts, caplog):
    with caplog.at_level(logging.WARNING):
        MultibodySystem(comm, parts)
    return [r.getMessage() for r in caplog.records]


@pytest.mark.parametrize(
    ("joint", "told"),
    [
        (Pin("pin", A, B, ((0.8, 0, 0), (1, 0, 0))), r"'pin' by 0\.2 m \(allowed: \de-09\)"),
        (Pin("pin", None, B, ((1, 0, 3), (1, 0, 0))), r"'pin' by 3 m \(allowed"),
        (Pin("pin", A, B, directions=(E1, E1 + E2)), r"'pin' by 1 \(allowed"),
        (Rod("rod", A, B, length=1.0), r"'rod' by 3 m\^2 \(allowed"),
    ],
    ids=["of two bodies", "to the ground", "cosine", "distance"],
)
def test_an_open_joint_is_refused_with_its_name_and_its_gap(comm, joint, told):
    with pytest.raises(ModelError, match=told):
        MultibodySystem(comm, [A, B, joint])


def test_all_open_joints_are_named_at_once(comm):
    far = ((1, 0, 0), (1, 1e-3, 0))
    parts = [A, B, Pin("left", A, B, far), Spherical("good", A, B, E1), Pin("right", A, B, far)]
    with pytest.raises(ModelError, match=r"'left' by 0\.001 m .*, 'right' by 0\.001 m"):
        MultibodySystem(comm, parts)


@pytest.mark.parametrize("shift", [0.0, 1e6])
@pytest.mark.parametrize("part", [0.1, 10.0])
def test_what_may_be_open_is_a_part_of_the_lengths(comm, shift, part):
    """A round-off far from the origin is allowed, a hundredth of a micrometre near it is not."""
    body = RigidBody("b", 1.0, INERTIA, position=(shift, 0, 0))
    gap = part * 1e-9 * (2.0 * shift + 3.0)
    points = (np.array([shift + 1.0, 0, 0]), np.array([shift + 1.0 + gap, 0, 0]))
    joint = Pin("pin", None, body, points)
    if part < 1.0:
        MultibodySystem(comm, [body, joint])
    else:
        with pytest.raises(ModelError, match="'pin' by"):
            MultibodySystem(comm, [body, joint])


@pytest.mark.parametrize("place", [(6e-17, 1.0, 0.0), (6e-17, 0.0, 0.0)])
def test_round_off_of_a_component_that_should_be_zero_leaves_a_joint_closed(comm, place):
    """As of a sine and a cosine, beside which all terms of the row are as small."""
    body = RigidBody("b", 1.0, INERTIA, position=place)
    joint = Pin("pin", None, body, ((0.0, place[1], 0.0), place))
    MultibodySystem(comm, [body, joint])


def test_a_product_of_parallel_directions_is_told_as_what_it_is(comm, caplog):
    joint = Pin("pin", None, B, directions=(E1, E1), cosine=1.0)
    (told,) = warnings(comm, [B, joint], caplog)
    assert "1 of the constraints of joint 'pin' locks nothing in the initial configuration" in told
    assert "parallel directions" in told and "redundant" not in told


def four_bar(x):
    """Three bars of 1 m between hinges on the ground; on a line for x = 3."""
    ends = [np.zeros(3), np.array([0.5 * (x - 1.0), np.sqrt(1.0 - 0.25 * (x - 1.0) ** 2), 0])]
    ends += [ends[1] + E1, x * E1]
    bars = [
        RigidBody(f"bar {k}", 1.0, INERTIA, position=0.5 * (ends[k] + ends[k + 1]))
        for k in range(3)
    ]
    pairs = zip([None, *bars], [*bars, None], strict=True)
    return [*bars, *(Revolute(f"h{k}", *p, point=ends[k], axis=E3) for k, p in enumerate(pairs))]


@pytest.mark.parametrize(("x", "singular"), [(2.0, False), (3.0, True)])
def test_a_dead_centre_is_told_apart_from_redundancy(comm, caplog, x, singular):
    """A planar loop has three redundant constraints wherever it stands, on a line one more."""
    told = warnings(comm, four_bar(x), caplog)
    assert ("3 of 20 joint constraints are redundant (in joints h3)" in told[-1]) and (
        [t.startswith("1 of the constraints of joint 'h3' locks nothing") for t in told[:-1]]
        == [True] * singular
    )


def test_a_joint_between_two_bearings_is_redundant_and_no_dead_centre(comm, caplog):
    """A shaft in two spherical bearings of a frame, and a third one on the line between."""
    frame = RigidBody("frame", 3.0, INERTIA, position=(0.3, 0.2, 0.0))
    shaft = RigidBody("shaft", 2.0, INERTIA, position=0.5 * E3)
    yaw = Revolute("yaw", None, frame, point=0.3 * E1, axis=np.array([0.0, 1.0, 0.0]))
    bearings = [Spherical(f"b{k}", frame, shaft, x * E3) for k, x in enumerate((0.0, 1.0, 0.4))]
    (told,) = warnings(comm, [frame, shaft, yaw, *bearings], caplog)
    assert "joint constraints are redundant (in joints b1, b2)" in told
    assert "locks nothing" not in told

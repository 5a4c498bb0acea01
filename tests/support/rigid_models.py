"""Two rigid bodies in joints, for tests of rigid models and of their steps."""

import numpy as np

from turbine_fenicsx import (
    Cylindrical,
    FollowerForce,
    JointDamper,
    JointSpring,
    Planar,
    PointDamper,
    PointSpring,
    Revolute,
    Torque,
)
from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.forces.force import Layout
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.joints.coordinates import augmentation
from turbine_fenicsx.system.rigid_model import RigidModel

A = RigidBody("a", 2.0, (1, 2, 3), position=(1, 0, 0), directors=rotation_about((1, 0, 2), 0.7))
B = RigidBody("b", 3.0, (4, 2, 0.3), position=(1, 2, 0), directors=rotation_about((0, 1, 2), -1.9))
MASSES = np.concatenate([A.masses, B.masses])
N_Q = 24

HINGES = (
    Revolute("first", None, A, point=(0, 0, 0), axis=(1.0, 0.2, 3.0)),
    Revolute("second", A, B, point=(1, 1, 0), axis=(0.3, 1.0, 0.0)),
)
SLIDES = (
    Cylindrical("first", None, A, point=(0, 0, 0), axis=(1.0, 0.2, 3.0)),
    Planar("second", A, B, point=(1, 1, 0), normal=(0.3, 1.0, 0.0)),
)
SLIDE_NAMES = ("first.angle", "first.displacement", "second.first", "second.second", "second.angle")
RELATIONS = np.array([[0.0, 1.0, 0.0, 0.0, 0.0], [-0.3, 0.0, 0.0, 0.5, 1.0]])
ELEMENTS = (
    JointSpring("s", "second.first", 3.0, 0.2),
    JointDamper("d", "first.displacement", 2.0),
    PointSpring(
        "p", A, B, first_point=(1, 0, 2), second_point=(0, 1, 0), stiffness=5.0, length=0.5
    ),
    PointDamper("q", None, B, first_point=(1, 0, 2), second_point=(0, 1, 0), damping=0.7),
    FollowerForce("f", A, point=(0, 1, 0), force=(1, 2, -1)),
    Torque("t", B, (0.5, 1, -1), follower=True),
    Torque("u", B, (0.5, -1, 2)),
)


def functions(joints):
    """Constraints of the two bodies and of joints, and joint coordinates by name."""
    frames = {A: BodyFrame(A, 0), B: BodyFrame(B, 4), None: BodyFrame(None)}
    constraints = [c for b in (A, B) for c in frames[b].internal_constraints()]
    coordinates = {}
    for j in joints:
        pair = [frames[b] for b in j.bodies]
        constraints += j.constraints(*pair)
        coordinates |= j.coordinates(*pair)
    return constraints, coordinates


def hinged():
    """Two angles."""
    constraints, coordinates = functions(HINGES)
    return RigidModel(MASSES, constraints, list(coordinates.values()))


def sliding():
    """Angles and displacements, with relations, and with forces of all kinds."""
    constraints, coordinates = functions(SLIDES)
    assert tuple(coordinates) == SLIDE_NAMES
    layout = Layout({A: 0, B: 12}, {name: N_Q + k for k, name in enumerate(SLIDE_NAMES)})
    elements = [e.bind(layout) for e in ELEMENTS]
    return RigidModel(MASSES, constraints, list(coordinates.values()), RELATIONS, elements)


def constraint_values(model, form, q, angles):
    """Constraints at a configuration, those of the angles in the given form."""
    y = model.functions.value(q)
    c, s = y[model.c], y[model.s]
    Phi = augmentation(form, model.is_angle)(angles, angles, c, c, s, s).Phi
    return np.concatenate([y[model.g], Phi])

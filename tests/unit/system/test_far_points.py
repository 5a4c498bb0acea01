"""Claims about forces on points that are none of their bodies."""

import logging

import pytest
from dolfinx import mesh

from turbine_fenicsx import (
    FollowerForce,
    NodeForce,
    PointForce,
    PointSpring,
    Spherical,
    StVenantKirchhoff,
)
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.system.system import MultibodySystem

UP, FORCE = (0.0, 0.0, 2.0), (0.0, 500.0, 0.0)
BODY = RigidBody("body", 2.0, (1.0, 1.0, 2.0), position=(1.0, 0.0, 0.0))
"""Its radius of gyration is 1.4 m."""


def warnings(comm, caplog, *parts):
    with caplog.at_level(logging.WARNING):
        MultibodySystem(comm, parts)
    return [r.getMessage() for r in caplog.records] if comm.rank == 0 else []


def beam(comm):
    cells = mesh.create_box(comm, [[0, 0, 0], [10, 1, 1]], [3, 1, 1], mesh.CellType.hexahedron)
    return FlexibleBody("beam", cells, StVenantKirchhoff(1.0, 1.0), 1.0)


@pytest.mark.parametrize("kind", [PointForce, FollowerForce])
def test_point_and_force_that_were_swapped_are_told(comm, caplog, kind):
    assert warnings(comm, caplog, BODY, kind("push", BODY, point=UP, force=FORCE)) == []
    told = warnings(comm, caplog, BODY, kind("push", BODY, point=FORCE, force=UP))
    if comm.rank == 0:
        assert told == [
            "'push' acts on a point 500 m from the centre of 'body', whose size is some 1.4 m: is "
            "it a point of the body?"
        ]


def test_the_end_of_a_spring_is_looked_at_and_the_ground_is_everywhere(comm, caplog):
    ends = {"first_point": FORCE, "second_point": UP}
    assert not warnings(comm, caplog, BODY, PointSpring("s", None, BODY, **ends, stiffness=1.0))
    told = warnings(comm, caplog, BODY, PointSpring("s", BODY, None, **ends, stiffness=1.0))
    assert len(told) == (comm.rank == 0)


def test_joints_make_a_body_larger(comm, caplog):
    push = PointForce("push", BODY, point=(1.0, 50.0, 0.0), force=UP)
    assert len(warnings(comm, caplog, BODY, push)) == (comm.rank == 0)
    caplog.clear()
    joint = Spherical("j", None, BODY, (1.0, 6.0, 0.0))
    assert warnings(comm, caplog, BODY, joint, push) == []


def test_a_force_on_a_node_far_from_all_nodes_is_told(comm, caplog):
    flexible = beam(comm)
    assert not warnings(comm, caplog, flexible, NodeForce("n", flexible, point=UP, force=FORCE))
    told = warnings(comm, caplog, flexible, NodeForce("n", flexible, point=FORCE, force=UP))
    if comm.rank == 0:
        assert told[0].startswith("'n' acts on a point 500 m from the centre of 'beam'")

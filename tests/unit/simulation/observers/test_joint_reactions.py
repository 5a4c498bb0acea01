"""Claims about forces and moments in joints: their signs, and Newton's laws."""

import numpy as np
import pytest
from seen import Seen

from turbine_fenicsx import (
    Cylindrical,
    Gravity,
    JointDamper,
    JointSpring,
    JointTorque,
    PrescribedMotion,
    Prismatic,
    Revolute,
    Rigid,
    Spherical,
)
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx.simulation.observers.history import History
from turbine_fenicsx.simulation.observers.joint_reactions import (
    JointReaction,
    JointReactions,
    joint_channel,
)
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

EULER = (0.2, 0.1, 0.05)
DT = 0.01
G = np.array([0.0, -9.81, 0.0])
AXES = rotation_about((1.0, 2.0, -1.0), 0.8)


def run(system, *functions, steps=4, start=None):
    """What functions of the snapshots say, an array for each."""
    seen = Seen(lambda snapshot: [np.copy(f(snapshot)) for f in functions])
    Simulation(system, DT, steps * DT, [seen], start=start).run()
    return seen.columns


def pendulum(comm, first=None, second=None, more=()):
    """A body 0.5 m below a hinge at (0.3, 1, 0), whose directors are turned; ends as given."""
    body = RigidBody(
        "body", 2.0, EULER, position=0.3 * E1 + 0.5 * E2, directors=rotation_about(E1 + E2, 0.4)
    )
    ends = (None, body) if second is None else (body, None)
    hinge = Revolute("hinge", *ends, point=0.3 * E1 + E2, axis=E3)
    return MultibodySystem(comm, [body, hinge, Gravity(tuple(G)), *more]), hinge


def test_a_hinge_carries_the_weight_of_what_hangs(comm):
    system, hinge = pendulum(comm)
    points = [JointReaction(hinge), JointReaction(hinge, 0.0 * E1), JointReaction(hinge, axes=AXES)]
    reactions = JointReactions(system, points)
    up = 2.0 * 9.81 * E2
    expected = [[up, 0 * E1], [up, np.cross(0.3 * E1, up)], [AXES @ up, 0 * E1]]
    (loads,) = run(system, reactions.at)
    assert not np.any(loads[0])  # no step before it
    # the solver leaves 1e-12 of the weight of 20 N
    assert np.allclose(loads[1:], expected, rtol=0, atol=1e-10)
    assert np.allclose(reactions.at_rest(equilibrium(system)), expected, rtol=0, atol=1e-8)


def test_what_acts_on_the_ground_has_the_opposite_sign(comm):
    system, hinge = pendulum(comm, second="ground")
    reactions = JointReactions(system, [JointReaction(hinge), JointReaction(hinge, 0.0 * E1)])
    (loads,) = run(system, reactions.at)
    down = -2.0 * 9.81 * E2
    expected = [[down, 0 * E1], [down, np.cross(0.3 * E1, down)]]
    assert np.allclose(loads[1:], expected, rtol=0, atol=1e-10)


def test_a_spinning_arm_is_held_by_the_centripetal_force(comm):
    arm = RigidBody("arm", 2.0, EULER, position=0.5 * E1)
    hinge = Revolute("hinge", None, arm, point=0 * E1, axis=E3)
    system = MultibodySystem(comm, [arm, hinge])
    reactions = JointReactions(system, [JointReaction(hinge, axes=np.eye(3))])
    start = initial_motion(system, {"hinge": 3.0})
    loads, angles = run(system, reactions.at, lambda s: s.state.joint_coordinates, start=start)
    turn = angles[1, 0]
    # the discrete one: the velocity w r turns by the angle of a step in each step
    speed = 2.0 * 0.5 * np.tan(0.5 * turn) / DT
    force = 2.0 * 2.0 * speed * np.sin(0.5 * turn) / DT
    assert force == pytest.approx(2.0 * 0.5 * 3.0**2, rel=1e-3)
    assert np.allclose(loads[1:, 0, 0], [-force, 0, 0], rtol=0, atol=1e-8 * force)
    assert np.allclose(loads[1:, 0, 1], 0.0, rtol=0, atol=1e-8 * force)


def four_bar(comm):
    """A linkage out of plane symmetry, driven, with a spring and a damper; no redundant rows."""
    points = [0 * E1, E2, 2 * E1 + 1.5 * E2, 2 * E1]
    bars = [
        RigidBody(
            f"bar_{k}", 1.0 + k, EULER, position=0.5 * (points[k] + points[k + 1]) + 0.1 * k * E3
        )
        for k in range(3)
    ]
    joints = [
        Revolute("crank", None, bars[0], point=points[0], axis=E3),
        Revolute("knee", bars[0], bars[1], point=points[1], axis=E3),
        Spherical("ball", bars[1], bars[2], points[2]),
        Cylindrical("rocker", bars[2], None, point=points[3], axis=E3),
    ]
    more = [
        Gravity(tuple(G)),
        JointTorque("torque on knee", "knee", 3.0),
        JointSpring("spring", "knee", 20.0, 0.3),
        JointDamper("damper", "rocker.angle", 0.5),
        PrescribedMotion("crank", lambda t: 2.0 * t * t),
    ]
    return MultibodySystem(comm, [*bars, *joints, *more]), joints


def momenta(system):
    """Linear and angular momentum about the origin of each body, shape (bodies, 2, 3)."""

    def values(s):
        q, p = (x.reshape(-1, 4, 3) for x in (s.state.q, system.rigid_model.masses * s.state.q_dot))
        return np.stack([p[:, 0], np.cross(q, p).sum(axis=1)], axis=1)

    return values


def test_forces_in_all_joints_meet_newtons_laws(comm):
    """For each body of a driven linkage, with spring and damper, in every step."""
    system, joints = four_bar(comm)
    assert not system.redundant
    reactions = JointReactions(system, [JointReaction(j) for j in joints])
    loads, p, q = run(system, reactions.at, momenta(system), lambda s: s.state.q, steps=20)
    middle = 0.5 * (q[1:] + q[:-1]).reshape(20, -1, 4, 3)
    rates = np.diff(p, axis=0) / DT
    forces = np.zeros_like(rates)
    for k, body in enumerate(system.rigid_bodies):
        forces[:, k, 0] += body.mass * G
        forces[:, k, 1] += np.cross(middle[:, k, 0], body.mass * G)
    for j, joint in enumerate(joints):
        F, M = loads[1:, j].transpose(1, 0, 2)
        first, second = joint.bodies
        r = np.tile(joint.point, (20, 1))
        if second is not None:
            frame = middle[:, system.rigid_bodies.index(second)]
            xi = second.body_coordinates(joint.point)
            r = frame[:, 0] + np.einsum("i,nij->nj", xi, frame[:, 1:])
        for body, sign in ((first, -1.0), (second, 1.0)):
            if body is not None:
                k = system.rigid_bodies.index(body)
                forces[:, k, 0] += sign * F
                forces[:, k, 1] += sign * (M + np.cross(r, F))
    scale = np.max(np.abs(loads))
    assert scale > 10.0
    assert np.allclose(forces, rates, rtol=0, atol=1e-10 * scale)


def gyroscope(comm):
    """A disc that turns with 20 rad/s on a frame that turns with 0.7 rad/s; both are driven."""
    frame = RigidBody("frame", 3.0, EULER, position=0.1 * E2)
    disc = RigidBody.from_inertia("disc", 5.0, (0.1, 0.1, 0.2), position=0.4 * E3)
    yaw = Revolute("yaw", None, frame, point=0 * E1, axis=E2)
    shaft = Revolute("shaft", frame, disc, point=0.4 * E3, axis=E3)
    drives = [
        PrescribedMotion("yaw", lambda t: 0.7 * t),
        PrescribedMotion("shaft", lambda t: 20 * t),
    ]
    return MultibodySystem(comm, [frame, disc, yaw, shaft, *drives]), yaw, shaft


def read_table(path):
    """Columns of a history by name."""
    head, *rows = path.read_text().split()
    return dict(zip(head.split(","), np.array([r.split(",") for r in rows], float).T, strict=True))


def test_what_is_written_of_a_gyroscope_is_its_moment_to_second_order(comm, shared_tmp_path):
    """I_p Omega psi' across shaft and yaw axis; multipliers of the steps alternate about it."""
    expected, errors, single = 0.2 * 20.0 * 0.7, [], []
    for k, dt in enumerate((0.004, 0.002, 0.001)):
        system, yaw, shaft = gyroscope(comm)
        reactions = JointReactions(system, [JointReaction(shaft), JointReaction(yaw)])
        path = shared_tmp_path / f"history_{k}.csv"
        history = History(comm, path, [joint_channel(reactions)])
        steps = Seen(lambda s, r=reactions: np.linalg.norm(r.at(s)[0, 1]))
        start = initial_motion(system, {"yaw": 0.7, "shaft": 20.0})
        Simulation(system, dt, 0.08, [history, steps], start=start).run()
        table = read_table(path)
        moment = np.array([table[f"joint_moment_shaft_{i}_[Nm]"] for i in (1, 2, 3)])
        errors.append(np.max(np.abs(np.linalg.norm(moment, axis=0)[2:] / expected - 1.0)))
        single.append(np.max(np.abs(np.array(steps.values)[1:] / expected - 1.0)))
    assert single[0] > 0.05  # measured 0.073
    assert errors[0] < 0.02
    assert np.all(np.log2(np.divide(errors[:-1], errors[1:])) > 1.8)


def test_written_loads_go_on_after_a_restart(comm, shared_tmp_path):
    tables = []
    for name, parts in (("whole", (0.04,)), ("halves", (0.02, 0.04))):
        folder = shared_tmp_path / name
        folder.mkdir(exist_ok=True)
        for end in parts:
            system, yaw, shaft = gyroscope(comm)
            reactions = JointReactions(system, [JointReaction(yaw), JointReaction(shaft)])
            history = History(comm, folder / "h.csv", [joint_channel(reactions)])
            checkpoints = Checkpoints(system, folder)
            data = checkpoints.load() if end != parts[0] else None
            start = initial_motion(system, {"yaw": 0.7, "shaft": 20.0}) if data is None else None
            Simulation(system, 0.004, end, [history], checkpoints=checkpoints, start=start).run(
                data
            )
        tables.append((folder / "h.csv").read_text())
    assert tables[0] == tables[1]


def test_axes_turn_with_the_second_body(comm):
    system, hinge = pendulum(comm)
    pair = JointReactions(system, [JointReaction(hinge), JointReaction(hinge, axes=AXES)])
    start = initial_motion(system, {"hinge": 5.0})
    loads, angles = run(system, pair.at, lambda s: s.state.joint_coordinates[0], start=start)
    for k in range(1, 5):
        turned = AXES @ rotation_about(E3, 0.5 * (angles[k - 1] + angles[k])).T
        assert np.allclose(loads[k, 0] @ turned.T, loads[k, 1], rtol=0, atol=1e-10)


def test_a_body_that_is_held_twice_tells_of_the_joint_that_counts(comm):
    """The second of two clamps has no multiplier left: its load is zero, the first has it all."""
    body = RigidBody("body", 2.0, EULER, position=0.5 * E1)
    clamps = [Rigid("one", None, body, 0 * E1), Rigid("two", None, body, E1)]
    system = MultibodySystem(comm, [body, *clamps, Gravity(tuple(G))])
    assert system.redundant == {"two": 6}
    (loads,) = run(system, JointReactions(system, [JointReaction(c) for c in clamps]).at)
    up = 2.0 * 9.81 * E2
    expected = [[up, np.cross(0.5 * E1, up)], [0 * E1, 0 * E1]]
    assert np.allclose(loads[1:], expected, rtol=0, atol=1e-10)


def test_columns_of_the_history(comm, shared_tmp_path):
    guide = Prismatic("guide", None, body := RigidBody("body", 2.0, EULER), point=0 * E1, axis=E1)
    system = MultibodySystem(comm, [body, guide, Gravity(tuple(G))])
    reactions = JointReactions(system, [JointReaction(guide)])
    path = shared_tmp_path / "history.csv"
    history = History(comm, path, [joint_channel(reactions)])
    Simulation(system, DT, 2 * DT, [history]).run()
    names, first, *rows = path.read_text().split()
    assert names.split(",") == [
        *(f"joint_force_guide_{i}_[N]" for i in (1, 2, 3)),
        *(f"joint_moment_guide_{i}_[Nm]" for i in (1, 2, 3)),
    ]
    assert not np.any(np.array(first.split(","), dtype=float))
    table = np.array([row.split(",") for row in rows], dtype=float)
    assert np.allclose(table, [0, 2.0 * 9.81, 0, 0, 0, 0], rtol=0, atol=1e-10)


def test_mistakes_are_refused_in_a_sentence(comm):
    system, hinge = pendulum(comm)
    other = pendulum(comm)[1]
    with pytest.raises(ModelError, match="joint 'hinge' is not among the parts"):
        JointReactions(system, [JointReaction(other)])
    with pytest.raises(ValueError, match="point of 'hinge' must be three numbers, got 1"):
        JointReaction(hinge, 1)
    with pytest.raises(ValueError, match="axes of 'hinge' must be three rows of three numbers"):
        JointReaction(hinge, axes=E1)

    class Link:
        name = "link"

    with pytest.raises(ValueError, match="joint 'link' defines no point: give the one"):
        JointReaction(Link())

"""Claims about systems: what they accept, how they number, and their energies and momenta."""

import re

import numpy as np
import pytest

from turbine_fenicsx import Gravity, JointTorque, Revolute
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import E2, E3, rotation_about
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

pytestmark = pytest.mark.parallel

BEAM_SIZE, BEAM_MASS, BEAM_CENTRE = np.array([1.0, 0.5, 0.4]), 3.0 * 0.2, np.array([1.0, 0, -1])


def refused(comm, error, message, parts, **options):
    """All ranks raise the same: one that did not would wait for the others for ever."""
    said = None
    try:
        MultibodySystem(comm, parts, **options)
    except error as raised:
        said = str(raised)
    assert all(re.search(message, str(words)) for words in comm.allgather(said))


@pytest.mark.parametrize("part", ["steel", None, 3.0, object()])
def test_a_part_of_unknown_kind_is_a_type_error(comm, machine, part):
    message = "is no body, joint, relation, coupling or force"
    refused(comm, TypeError, message, [*machine().parts, part])


def test_names_must_be_unique_across_all_kinds(comm, machine):
    m = machine()
    for twin in (
        RigidBody("hub", 1.0, (1, 1, 1)),
        RigidBody("rotor", 1.0, (1, 1, 1)),  # the name of a joint
        FlexibleBody("root", m.beam.mesh, m.beam.material, 1.0),  # the name of a coupling
        m.hub,
        m.yaw,
    ):
        message = rf"names must be unique, but \['{twin.name}'\] occur more than once"
        refused(comm, ValueError, message, [*m.parts, twin])


def test_a_joint_or_coupling_to_a_body_outside_the_system_is_refused(comm, machine):
    m, stranger = machine(), RigidBody("stranger", 1.0, (1, 1, 1))
    for part in (
        Revolute("loose", m.hub, stranger, point=(0, 0, 0), axis=E3),
        Revolute("loose", stranger, m.hub, point=(0, 0, 0), axis=E3),
        Revolute("loose", None, stranger, point=(0, 0, 0), axis=E3),
        Coupling("loose", m.beam, m.facets(1.5), stranger),
    ):
        message = "'loose' refers to body 'stranger', which is not among the parts"
        refused(comm, ValueError, message, [*m.parts, part])
    without_beam = [p for p in m.parts if p is not m.beam]
    refused(comm, ValueError, "'root' refers to body 'beam'", without_beam)


def test_a_joint_to_a_flexible_body_is_refused(comm, machine):
    m = machine()
    joint = Revolute("bad", m.beam, m.hub, point=(0, 0, -1), axis=E3)
    refused(
        comm,
        TypeError,
        "'bad' needs a rigid body or the ground, got FlexibleBody 'beam'",
        [*m.parts, joint],
    )


def test_a_coupling_of_a_rigid_body_is_refused(comm, machine):
    m = machine()
    coupling = Coupling("bad", m.nacelle, m.facets(1.5), m.hub)
    refused(
        comm,
        TypeError,
        "'bad' needs a flexible body, got RigidBody 'nacelle'",
        [*m.parts, coupling],
    )


def test_a_coupling_carried_by_a_flexible_body_is_refused(comm, machine):
    m = machine()
    other = FlexibleBody("other", m.beam.mesh, m.beam.material, 1.0)
    coupling = Coupling("bad", m.beam, m.facets(1.5), other)
    refused(
        comm,
        TypeError,
        "'bad' needs a rigid body or the ground, got FlexibleBody 'other'",
        [*m.parts, other, coupling],
    )


def test_an_unknown_form_of_the_angle_is_refused_by_name(comm, machine):
    system = machine().system()
    with pytest.raises(ModelError, match=r"angle_form must be one of \['paper', 'regular'\], got"):
        EnergyMomentum(system, angle_form="singular")


def test_parts_are_numbered_in_the_order_given_whatever_their_kinds(comm, machine):
    m = machine()
    shuffled = [m.root, m.rotor, m.hub, Gravity(), m.yaw, m.beam, m.nacelle]
    system = MultibodySystem(comm, iter(shuffled))
    assert system.rigid_bodies == (m.hub, m.nacelle)
    assert system.first_coordinate == {m.hub: 0, m.nacelle: 12}
    assert system.joints == (m.rotor, m.yaw)
    assert system.joint_coordinate_names == ("rotor", "yaw")
    assert m.system().joint_coordinate_names == ("yaw", "rotor")
    assert system.flexible_bodies == (m.beam,)
    assert system.couplings == (m.root,)
    assert len(system.prescribed_forces) == 1
    # two bodies with six internal constraints, two joints with five, each with an angle
    assert system.rigid_model.size == 24 + 2 + 22 + 2


def test_initial_state_is_what_the_bodies_say_and_fulfils_all_constraints(machine):
    m = machine(spin=2.0)
    system = m.system()
    state = system.initial_state()
    assert state.time == 0.0
    assert np.array_equal(state.q, np.concatenate([m.nacelle.coordinates, m.hub.coordinates]))
    assert np.array_equal(state.q_dot, np.concatenate([m.nacelle.rates, m.hub.rates]))
    assert state.joint_coordinates.tolist() == state.joint_rates.tolist() == [0.0, 0.0]
    assert state.multipliers.tolist() == [0.0] * 24
    assert state.u[0].norm() == state.coupling[0].norm() == 0.0
    assert system.constraint_error(state) <= 2e-15  # sums of four products of order one


def test_a_coupled_body_starts_with_the_velocity_of_its_carrier(comm, machine):
    """So that the coupling constraints hold for the velocities as well."""
    m, R = machine(), rotation_about((1, 1, 0), 0.4)
    carrier = RigidBody(
        "moving",
        1.0,
        (1, 2, 3),
        position=(0.3, 0, 0),
        directors=R,
        velocity=(1, 2, 3),
        angular_velocity=(4, 5, 6),
    )
    free = FlexibleBody("free", m.beam.mesh, m.beam.material, 1.0)
    parts = [carrier, m.beam, free, Coupling("root", m.beam, m.facets(0.5), carrier)]
    system = MultibodySystem(comm, parts)
    v, at_rest = system.initial_state().v
    X = system.flexible_models[0].positions
    expected = np.array([1, 2, 3]) + np.cross([4, 5, 6], X - [0.3, 0, 0])
    assert at_rest.norm() == 0.0
    assert np.allclose(v.array_r.reshape(-1, 3), expected, rtol=0, atol=1e-14)


def test_loads_are_collected_with_gravity_apart(machine):
    m = machine()
    system = m.system(
        Gravity((0.0, -2.0, 1.0)), JointTorque("torque on yaw", "yaw", 1.0, lambda t: 3.0 * t)
    )
    forces = system.sum_prescribed_forces(2.0)
    assert forces.torques == {"yaw": 6.0, "rotor": 0.0}
    assert forces.acceleration.tolist() == [0.0, -2.0, 1.0]
    assert all(np.array_equal(f, np.zeros(12)) for f in forces.coordinates.values())
    weight = system.gravity_force(forces.acceleration).reshape(2, 4, 3)
    assert weight[0, 0].tolist() == [0.0, -4.0, 2.0]  # 2 kg
    assert weight[1, 0].tolist() == [0.0, -2.0, 1.0]  # 1 kg
    assert np.count_nonzero(weight[:, 1:]) == 0


def test_a_torque_on_a_joint_without_angle_is_refused(comm, machine):
    parts = [*machine().parts, JointTorque("torque on pitch", "pitch", 1.0)]
    message = r"no joint coordinate 'pitch'; there are \['rotor', 'yaw'\]"
    refused(comm, ValueError, message, parts)


def test_balance_of_rigid_bodies_equals_classical_mechanics(comm):
    R, w = rotation_about((1, 2, 3), 0.7), np.array([0.3, -1.0, 2.0])
    x, v, E = np.array([1.0, -2.0, 0.5]), np.array([3.0, 1.0, -1.0]), np.diag([3.0, 5.0, 0.5])
    bodies = [
        RigidBody("a", 2.0, np.diag(E), position=x, directors=R, velocity=v, angular_velocity=w),
        RigidBody("b", 3.0, (1, 1, 1), position=(0, 4, 0)),
    ]
    system = MultibodySystem(comm, [*bodies, Gravity((0, -9.81, 1.0))])
    balance = system.balance(system.initial_state())
    J = R @ (np.trace(E) * np.eye(3) - E) @ R.T
    assert balance.kinetic == pytest.approx(v @ v + 0.5 * w @ J @ w, rel=1e-14)
    assert balance.strain == 0.0
    assert balance.potential == pytest.approx(9.81 * (2 * -2 + 3 * 4) - 1.0 * 2 * 0.5, rel=1e-14)
    assert balance.total == balance.kinetic + balance.potential
    assert np.allclose(balance.linear, 2.0 * v, rtol=1e-14, atol=0)
    assert np.allclose(balance.angular, np.cross(x, 2.0 * v) + J @ w, rtol=0, atol=1e-13)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_balance_of_a_turning_machine_equals_that_of_one_rigid_rotor(machine, cell, degree):
    """Hub and beam turn together about e3 through the centre of the hub."""
    m = machine(spin=2.0, cell=cell, degree=degree)
    system = m.system(Gravity())
    balance = system.balance(system.initial_state())
    E = np.diag(m.hub.euler)
    R = np.asarray(m.hub.directors)
    J = R @ (np.trace(E) * np.eye(3) - E) @ R.T
    r = BEAM_CENTRE - m.hub.position
    J_beam = BEAM_MASS * (
        (np.sum(BEAM_SIZE**2) * np.eye(3) - np.diag(BEAM_SIZE**2)) / 12
        + (r @ r) * np.eye(3)
        - np.outer(r, r)
    )
    w = 2.0 * E3
    p = BEAM_MASS * np.cross(w, r)
    L = (J + J_beam) @ w + np.cross(m.hub.position, p)
    assert balance.kinetic == pytest.approx(0.5 * w @ (J + J_beam) @ w, rel=1e-13)
    assert abs(balance.strain) <= 1e-15 * 3000 * 0.2  # modulus times volume
    assert abs(balance.potential) <= 1e-14  # all centres lie at x2 = 0
    assert np.allclose(balance.linear, p, rtol=0, atol=1e-14)
    assert np.allclose(balance.angular, L, rtol=0, atol=1e-14)


def test_balance_of_a_stretched_and_lifted_beam_equals_the_hand_value(machine):
    m = machine()
    system = m.system(Gravity())
    state = system.initial_state()
    H = np.diag([0.1, 0.0, -0.05])
    X = system.flexible_models[0].positions
    state.u[0].array[:] = (X @ H + 3.0 * E2).ravel()
    balance = system.balance(state)
    e = 0.5 * (np.diag((np.eye(3) + H) ** 2) - 1)
    W = 0.5 * 1200 * e.sum() ** 2 + 800 * e @ e
    assert balance.strain == pytest.approx(W * 0.2, rel=1e-12)
    assert balance.potential == pytest.approx(9.81 * BEAM_MASS * 3.0, rel=1e-13)


def test_constraint_error_is_the_largest_violation_of_any_kind_on_all_ranks(comm, machine):
    system = machine().system()
    state = system.initial_state()
    coupling = system.coupling_blocks[0]
    states = {name: state.copy() for name in ("joint", "angle", "coupling")}
    states["joint"].q[2] += 1e-3
    states["angle"].joint_coordinates[1] = np.arcsin(1e-3)
    states["coupling"].u[0].array[coupling.dofs[:2]] = 1e-3
    for name, changed in states.items():
        errors = comm.allgather(system.constraint_error(changed))
        assert errors == pytest.approx([1e-3] * comm.size, rel=1e-10), name
        assert errors == errors[:1] * comm.size
    assert system.constraint_error(state) <= 2e-15


def test_balance_does_not_change_the_state(machine):
    system = machine(spin=1.0).system(Gravity())
    state = system.initial_state()
    before = [np.copy(a) for a in (state.q, state.q_dot, state.u[0].array_r, state.v[0].array_r)]
    first, again = system.balance(state), system.balance(state)
    assert first.total == again.total
    assert all(
        np.array_equal(a, b)
        for a, b in zip(
            before, (state.q, state.q_dot, state.u[0].array_r, state.v[0].array_r), strict=True
        )
    )


def test_a_system_may_consist_of_flexible_bodies_only(comm, machine):
    m = machine()
    ground = Coupling("foot", m.beam, m.facets(0.5), None)
    system = MultibodySystem(comm, [m.beam, ground])
    state = system.initial_state()
    assert system.rigid_model.size == 0 and state.q.size == 0
    assert system.balance(state).total == 0.0
    assert system.constraint_error(state) == 0.0


def test_a_system_may_be_empty(comm):
    system = MultibodySystem(comm, [])
    assert system.balance(system.initial_state()).total == 0.0

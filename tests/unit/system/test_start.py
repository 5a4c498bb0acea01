"""Claims about starting with given rates of joints."""

import numpy as np
import pytest
from dolfinx import mesh
from seen import Seen

from turbine_fenicsx import Gravity, Prismatic, Revolute, StVenantKirchhoff
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import E1, E2, E3, rotation_about
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.start import initial_motion
from turbine_fenicsx.system.system import MultibodySystem

EULER = (0.2, 0.1, 0.05)
ROUND_OFF = 1e-14  # of velocities of order one


def rods(comm, *more, **options):
    """Two rods in a row along e1, turning about e3 at the origin and at e1."""
    upper = RigidBody(
        "upper", 2.0, EULER, position=0.5 * E1, directors=rotation_about(E1 + E2, 0.4)
    )
    lower = RigidBody(
        "lower", 1.0, EULER, position=1.5 * E1, directors=rotation_about(E3, 0.3), **options
    )
    shoulder = Revolute("shoulder", None, upper, point=np.zeros(3), axis=E3)
    elbow = Revolute("elbow", upper, lower, point=E1, axis=E3)
    return MultibodySystem(comm, [upper, lower, shoulder, elbow, *more])


def rates_of(state, system, name):
    """Velocity of the centre of mass and angular velocity of a body."""
    body = next(b for b in system.rigid_bodies if b.name == name)
    first = system.first_coordinate[body]
    v, *d_dot = state.q_dot[first : first + 12].reshape(4, 3)
    d = state.q[first + 3 : first + 12].reshape(3, 3)
    return v, 0.5 * np.cross(d, d_dot).sum(axis=0)


def worst_gap(system, state):
    """Largest velocity at which any constraint opens."""
    G, _ = system.rigid_model.velocity_rows(state.q)
    gaps = [G @ state.q_dot]
    for coupling, v in zip(system.coupling_blocks, state.v, strict=True):
        motion = coupling.B_local @ state.q_dot[coupling.columns]
        gaps.append(motion - v.array_r[coupling.dofs])
    local = max(np.max(np.abs(gap), initial=0.0) for gap in gaps)
    return max(system.comm.allgather(local))


def test_what_hangs_on_a_joint_turns_with_it(comm):
    system = rods(comm)
    state = initial_motion(system, {"shoulder": 2.0, "elbow": -0.5})
    v, w = rates_of(state, system, "upper")
    assert np.allclose([v, w], [1.0 * E2, 2.0 * E3], rtol=0, atol=ROUND_OFF)
    v, w = rates_of(state, system, "lower")
    assert np.allclose([v, w], [(2.0 + 0.75) * E2, 1.5 * E3], rtol=0, atol=ROUND_OFF)
    assert np.allclose(state.joint_rates, [2.0, -0.5], rtol=0, atol=ROUND_OFF)
    assert worst_gap(system, state) < ROUND_OFF


def test_joints_without_a_rate_take_the_motion_of_least_energy(comm):
    system = rods(comm)
    state = initial_motion(system, {"shoulder": 2.0})
    least = system.balance(state).kinetic
    (elbow,) = state.joint_rates[1:]
    assert abs(elbow) > 0.1
    for change in (-1e-3, 1e-3):
        other = initial_motion(system, {"shoulder": 2.0, "elbow": elbow + change})
        assert least < system.balance(other).kinetic < least + 1e-5


def test_momentum_of_what_is_free_stays(comm):
    """As impulses in the joint alone make the motion."""
    a = RigidBody("a", 2.0, EULER, velocity=E2, angular_velocity=0.3 * E1)
    b = RigidBody("b", 1.0, EULER, position=E1, velocity=E2 + 0.3 * E1, angular_velocity=E3)
    system = MultibodySystem(comm, [a, b, Revolute("r", a, b, point=E1, axis=E3)])
    state = initial_motion(system, {"r": 3.0})
    before, after = system.balance(system.initial_state()), system.balance(state)
    assert np.allclose(after.linear, before.linear, rtol=0, atol=1e-14)
    assert np.allclose(after.angular, before.angular, rtol=0, atol=1e-14)


def test_velocities_that_fit_are_kept(comm):
    system = rods(comm, angular_velocity=1.5 * E3, velocity=0.75 * E2)
    state = initial_motion(system, {"elbow": 1.5})
    assert np.allclose(state.q_dot, system.initial_state().q_dot, rtol=0, atol=ROUND_OFF)


def test_a_displacement_has_a_rate_too(comm):
    slider = RigidBody("slider", 2.0, EULER)
    system = MultibodySystem(
        comm, [slider, Prismatic("guide", None, slider, point=E2, axis=E1 + E2)]
    )
    state = initial_motion(system, {"guide": -3.0})
    v, w = rates_of(state, system, "slider")
    assert np.allclose([v, w], [-3.0 * (E1 + E2) / 2**0.5, 0 * E1], rtol=0, atol=ROUND_OFF)


def test_a_rod_without_thickness_turns(comm):
    rod = RigidBody("rod", 1.0, (0.1, 0.1, 0.0), position=0.5 * E1)
    state = initial_motion(
        system := MultibodySystem(comm, [rod, Revolute("j", None, rod, point=0 * E1, axis=E2)]),
        {"j": 2.0},
    )
    assert np.allclose(rates_of(state, system, "rod"), [-E3, 2 * E2], rtol=0, atol=ROUND_OFF)


def four_bar(comm):
    """A parallelogram: crank and rocker are parallel, the coupler does not turn."""
    points = [0 * E1, E2, 2 * E1 + E2, 2 * E1]
    bars = [
        RigidBody(f"bar_{k}", 1.0, EULER, position=0.5 * (points[k] + points[k + 1]))
        for k in range(3)
    ]
    ends = [None, *bars, None]
    joints = [
        Revolute(f"pin_{k}", ends[k], ends[k + 1], point=points[k], axis=E3) for k in range(4)
    ]
    return MultibodySystem(comm, [*bars, *joints])


def test_a_closed_loop_follows_one_rate(comm):
    system = four_bar(comm)
    assert sum(system.redundant.values()) == 3
    state = initial_motion(system, {"pin_0": 1.0})
    assert np.allclose(state.joint_rates, [1, -1, 1, -1], rtol=0, atol=10 * ROUND_OFF)
    assert worst_gap(system, state) < 10 * ROUND_OFF
    again = initial_motion(system, {"pin_0": 1.0, "pin_2": 1.0})  # says the same twice
    assert np.allclose(again.q_dot, state.q_dot, rtol=0, atol=10 * ROUND_OFF)


def test_rates_that_contradict_each_other_are_refused(comm):
    words = "the rate -2 of 'pin_3' contradicts the joints and the other rates, which make it -1"
    with pytest.raises(ValueError, match=words):
        initial_motion(four_bar(comm), {"pin_0": 1.0, "pin_3": -2.0})


@pytest.mark.parametrize(
    ("rates", "words"),
    [
        ({"knee": 1.0}, r"no joint coordinate 'knee'; there are \['elbow', 'shoulder'\]"),
        ({"elbow": np.nan}, "rate of 'elbow' must be a number, got nan"),
        ({"elbow": "fast"}, "rate of 'elbow' must be a number, got 'fast'"),
    ],
)
def test_mistakes_are_refused_in_a_sentence(comm, rates, words):
    with pytest.raises(ValueError, match=words):
        initial_motion(rods(comm), rates)


@pytest.mark.parallel
@pytest.mark.parametrize("degree", [1, 2])
def test_a_flexible_body_moves_with_what_carries_it(machine, degree):
    m = machine(degree=degree)
    system = m.system()
    state = initial_motion(system, {"rotor": 3.0, "yaw": 0.0})
    X = system.flexible_models[0].positions
    expected = np.cross(3.0 * E3, X - m.rotor.point)
    assert np.allclose(state.v[0].array_r.reshape(-1, 3), expected, rtol=0, atol=10 * ROUND_OFF)
    assert worst_gap(system, state) < 10 * ROUND_OFF


def test_mass_of_flexible_bodies_counts(machine):
    """The yaw that is left free moves as a mechanism of rigid bodies would."""
    system = machine().system()
    state = initial_motion(system, {"rotor": 3.0})
    least = system.balance(state).kinetic
    (yaw,) = state.joint_rates[:1]
    assert abs(yaw) > 1e-2
    for change in (-1e-3, 1e-3):
        other = initial_motion(system, {"rotor": 3.0, "yaw": yaw + change})
        assert least < system.balance(other).kinetic


def linkage(comm, tie):
    """A flexible coupler between two rockers, or between one and the ground."""
    left, right = (
        RigidBody(n, 1.0, EULER, position=x * E1 + 0.5 * E2) for n, x in (("l", 0), ("r", 3))
    )
    box = mesh.create_box(comm, [[0, 1, 0], [3, 1.2, 0.2]], [6, 1, 1], mesh.CellType.hexahedron)
    ends = [
        mesh.locate_entities_boundary(box, 2, lambda x, at=at: np.isclose(x[0], at))
        for at in (0.0, 3.0)
    ]
    bar = FlexibleBody("bar", box, StVenantKirchhoff(0.0, 1e5), 100.0)
    pins = [
        Revolute(f"pin_{b.name}", None, b, point=b.position - 0.5 * E2, axis=E3)
        for b in (left, right)
    ]
    to = right if tie else None
    couplings = [Coupling("a", bar, ends[0], left), Coupling("b", bar, ends[1], to)]
    return MultibodySystem(comm, [left, right, bar, *pins, *couplings])


@pytest.mark.parallel
def test_carriers_of_one_body_move_together(comm):
    """Rockers that are clamped to the same bar can only rest, however it bends later."""
    words = "the rate 1 of 'pin_l' contradicts the joints and the other rates, which make it"
    with pytest.raises(ValueError, match=words):
        initial_motion(linkage(comm, tie=True), {"pin_l": 1.0})
    with pytest.raises(ValueError, match=words):
        initial_motion(linkage(comm, tie=False), {"pin_l": 1.0})
    state = initial_motion(linkage(comm, tie=False), {"pin_r": 1.0})
    assert np.allclose(state.joint_rates, [0.0, 1.0], rtol=0, atol=ROUND_OFF)


@pytest.mark.parallel
def test_a_velocity_field_that_does_not_fit_is_refused(comm, machine):
    m = machine()
    m.beam = FlexibleBody(
        "beam", m.beam.mesh, m.beam.material, 3.0, velocity=lambda x: 0.0 * x + E1
    )
    m.root = Coupling("root", m.beam, m.root.facets, m.hub)
    with pytest.raises(ValueError, match="the velocity field of 'beam' contradicts the rates"):
        initial_motion(m.system(), {"rotor": 3.0})


def test_a_run_starts_with_the_rates(machine):
    """And velocities do not alternate: after two steps the rate is still that of the start."""
    system = machine().system(Gravity())
    start = initial_motion(system, {"rotor": 3.0, "yaw": 0.0})
    seen = Seen(lambda snapshot: snapshot.state.joint_rates[1])
    last = Simulation(system, 1e-3, 3e-3, [seen], start=start).run()
    assert np.allclose(seen.values, 3.0, rtol=0, atol=0.05)
    assert abs(last.energy_error) < 1e-9

"""Claims about static equilibrium, of rigid and flexible bodies under all kinds of loads."""

import logging
import re
from itertools import pairwise

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx.analysis import statics
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces import (
    FollowerForce,
    Gravity,
    JointDamper,
    JointSpring,
    JointTorque,
    NodeForce,
    PointForce,
    PointSpring,
    Pressure,
    SurfaceTraction,
)
from turbine_fenicsx.forces.time_functions import Ramp
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.joints import Cylindrical, PrescribedMotion, Revolute, Spherical
from turbine_fenicsx.materials import KelvinVoigt, StVenantKirchhoff
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.time_stepping.stepper import StepFailure

N = np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0])
A = RigidBody("a", 2.0, (1, 2, 3), (3.0, 5.0, 2.0), rotation_about((1, 0, 2), 0.7))
HINGE = Revolute("hinge", None, A, (4.0, 5.0, 2.0), (0, 0, 1))
YOUNG = 1e4


def residual_in_rest(system, state, dt=1e-3):
    """Largest change of velocity in a step from rest, over that of gravity."""
    solver, other = EnergyMomentum(system), state.copy()
    report = solver.advance(state, dt, other)
    solver.destroy()
    moved = [np.max(np.abs(other.q - state.q), initial=0.0)]
    moved += [(a - b).norm() for a, b in zip(other.u, state.u, strict=True)]
    return system.comm.allreduce(max(moved)) / (9.81 * dt**2), report


# --- rigid bodies


def test_a_hanging_body_turns_until_spring_and_weight_balance(comm):
    system = MultibodySystem(comm, [A, HINGE, JointSpring("s", "hinge", 100.0), Gravity()])
    state = equilibrium(system)
    T = state.angles[0]
    # the arm of 1 m points to -e1 initially and comes down as the angle grows
    assert 100.0 * T == pytest.approx(2.0 * 9.81 * np.cos(T), rel=1e-12)
    assert np.all(state.q_dot == 0.0) and state.time == 0.0
    assert system.constraint_error(state) <= 1e-13
    assert residual_in_rest(system, state)[0] <= 1e-9


def test_a_system_in_equilibrium_stays_where_it_is(comm):
    """Whether or not anything but joint forces holds it: the multipliers come first."""
    for point, more in (
        ((3.0, 6.0, 2.0), [Gravity()]),  # hangs
        ((3.0, 4.0, 2.0), [Gravity()]),  # stands, unstable
        ((4.0, 5.0, 2.0), [JointSpring("s", "hinge", 10.0)]),
        ((4.0, 5.0, 2.0), []),
    ):
        hinge = Revolute("hinge", None, A, point, (0, 0, 1))
        state = equilibrium(MultibodySystem(comm, [A, hinge, *more]))
        assert np.allclose(state.q, A.coordinates, rtol=0, atol=1e-13)


def chain(n, more=()):
    """Links of 1 m that hang on each other at an angle, with springs in hinges about e3."""
    parts, last, at = [], None, np.zeros(3)
    for k in range(n):
        way = np.array([np.sin(0.5), -np.cos(0.5), 0.0])
        link = RigidBody(f"link {k}", 1.0 + k, (0.1, 0.2, 0.1), at + 0.5 * way)
        parts += [link, Revolute(f"j{k}", last, link, at, (0, 0, 1))]
        parts += [JointSpring(f"s{k}", f"j{k}", 6.0), *(m(k) for m in more)]
        last, at = link, at + way
    return [*parts, Gravity()]


def test_a_hanging_chain_with_springs_is_where_a_damped_motion_comes_to_rest(comm):
    state = equilibrium(MultibodySystem(comm, chain(4)))
    damped = MultibodySystem(
        comm, chain(4, [lambda k: JointDamper(f"d{k}", f"j{k}", 100.0 / (k + 1) ** 2)])
    )
    solver = EnergyMomentum(damped)
    at = damped.initial_state()
    other = at.copy()
    for _ in range(300):
        solver.advance(at, 0.2, other)
        at, other = other, at
    solver.destroy()
    assert np.max(np.abs(state.angles)) > 0.2
    assert np.allclose(state.angles, at.angles, rtol=0, atol=1e-6)
    assert np.allclose(state.q, at.q, rtol=0, atol=1e-6)
    # multipliers are the joint forces; those of the motion alternate about them
    mean = 0.5 * (at.multipliers + other.multipliers)
    assert np.allclose(state.multipliers, mean, rtol=0, atol=1e-4)
    assert equilibrium(damped).angles == pytest.approx(state.angles, abs=1e-12)  # without dampers


def test_multipliers_of_the_highest_hinge_carry_the_weight(comm):
    system = MultibodySystem(comm, chain(4))
    state = equilibrium(system)
    force = state.multipliers[24:27]  # after the internal ones of four bodies
    assert np.allclose(force, [0.0, -9.81 * 10.0, 0.0], rtol=0, atol=1e-9)


def test_a_prescribed_displacement_is_displacement_control(comm):
    """The multiplier of the motion is the force of a spring that softens and turns."""
    joint = Cylindrical("j", None, A, (3.0, 5.0, 2.0), N)
    spring = PointSpring("s", A, None, (3.0, 5.0, 2.0), (6.0, 5.0, 2.0), 50.0, 2.0)
    lock = JointSpring("t", "j.angle", 10.0)
    system = MultibodySystem(
        comm, [A, joint, spring, lock, PrescribedMotion("j.displacement", lambda t: t)]
    )
    state = None
    for way in (0.5, -1.0, 1.5):
        state = equilibrium(system, [way], state)
        assert state.angles[1] == pytest.approx(way, abs=1e-13) and state.time == way
        gap = np.array([3.0, 0.0, 0.0]) - way * N
        length = np.linalg.norm(gap)
        force = -50.0 * (length - 2.0) * gap @ N / length  # of the drive, along the axis
        assert state.multipliers[-1] == pytest.approx(-force, rel=1e-10)


def test_a_motion_of_several_turns_needs_load_steps(comm):
    hinge = Revolute("hinge", None, A, (3.0, 6.0, 2.0), N)
    system = MultibodySystem(comm, [A, hinge, PrescribedMotion("hinge", lambda t: 10.0 * t)])
    state = equilibrium(system, np.linspace(0.1, 1.0, 10))
    R = rotation_about(N, 10.0)
    assert state.angles[0] == pytest.approx(10.0, abs=1e-13)
    assert np.allclose(state.q[3:].reshape(3, 3).T, R @ np.asarray(A.directors), rtol=0, atol=1e-12)
    for end in (0.3, 0.4, 1.0):  # 3, 4, 10 rad at once end on another branch
        words = "a joint turned by half a revolution or more in one load step, or a redundant"
        with pytest.raises(StepFailure, match=f"no equilibrium at t = {end:g} s: {words}"):
            equilibrium(system, [end])


def test_a_torque_that_winds_a_spring_up_over_turns(comm):
    hinge = Revolute("hinge", None, A, (3.0, 6.0, 2.0), N)
    parts = [
        A,
        hinge,
        JointSpring("s", "hinge", 2.0),
        JointTorque("torque on hinge", "hinge", 1.0, lambda t: 20.0 * t),
    ]
    state = equilibrium(MultibodySystem(comm, parts), np.linspace(0.05, 1.0, 20))
    assert state.angles[0] == pytest.approx(10.0, rel=1e-12)
    assert np.allclose(state.q[3:6], rotation_about(N, 10.0) @ np.asarray(A.directors)[:, 0])


def test_follower_and_point_forces_in_space(comm):
    """A body on a ball joint, held by three springs."""
    ball = Spherical("ball", None, A, (3.0, 6.0, 2.0))
    springs = [
        PointSpring(f"s{k}", None, A, 10 * e + A.position, A.position, 30.0)
        for k, e in enumerate(np.eye(3))
    ]
    loads = [
        Gravity(),
        PointForce("f", A, (4, 5, 2), (3, 0, -4), lambda t: t),
        FollowerForce("g", A, (3, 5, 4), (0, 4, 1), lambda t: t),
    ]
    system = MultibodySystem(comm, [A, ball, *springs, *loads])
    state = equilibrium(system, [0.5, 1.0])
    assert np.max(np.abs(state.q - A.coordinates)) > 0.05
    # the follower force is not conservative: moments about the joint balance by hand
    q = state.q.reshape(4, 3)

    def at(point):
        return q[0] + A.body_coordinates(point) @ q[1:]

    moments = [np.cross(at((4, 5, 2)) - at(ball.point), (3, 0, -4))]
    turned = (np.array([0, 4, 1.0]) @ np.asarray(A.directors)) @ q[1:]
    moments.append(np.cross(at((3, 5, 4)) - at(ball.point), turned))
    moments.append(np.cross(q[0] - at(ball.point), 2.0 * np.array([0, -9.81, 0])))
    for s in springs:
        gap = np.asarray(s.first_point) - q[0]
        length = np.linalg.norm(gap)
        moments.append(np.cross(q[0] - at(ball.point), 30.0 * (length - 10.0) * gap / length))
    assert np.max(np.abs(sum(moments))) <= 1e-9


# --- flexible bodies


def clamped(comm, degree=2, n=(8, 1, 1), size=(8.0, 0.5, 0.5), material=None, loads=()):
    """A beam along e1 held at its root, with what makes loads from it."""
    box = mesh.create_box(comm, [(0, 0, 0), size], n, mesh.CellType.hexahedron)
    law = material or StVenantKirchhoff(0.0, 0.5 * YOUNG)  # no Poisson effect
    body = FlexibleBody("beam", box, law, 1.0, degree)

    def facets(on):
        return mesh.locate_entities_boundary(box, 2, on)

    root = facets(lambda x: np.isclose(x[0], 0.0))
    parts = [body, Coupling("root", body, root, None)]
    return MultibodySystem(comm, [*parts, *(x for make in loads for x in make(body, facets))])


def tip_forces(force):
    """Forces on the four corners of the tip."""

    def make(body, facets):
        return [
            NodeForce(f"f{y}{z}", body, (8.0, y, z), np.asarray(force) / 4, lambda t: t)
            for y in (0.0, 0.5)
            for z in (0.0, 0.5)
        ]

    return make


def tip(system, state):
    """Mean displacement of the corners of the tip. Collective."""
    X = system.flexible_models[0].positions
    at = np.isclose(X[:, 0], 8.0) & (np.abs(X[:, 1:] - 0.25).min(axis=1) > 0.2)
    u = state.u[0].array_r.reshape(-1, 3)[at]
    return system.comm.allreduce(u.sum(axis=0)) / system.comm.allreduce(len(u))


INERTIA = 0.5**4 / 12


def test_small_loads_bend_a_beam_as_the_linear_theory_says(comm):
    system = clamped(comm, loads=[tip_forces((0.0, 1e-4, 0.0))])
    state = equilibrium(system, [1.0])
    shear = 8.0 / (5 / 6 * 0.5 * YOUNG * 0.25)
    expected = 1e-4 * (8.0**3 / (3 * YOUNG * INERTIA) + shear)
    u = tip(system, state)
    # cells of 1 m x 0.5 m, and corners that are pulled: 1 per cent
    assert u[1] == pytest.approx(expected, rel=0.01)
    twice = tip(system, equilibrium(system, [2.0]))
    assert twice[1] == pytest.approx(2 * u[1], rel=1e-5)


def test_equilibrium_of_large_loads_is_a_stationary_point_of_the_potential(comm):
    """Energy minus work does not change to first order with any admissible displacement."""
    force = np.array([0.0, 1.5, 0.3])
    system = clamped(comm, loads=[tip_forces(force)])
    state = equilibrium(system, [0.25, 0.5, 0.75, 1.0])
    block = system.flexible_models[0]
    assert np.linalg.norm(tip(system, state)) > 2.0
    rng = np.random.default_rng(3)
    for _ in range(3):
        K, phase = rng.uniform(0.1, 1, (3, 3)), rng.uniform(0, 7, 3)
        w = block.new_vector()
        X = block.positions
        w.array[:] = (X[:, :1] * np.sin(X @ K + phase)).ravel()
        ends = []
        for h in (1e-6, -1e-6):
            moved = state.copy()
            moved.u[0].axpy(h, w)
            ends.append(system.balance(moved).strain - force @ tip(system, moved))
        slope = (ends[0] - ends[1]) / 2e-6
        moved.u[0].axpy(1e-6 + 1.0, w)
        work = abs(force @ (tip(system, moved) - tip(system, state)))
        assert work > 0.1 and abs(slope) <= 1e-4 * work


def increments(system, caught, **options):
    """Sizes of Newton's increments of one load step, relative to the largest displacement."""
    seen = []

    def record(*args):
        size, extent = caught(*args)
        seen.append(size / extent)
        return size, extent

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statics, "_move", record)
        equilibrium(system, [1.0], **options)
    return seen


def test_newton_converges_quadratically_also_with_loads_that_follow(comm):
    """Each of the last increments is less than a multiple of the square of the one before."""
    bent = clamped(comm, loads=[tip_forces((0.0, 0.8, 0.2))])
    hinged = MultibodySystem(
        comm,
        [
            A,
            HINGE,
            JointSpring("s", "hinge", 100.0),
            Gravity(),
            FollowerForce("f", A, (3, 5, 2), (0, 30, 0)),
            PointSpring("p", A, None, (3, 5, 2), (3, 8, 3), 20.0, 1.0),
        ],
    )
    for system in (bent, hinged, pressed(comm)):
        sizes = increments(system, statics._move)
        last = [(x, y) for x, y in pairwise(sizes) if x < 0.01]
        assert last and len(sizes) <= 12
        for before, after in last:
            assert after < 100 * before**2 + 1e-13


def test_the_number_of_iterations_is_logged(comm, caplog):
    system = MultibodySystem(comm, [A, HINGE, JointSpring("s", "hinge", 100.0), Gravity()])
    with caplog.at_level(logging.INFO, logger="turbine_fenicsx"):
        equilibrium(system, [1.0])
    assert re.fullmatch(r"equilibrium at t = 1 s after \d+ iterations", caplog.messages[-1])


def test_a_damped_motion_of_a_flexible_body_comes_to_rest_in_the_equilibrium(comm):
    law = StVenantKirchhoff(1200.0, 800.0)
    viscous = KelvinVoigt(law, 0.3 * 800.0, 0.3 * 1700.0)
    sizes = {"degree": 1, "n": (3, 1, 1), "size": (8.0, 2.0, 2.0)}

    def gravity(body, facets):
        return [Gravity((0.0, -3.0, 1.0))]

    system = clamped(comm, **sizes, material=law, loads=[gravity])
    state = equilibrium(system)
    damped = clamped(comm, **sizes, material=viscous, loads=[gravity])
    solver = EnergyMomentum(damped, numerical_dissipation=1.0)
    at = damped.initial_state()
    other = at.copy()
    for dt in [1.0] * 60 + [0.02] * 60:  # for low and high frequencies
        solver.advance(at, dt, other)
        at, other = other, at
    solver.destroy()
    u = state.u[0]
    assert u.norm() > 3.0
    assert (at.u[0] - u).norm() <= 1e-5 * u.norm()
    assert (at.coupling[0] - state.coupling[0]).norm() <= 1e-3 * state.coupling[0].norm()


def pressed(comm, p=0.4):
    """A stout beam under pressure on its tip and its upper side."""

    def make(body, facets):
        end, top = (facets(lambda x, k=k, s=s: np.isclose(x[k], s)) for k, s in ((0, 8), (1, 2)))
        return [
            SurfaceTraction("t", body, end, (0, 0, 0.1), Ramp(1.0, 1.0)),
            Pressure("p", body, np.append(end, top), p, Ramp(1.0, 1.0)),
        ]

    return clamped(comm, 1, (3, 1, 1), (8.0, 2.0, 2.0), StVenantKirchhoff(1200.0, 800.0), [make])


def test_a_follower_pressure_bends_and_the_root_carries_its_resultant(comm):
    """The resultant on the present area, which is another than that at the start."""
    system = pressed(comm)
    state = equilibrium(system, [0.5, 1.0])
    block = system.flexible_models[0]
    step, rest = FlexibleStep(block), block.new_vector()
    step.begin(state.u[0], rest, 1.0, np.zeros(3), 1.0)
    loads = []
    for axis in np.eye(3):  # work of a unit displacement
        du = block.new_vector()
        du.array[:] = np.tile(axis, block.n_owned)
        loads.append(comm.allreduce(step.midpoint.works(du)[0]).sum())
    # the multipliers are what the beam exerts on the ground, with the sign of C = -1
    reaction = comm.allreduce(state.coupling[0].array_r.reshape(-1, 3).sum(axis=0))
    assert np.allclose(reaction, np.negative(loads), rtol=0, atol=1e-10)
    assert abs(loads[0] + 0.4 * 4.0) > 0.01  # the tip has turned, and the top with it
    assert residual_in_rest(system, state)[0] <= 1e-8


@pytest.mark.parametrize("load", [1e-9, 1e-3])
def test_tiny_displacements_end_at_round_off(comm, load):
    system = clamped(comm, loads=[tip_forces((0.0, load, 0.0))])
    first, again = (tip(system, equilibrium(system, [1.0]))[1] for _ in range(2))
    assert first == again > 0.0


# --- what does not work


def test_a_free_body_has_no_equilibrium_under_its_weight(comm):
    words = r"no equilibrium at t = 2 s: the increments of Newton's method .* more load steps may"
    with pytest.raises(StepFailure, match=words):
        equilibrium(MultibodySystem(comm, [A, Gravity()]), [2.0])


def test_the_start_is_not_changed_by_success_or_failure(comm):
    system = MultibodySystem(comm, [A, HINGE, JointSpring("s", "hinge", 100.0), Gravity()])
    start = system.initial_state()
    start.q_dot[:] = 1.0
    before = start.q.copy()
    state = equilibrium(system, state=start)
    assert np.array_equal(start.q, before) and np.all(start.q_dot == 1.0)
    assert np.all(state.q_dot == 0.0)
    with pytest.raises(StepFailure):
        equilibrium(system, state=start, max_iterations=1)
    assert np.array_equal(start.q, before)


def test_no_load_steps_leave_the_initial_state(comm):
    system = MultibodySystem(comm, [A, HINGE, Gravity()])
    assert np.array_equal(equilibrium(system, []).q, A.coordinates)

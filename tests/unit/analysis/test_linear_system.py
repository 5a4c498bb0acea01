"""Claims about the matrices of small motions and the solver under their constraints."""

import numpy as np
import pytest
import ufl
from dolfinx import mesh

from turbine_fenicsx import (
    Gravity,
    JointDamper,
    JointSpring,
    KelvinVoigt,
    PointDamper,
    PointSpring,
    Revolute,
    StVenantKirchhoff,
)
from turbine_fenicsx.analysis.bordered_solver import blocks_of
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.statics import EquilibriumBlocks, equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

LAME = (4e4, 3e4)


class Drag:
    """Traction -|v| v, with a root in |v| that has no derivative at rest."""

    name = "drag"
    function = staticmethod(lambda t: 1.0)

    def __init__(self, flexible, facets):
        self.flexible, self.facets = flexible, facets

    def traction(self, at):
        return -ufl.sqrt(ufl.dot(at.v, at.v)) * at.v


class SlowDrag(Drag):
    """Traction -3 v: 3 N s/m per area."""

    def traction(self, at):
        return -3.0 * at.v


class Swing:
    """A soft beam on a rigid hub, whose hinge has a spring, under its weight."""

    def __init__(self, comm, material=None):
        self.comm = comm
        self.hub = RigidBody("hub", 2.0, (0.3, 0.4, 0.5), position=(0.0, 0.1, 0.0))
        cells = mesh.create_box(comm, [[0.5, -0.2, -0.1], [2.5, 0.2, 0.1]], [4, 2, 1])
        self.beam = FlexibleBody("beam", cells, material or StVenantKirchhoff(*LAME), 3.0, 1)
        self.tip = mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[0], 2.5))
        root = mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[0], 0.5))
        self.parts = [self.hub, self.beam, Coupling("root", self.beam, root, self.hub)]
        self.parts += [Revolute("hinge", None, self.hub, point=(0.0, 0.3, 0.0), axis=(0, 0, 1))]
        self.parts += [JointSpring("spring", "hinge", 90.0), Gravity((0.0, -9.81, 0.0))]

    def system(self, *more):
        return MultibodySystem(self.comm, [*self.parts, *more])


@pytest.fixture
def swing(comm):
    return Swing(comm)


def any_vector(linear, shift=0.3):
    """A flat vector that depends on positions alone, not on the ranks."""
    y = linear.vectors.new_vector()
    n_y, models = linear.vectors.n_y, linear.system.flexible_models
    fields = [np.sin(m.positions + shift * np.arange(3)).ravel() for m in models]
    rigid = np.cos(shift + np.arange(n_y)) if linear.system.comm.rank == 0 else np.zeros(0)
    y.array[:] = np.concatenate([*fields, rigid])
    return y


def quadratic(matrix, x, y=None):
    product = x.duplicate()
    matrix.mult(y or x, product)
    return x.dot(product)


def moved(state, motion, factor):
    """A copy of a state, moved."""
    other = state.copy()
    other.q += factor * motion.q
    other.joint_coordinates += factor * motion.joint_coordinates
    for u, du in zip(other.u, motion.u, strict=True):
        u.axpy(factor, du)
    return other


def test_a_motion_is_the_same_as_its_flat_vector(swing):
    linear = LinearSystem(swing.system(), swing.system().initial_state())
    y = any_vector(linear)
    motion = linear.vectors.motion(y)
    assert np.array_equal(motion.q, np.cos(0.3 + np.arange(12)))
    assert np.array_equal(motion.joint_coordinates, np.cos([12.3]))
    again = linear.vectors.vector(motion)
    again.axpy(-1.0, y)
    assert again.norm() == 0.0
    linear.destroy()


def test_the_mass_matrix_makes_the_kinetic_energy(swing):
    system = swing.system()
    state = system.initial_state()
    linear = LinearSystem(system, state)
    y = any_vector(linear)
    motion = linear.vectors.motion(y)
    state.q_dot[:] = motion.q
    motion.u[0].copy(state.v[0])
    kinetic = system.balance(state).kinetic
    assert 0.5 * quadratic(linear.mass, y) == pytest.approx(kinetic, rel=1e-13)


def test_the_stiffness_is_the_derivative_of_the_forces_at_constant_multipliers(swing):
    spring = PointSpring(
        "s",
        None,
        swing.hub,
        first_point=(0.0, 2.0, 0.0),
        second_point=(0.0, 0.1, 0.0),
        stiffness=30.0,
        length=0.5,
    )
    system = swing.system(spring)
    state = equilibrium(system)
    linear = LinearSystem(system, state)
    y, step = any_vector(linear), 1e-6
    ends = []
    for factor in (step, -step):
        blocks = EquilibriumBlocks(system, moved(state, linear.vectors.motion(y), factor))
        blocks.residual()
        R_u, _, R_r = blocks.split(blocks.residual_vector)
        rigid = R_r.array_r[: linear.vectors.n_y]
        ends.append(np.concatenate([*(R.array_r for R in R_u), rigid]))
    product = y.duplicate()
    linear.stiffness.mult(y, product)
    size = product.norm()
    product.array[:] -= (ends[0] - ends[1]) / (2.0 * step)
    assert product.norm() <= 1e-7 * size
    x = any_vector(linear, 0.8)
    there, back = quadratic(linear.stiffness, x, y), quadratic(linear.stiffness, y, x)
    assert there == pytest.approx(back, rel=1e-12)


@pytest.mark.parametrize("symmetric", [True, False])
def test_solutions_keep_the_constraints_and_fulfil_the_equations_along_them(swing, symmetric):
    system = swing.system()
    state = equilibrium(system)
    linear = LinearSystem(system, state)
    for A, M in zip(blocks_of(linear.stiffness), blocks_of(linear.mass), strict=True):
        A.axpy(20.0, M)
    solver = linear.solver(linear.stiffness, symmetric=symmetric)
    solver.factorise()
    b, other = any_vector(linear), any_vector(linear, 0.8)
    y, x = b.duplicate(), b.duplicate()
    solver.solve(b, y)
    solver.solve(other, x)
    assert solver.solves == 2
    # x is a motion that the constraints allow
    assert quadratic(linear.stiffness, x, y) == pytest.approx(x.dot(b), rel=1e-10)
    motion = linear.vectors.motion(y)
    G = system.rigid_model.constraint_jacobian(state.q, state.joint_coordinates)
    rigid = np.concatenate([motion.q, motion.joint_coordinates])
    size = np.max(np.abs(rigid))
    assert np.max(np.abs(G @ rigid)) <= 1e-12 * size
    coupling = system.coupling_blocks[0]
    gap = coupling.B_local @ motion.q[coupling.columns] - motion.u[0].array_r[coupling.dofs]
    assert np.max(np.abs(gap), initial=0.0) <= 1e-12 * size
    solver.destroy()
    linear.destroy()


def test_degrees_of_freedom_are_those_that_the_constraints_leave(swing, comm):
    body = RigidBody("a", 2.0, (1, 2, 3))
    for parts, expected in (
        ([body], 6),
        ([body, Revolute("r", None, body, point=(1, 0, 0), axis=(0, 0, 1))], 1),
    ):
        system = MultibodySystem(comm, parts)
        assert LinearSystem(system, system.initial_state()).degrees_of_freedom == expected
    system = swing.system()
    # 30 nodes, six of them on the hub, which turns about the hinge
    assert LinearSystem(system, system.initial_state()).degrees_of_freedom == 3 * 24 + 1


# --- damping


def damping_of(system, state=None):
    return LinearSystem(system, state or system.initial_state()).damping


def test_nothing_dampens_where_there_is_no_damper(swing):
    assert damping_of(swing.system()) is None


def test_a_damper_of_a_joint_dampens_its_coordinate(swing):
    system = swing.system(JointDamper("d", "hinge", 7.0))
    linear = LinearSystem(system, system.initial_state())
    y = linear.vectors.new_vector()
    if system.comm.rank == 0:
        y.array[-1] = 2.0
    assert quadratic(linear.damping, y) == pytest.approx(28.0, rel=1e-14)


def test_a_damper_between_points_dampens_their_distance(swing):
    ends = (0.0, 2.0, 0.0), (0.3, 0.1, 0.4)
    damper = PointDamper(
        "d", None, swing.hub, first_point=ends[0], second_point=ends[1], damping=7.0
    )
    system = swing.system(damper)
    linear = LinearSystem(system, system.initial_state())
    y = any_vector(linear)
    q = linear.vectors.motion(y).q.reshape(4, 3)
    velocity = np.append(1.0, swing.hub.body_coordinates(ends[1])) @ q
    along = np.subtract(*ends) / np.linalg.norm(np.subtract(*ends))
    expected = 7.0 * (along @ velocity) ** 2
    assert quadratic(linear.damping, y) == pytest.approx(expected, rel=1e-13)


def test_a_viscous_body_is_damped_in_proportion_to_its_stiffness(comm):
    """eta_s = tau mu and eta_b = tau (Lambda + 2 mu/3) make D = tau K where nothing is strained."""
    tau, (lam, mu) = 0.02, LAME
    material = KelvinVoigt(StVenantKirchhoff(lam, mu), tau * mu, tau * (lam + 2.0 * mu / 3.0))
    system = Swing(comm, material).system()
    linear = LinearSystem(system, system.initial_state())
    D, K = blocks_of(linear.damping)[0], blocks_of(linear.stiffness)[0]
    D.axpy(-tau, K)
    assert D.norm() <= 1e-13 * tau * K.norm()


def test_forces_that_depend_on_the_velocity_of_a_surface_dampen(swing):
    system = swing.system(SlowDrag(swing.beam, swing.tip))
    linear = LinearSystem(system, system.initial_state())
    y = linear.vectors.new_vector()
    if linear.vectors.split(y)[0].size:
        y.array[: linear.vectors.split(y)[0].size] = 0.5
    assert quadratic(linear.damping, y) == pytest.approx(3.0 * 0.08 * 3 * 0.25, rel=1e-13)


def test_a_law_with_a_corner_at_rest_is_refused(swing):
    with pytest.raises(ModelError, match="'beam' has no derivative with respect to the velocity"):
        damping_of(swing.system(Drag(swing.beam, swing.tip)))

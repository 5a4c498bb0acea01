"""Claims about one step of a flexible body, for all laws, cells and degrees."""

from mpi4py import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem
from small_body import (
    DENSITY,
    EPS,
    GRAVITY,
    LAMBDA,
    MASS,
    MU,
    SIZE,
    affine,
    all_kinds,
    all_laws,
    energy,
    kinetic,
    nodal,
    small_body,
    total,
    wild,
)

from turbine_fenicsx import KelvinVoigt, StepTimes
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.cell_centres import CellCentres
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.time_stepping.discrete_gradients import SMALL_INCREMENT, mean_stress
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

DT = 0.6
HALF_DT2 = 0.5 * DT**2


@pytest.fixture(scope="module")
def make():
    """Steps by cell, degree and law, each made once."""
    made = {}

    def block(*key, comm=MPI.COMM_WORLD):
        if (comm.size, *key) not in made:
            made[comm.size, *key] = FlexibleStep(small_body(comm, *key))
        return made[comm.size, *key]

    return block


def residual(step, u, v, du, gravity=GRAVITY):
    R = step.model.new_vector()
    step.start_step(u, v, StepTimes.from_start(0.0, DT), gravity)
    step.residual(du, R)
    return R


def inertia(model, v, du):
    """M (du - dt v)."""
    p = model.new_vector()
    model.momentum(du - DT * v, p)
    return p


@all_kinds
@all_laws
@pytest.mark.parametrize("size", [0.02, 1e-5])
def test_flexible_tangent_agrees_with_finite_differences(make, cell, degree, law, size):
    """``size`` chooses the branch of the general discrete gradient."""
    step = make(cell, degree, law)
    model = step.model
    u, v, du, w = (nodal(model, wild(k, s)) for k, s in enumerate((0.02, 0.1, size, 1.0), start=1))
    step.start_step(u, v, StepTimes.from_start(0.0, DT), GRAVITY)
    step.assemble_tangent(du)
    exact, h = model.new_vector(), 1e-6
    step.tangent.mult(w, exact)
    ends = [model.new_vector() for _ in range(2)]
    for sign, R in zip((1, -1), ends, strict=True):
        step.residual(du + sign * h * w, R)
    difference = (ends[0] - ends[1]) * (0.5 / h)
    # h^2 times third derivatives, which the short waves (strains of 60 h) make large, and the
    # round-off of the neo-Hookean correction, 1e-16/|dC| <= 1e-13, over h
    assert (difference - exact).norm() <= 2e-7 * exact.norm()


@all_kinds
def test_the_increments_above_lie_on_both_sides_of_the_threshold(comm, make, cell, degree):
    """|dC| of the larger increment exceeds it in the mean, that of the smaller one nowhere."""
    step = make(cell, degree, "svk")
    model = step.model
    f = fem.Function(model.space)
    f.x.array[: 3 * model.n_owned] = nodal(model, wild(3, 0.02)).array_r
    f.x.scatter_forward()
    D = ufl.grad(f)
    square = fem.form(ufl.inner(D + D.T, D + D.T) * ufl.dx(domain=model.body.mesh))
    mean = np.sqrt(comm.allreduce(fem.assemble_scalar(square)) / np.prod(SIZE))
    assert mean > 10 * SMALL_INCREMENT
    assert 4 * mean * 1e-5 / 0.02 < SMALL_INCREMENT


@all_kinds
@all_laws
@pytest.mark.parametrize("size", [0.02, 1e-3, 1e-6])
def test_residual_along_the_increment_is_the_balance_of_energy(make, cell, degree, law, size):
    """du . R = dt^2/2 (kinetic + strain - work of gravity) for any increment: this conserves."""
    step = make(cell, degree, law)
    model = step.model
    u, v, du = (nodal(model, wild(k, s)) for k, s in enumerate((0.02, 0.1, size), start=4))
    lhs = du.dot(residual(step, u, v, du))
    u1, v1 = u + du, (2 / DT) * du - v
    W0, W1 = energy(model, u), energy(model, u1)
    T0, T1 = kinetic(model, v), kinetic(model, v1)
    work = total(model, model.nodal_mass[:, None] * du.array_r.reshape(-1, 3)) @ GRAVITY
    rhs = HALF_DT2 * (T1 - T0 + W1 - W0 - work)
    # round-off of every energy; W of the neo-Hookean law rounds like the modulus times volume
    scale = T0 + T1 + W0 + W1 + abs(work) + 10 * np.prod(SIZE)
    assert abs(lhs - rhs) <= 50 * EPS * HALF_DT2 * scale


@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("tetrahedron", 2)])
def test_midpoint_stress_of_the_neo_hookean_law_fails_that_balance(comm, cell, degree):
    model = small_body(comm, cell, degree, "neo_hooke")
    step = FlexibleStep(model, mean_stress)
    u, v, du = (nodal(model, wild(k, s)) for k, s in enumerate((0.02, 0.1, 0.02), start=4))
    lhs = du.dot(residual(step, u, v, du, 0 * GRAVITY))
    rhs = HALF_DT2 * (
        kinetic(model, (2 / DT) * du - v)
        - kinetic(model, v)
        + energy(model, u + du)
        - energy(model, u)
    )
    assert abs(lhs - rhs) > 1e-7


@all_kinds
@all_laws
def test_internal_forces_have_neither_resultant_nor_moment(make, cell, degree, law):
    """What is left of sum R and sum x_mid x R is the change of both momenta: they are conserved."""
    step = make(cell, degree, law)
    model = step.model
    u, v, du = (nodal(model, wild(k, s)) for k, s in enumerate((0.02, 0.1, 0.02), start=7))
    R = residual(step, u, v, du, np.zeros(3))
    internal = (R - inertia(model, v, du)).array_r.reshape(-1, 3)
    x_mid = model.positions + (u + 0.5 * du).array_r.reshape(-1, 3)
    size = total(model, np.abs(internal)).sum()
    assert size > 0.01
    tolerance = 100 * EPS * (size + R.norm())
    assert np.max(np.abs(total(model, internal))) <= tolerance
    assert np.max(np.abs(total(model, np.cross(x_mid, internal)))) <= tolerance


@all_kinds
@all_laws
def test_rigid_motion_makes_no_internal_force(make, cell, degree, law):
    """From one finitely rotated and displaced position to another."""
    step = make(cell, degree, law)
    model = step.model
    R0, R1 = rotation_about((1, 0, 0), 0.3), rotation_about((1, 2, 0.5), 1.5)
    u = nodal(model, affine(R0 - np.eye(3), (1.0, 2.0, 3.0)))
    u1 = nodal(model, affine(R1 - np.eye(3), (-3.0, 2.0, 0.0)))
    v, du = nodal(model, wild(10, 0.1)), u1 - u
    internal = residual(step, u, v, du, np.zeros(3)) - inertia(model, v, du)
    # F is rounded by some EPS times the displacements (5) over the size of an element (0.4)
    assert internal.norm() <= 500 * EPS * HALF_DT2 * 20
    assert abs(energy(model, u)) <= 100 * EPS * 20 * np.prod(SIZE)


@pytest.mark.parallel
@all_kinds
def test_a_free_block_at_rest_is_in_balance_in_free_fall_only(make, cell, degree):
    step = make(cell, degree, "svk")
    model = step.model
    zero = model.new_vector()
    R = residual(step, zero, zero, zero).array_r.reshape(-1, 3)
    assert np.allclose(total(model, R), -HALF_DT2 * MASS * GRAVITY, rtol=1e-13, atol=0)
    fall = nodal(model, affine(np.zeros((3, 3)), HALF_DT2 * GRAVITY))
    assert residual(step, zero, zero, fall).norm() <= 100 * EPS * MASS * 2


@pytest.mark.parallel
@all_kinds
@all_laws
def test_numbers_do_not_depend_on_the_number_of_ranks(make, cell, degree, law):
    """The same model on all ranks together and on each rank alone."""
    found = []
    for comm in (MPI.COMM_WORLD, MPI.COMM_SELF):
        step = make(cell, degree, law, comm=comm)
        model = step.model
        u, v, du = (nodal(model, wild(k, s)) for k, s in enumerate((0.02, 0.1, 0.02), start=12))
        R = residual(step, u, v, du)
        step.assemble_tangent(du)
        product = model.new_vector()
        step.tangent.mult(v, product)
        stress, _ = CellCentres(model).stresses(u)
        largest = comm.allreduce(np.max(stress, initial=0.0), op=MPI.MAX)
        found.append([R.norm(), product.norm(), energy(model, u), kinetic(model, v), largest])
        found[-1].append(comm.allreduce(step.round_off))
    assert np.allclose(*found, rtol=1e-12, atol=0)  # sums in another order


@pytest.mark.parallel
@all_kinds
@all_laws
def test_round_off_of_the_forces_is_of_the_size_that_is_estimated(make, cell, degree, law):
    """A body turned by small angles has no other forces than those of round-off."""
    step = make(cell, degree, law)
    model = step.model
    zero = model.new_vector()
    ratios = []
    for axis in ((1, 2, 0.5), (2, -1, 1), (-1, 0.3, 2), (0.4, 1, -1), (1, 1, 0.2)):
        u = nodal(model, affine(rotation_about(axis, 0.02) - np.eye(3)))
        forces = residual(step, u, zero, zero, np.zeros(3)).norm() / HALF_DT2
        estimate = np.sqrt(MPI.COMM_WORLD.allreduce(step.round_off)) / HALF_DT2
        ratios.append(forces / estimate)
    # all cells are turned alike, so that their errors, among them that of the rotation itself, do
    # not average out over the body, but over the rotations
    assert 0.1 <= np.sqrt(np.mean(np.square(ratios))) <= 10.0


def test_round_off_grows_with_the_increment_and_with_viscosity_over_the_step(make):
    """Strains from increments have the round-off of these, and strain rates that over dt."""
    step = make("hexahedron", 1, "svk")
    model = step.model
    zero, v = model.new_vector(), model.new_vector()

    def estimate(speed, dt, damped):
        v.array[:] = np.tile([speed, 0.0, 0.0], model.n_owned)
        damped.start_step(zero, v, StepTimes.from_start(0.0, dt), np.zeros(3))
        return np.sqrt(MPI.COMM_WORLD.allreduce(damped.round_off)) / (0.5 * dt**2)

    rest = estimate(0.0, 0.1, step)
    assert estimate(0.0, 0.01, step) == pytest.approx(rest, rel=1e-12)
    moving = [estimate(speed, 0.1, step) for speed in (1e4, 2e4)]
    assert moving[0] > 10.0 * rest
    assert moving[1] - rest == pytest.approx(2.0 * (moving[0] - rest), rel=0.02)
    tau = 0.5
    law = KelvinVoigt(model.body.material, tau * MU, tau * (LAMBDA + 2.0 * MU / 3.0))
    body = FlexibleBody("viscous", model.body.mesh, law, DENSITY)
    viscous = FlexibleStep(FlexibleModel(body))
    assert estimate(0.0, 0.1, viscous) == pytest.approx(rest, rel=1e-12)
    more = [estimate(1e4, dt, viscous) - estimate(1e4, dt, step) for dt in (0.1, 0.01)]
    assert more[0] > 0.0
    # the same increment per step ten times as large takes the same strain rate
    assert more[1] == pytest.approx(more[0], rel=0.2)


@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_scale_of_the_terms_bounds_inertia_and_weight(make, law):
    """A backward error needs it: |M (du - dt v - h g)| can round no better than EPS of this."""
    step = make("hexahedron", 1, law)
    model = step.model
    u, v, du = (nodal(model, wild(k, s)) for k, s in enumerate((0.0, 0.1, 0.02), start=12))
    terms = []
    for a, b, g in ((du, 0 * v, 0 * GRAVITY), (0 * du, v, 0 * GRAVITY), (0 * du, 0 * v, GRAVITY)):
        step.start_step(u, b, StepTimes.from_start(0.0, DT), g)
        terms.append(np.sqrt(model.body.mesh.comm.allreduce(step.term_scale(a))))
    step.start_step(u, v, StepTimes.from_start(0.0, DT), GRAVITY)
    scale = np.sqrt(model.body.mesh.comm.allreduce(step.term_scale(du)))
    assert 0.0 < min(terms) <= max(terms) < scale <= sum(terms)
    # lumped and consistent masses bound each other up to a small factor
    assert residual(step, u, v, du).norm() <= 2 * scale


def test_setting_up_a_step_does_not_change_the_state(make):
    step = make("hexahedron", 1, "neo_hooke")
    model = step.model
    vectors = [nodal(model, wild(k, 0.02)) for k in range(20, 23)]
    before = [x.array_r.copy() for x in vectors]
    residual(step, *vectors)
    step.assemble_tangent(vectors[2])
    energy(model, vectors[0]), CellCentres(model).stresses(vectors[0])
    assert all(np.array_equal(a, x.array_r) for a, x in zip(before, vectors, strict=True))


def test_looking_at_another_state_does_not_change_the_step(make):
    """An energy or a stress asked for between ``start_step`` and the solution, by a monitor say."""
    step = make("hexahedron", 1, "svk")
    model = step.model
    u, v, du, other = (nodal(model, wild(k, 0.02)) for k in range(23, 27))
    before = residual(step, u, v, du)
    step.start_step(u, v, StepTimes.from_start(0.0, DT), GRAVITY)
    energy(model, other)
    after = model.new_vector()
    step.residual(du, after)
    assert (after - before).norm() == 0.0


def test_a_step_forgets_the_previous_one(make):
    step = make("hexahedron", 1, "neo_hooke")
    model = step.model
    u, v, du = (nodal(model, wild(k, 0.02)) for k in range(27, 30))
    before = residual(step, u, v, du)
    residual(step, du, u, v, 2 * GRAVITY)
    step.start_step(v, u, StepTimes.from_start(0.0, 3 * DT), -GRAVITY)
    step.assemble_tangent(u)
    assert (residual(step, u, v, du) - before).norm() == 0.0

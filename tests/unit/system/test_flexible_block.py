"""Claims about the block of one flexible body, for all laws, cells and degrees.

States are far from any solution, and functions of the position only, so that they do not depend
on how the mesh is distributed; numbers are compared with hand calculations or with themselves on
one rank.
"""

from mpi4py import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.materials import KelvinVoigt, NeoHooke, OrthotropicSVK, StVenantKirchhoff
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.time_stepping.discrete_gradients import SMALL_INCREMENT, mean_stress

KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]
LAWS = ("svk", "orthotropic", "neo_hooke")
SIZE, DENSITY, DT = np.array([1.0, 0.5, 0.4]), 3.0, 0.6
MASS, HALF_DT2 = DENSITY * np.prod(SIZE), 0.5 * DT**2
LAMBDA, MU = 6.0, 4.0
GRAVITY = np.array([0.5, -9.81, 2.0])
FRAME = rotation_about((1.0, 2.0, 0.5), 1.1)
EPS = np.finfo(float).eps

all_kinds = pytest.mark.parametrize(("cell", "degree"), KINDS)
all_laws = pytest.mark.parametrize("law", LAWS)


def build(comm, cell, degree, law, fibre=False, **options):
    cells = mesh.create_box(comm, [[0, 0, 0], SIZE], [2, 1, 1], getattr(mesh.CellType, cell))
    axes = [fem.Constant(cells, a.copy()) for a in FRAME.T]
    material = {
        "svk": StVenantKirchhoff(LAMBDA, MU),
        "neo_hooke": NeoHooke(LAMBDA, MU),
        "orthotropic": OrthotropicSVK((20.0, 8.0, 7.0), (4, 3, 2.5), (0.3, 0.25, 0.3), tuple(axes)),
    }[law]
    body = FlexibleBody("b", cells, material, DENSITY, degree, axes[0] if fibre else None)
    return FlexibleModel(body, **options)


@pytest.fixture(scope="module")
def make():
    """Blocks by cell, degree and law, each made once."""
    made = {}

    def block(*key, comm=MPI.COMM_WORLD):
        if (comm.size, *key) not in made:
            made[comm.size, *key] = build(comm, *key)
        return made[comm.size, *key]

    return block


def nodal(block, values):
    """Vector with the values at the owned nodes, a function of their positions X."""
    vector = block.new_vector()
    vector.array[:] = np.asarray(values(block.positions), dtype=float).ravel()
    return vector


def wild(seed, size):
    """A field that looks random: waves much shorter than the elements."""
    rng = np.random.default_rng(seed)
    K, phase = rng.uniform(5, 30, (3, 3)), rng.uniform(0, 7, 3)
    return lambda X: size * np.sin(X @ K + phase)


def affine(H, shift=(0.0, 0.0, 0.0)):
    return lambda X: X @ np.asarray(H).T + shift


def total(block, values):
    """Sum over the nodes of all ranks."""
    return block.body.mesh.comm.allreduce(np.asarray(values).sum(axis=0))


def energy(block, u):
    return block.body.mesh.comm.allreduce(block.strain_energy(u))


def kinetic(block, v):
    p = block.new_vector()
    block.momentum(v, p)
    return 0.5 * v.dot(p)


def residual(block, u, v, du, gravity=GRAVITY):
    R = block.new_vector()
    block.begin(u, v, DT, gravity)
    block.residual(du, R)
    return R


def inertia(block, v, du):
    """M (du - dt v)."""
    p = block.new_vector()
    block.momentum(du - DT * v, p)
    return p


@all_kinds
@all_laws
@pytest.mark.parametrize("size", [0.02, 1e-5])
def test_flexible_tangent_agrees_with_finite_differences(make, cell, degree, law, size):
    """``size`` chooses the branch of the general discrete gradient."""
    block = make(cell, degree, law)
    u, v, du, w = (nodal(block, wild(k, s)) for k, s in enumerate((0.02, 0.1, size, 1.0), start=1))
    block.begin(u, v, DT, GRAVITY)
    block.assemble_tangent(du)
    exact, h = block.new_vector(), 1e-6
    block.tangent.mult(w, exact)
    ends = [block.new_vector() for _ in range(2)]
    for sign, R in zip((1, -1), ends, strict=True):
        block.residual(du + sign * h * w, R)
    difference = (ends[0] - ends[1]) * (0.5 / h)
    # h^2 times third derivatives, which the short waves (strains of 60 h) make large, and the
    # round-off of the neo-Hookean correction, 1e-16/|dC| <= 1e-13, over h
    assert (difference - exact).norm() <= 2e-7 * exact.norm()


@all_kinds
def test_the_increments_above_lie_on_both_sides_of_the_threshold(comm, make, cell, degree):
    """|dC| of the larger increment exceeds it in the mean, that of the smaller one nowhere."""
    block = make(cell, degree, "svk")
    f = fem.Function(block.space)
    f.x.array[: 3 * block.n_owned] = nodal(block, wild(3, 0.02)).array_r
    f.x.scatter_forward()
    D = ufl.grad(f)
    square = fem.form(ufl.inner(D + D.T, D + D.T) * ufl.dx(domain=block.body.mesh))
    mean = np.sqrt(comm.allreduce(fem.assemble_scalar(square)) / np.prod(SIZE))
    assert mean > 10 * SMALL_INCREMENT
    assert 4 * mean * 1e-5 / 0.02 < SMALL_INCREMENT


@all_kinds
@all_laws
@pytest.mark.parametrize("size", [0.02, 1e-3, 1e-6])
def test_residual_along_the_increment_is_the_balance_of_energy(make, cell, degree, law, size):
    """du . R = dt^2/2 (kinetic + strain - work of gravity) for any increment: this conserves."""
    block = make(cell, degree, law)
    u, v, du = (nodal(block, wild(k, s)) for k, s in enumerate((0.02, 0.1, size), start=4))
    lhs = du.dot(residual(block, u, v, du))
    u1, v1 = u + du, (2 / DT) * du - v
    W0, W1 = energy(block, u), energy(block, u1)
    T0, T1 = kinetic(block, v), kinetic(block, v1)
    work = total(block, block.nodal_mass[:, None] * du.array_r.reshape(-1, 3)) @ GRAVITY
    rhs = HALF_DT2 * (T1 - T0 + W1 - W0 - work)
    # round-off of every energy; W of the neo-Hookean law rounds like the modulus times volume
    scale = T0 + T1 + W0 + W1 + abs(work) + 10 * np.prod(SIZE)
    assert abs(lhs - rhs) <= 50 * EPS * HALF_DT2 * scale


@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("tetrahedron", 2)])
def test_midpoint_stress_of_the_neo_hookean_law_fails_that_balance(comm, cell, degree):
    block = build(comm, cell, degree, "neo_hooke", stress=mean_stress)
    u, v, du = (nodal(block, wild(k, s)) for k, s in enumerate((0.02, 0.1, 0.02), start=4))
    lhs = du.dot(residual(block, u, v, du, 0 * GRAVITY))
    rhs = HALF_DT2 * (
        kinetic(block, (2 / DT) * du - v)
        - kinetic(block, v)
        + energy(block, u + du)
        - energy(block, u)
    )
    assert abs(lhs - rhs) > 1e-7


@all_kinds
@all_laws
def test_internal_forces_have_neither_resultant_nor_moment(make, cell, degree, law):
    """What is left of sum R and sum x_mid x R is the change of both momenta: they are conserved."""
    block = make(cell, degree, law)
    u, v, du = (nodal(block, wild(k, s)) for k, s in enumerate((0.02, 0.1, 0.02), start=7))
    R = residual(block, u, v, du, np.zeros(3))
    internal = (R - inertia(block, v, du)).array_r.reshape(-1, 3)
    x_mid = block.positions + (u + 0.5 * du).array_r.reshape(-1, 3)
    size = total(block, np.abs(internal)).sum()
    assert size > 0.01
    tolerance = 100 * EPS * (size + R.norm())
    assert np.max(np.abs(total(block, internal))) <= tolerance
    assert np.max(np.abs(total(block, np.cross(x_mid, internal)))) <= tolerance


@all_kinds
@all_laws
def test_rigid_motion_makes_no_internal_force(make, cell, degree, law):
    """From one finitely rotated and displaced position to another."""
    block = make(cell, degree, law)
    R0, R1 = rotation_about((1, 0, 0), 0.3), rotation_about((1, 2, 0.5), 1.5)
    u = nodal(block, affine(R0 - np.eye(3), (1.0, 2.0, 3.0)))
    u1 = nodal(block, affine(R1 - np.eye(3), (-3.0, 2.0, 0.0)))
    v, du = nodal(block, wild(10, 0.1)), u1 - u
    internal = residual(block, u, v, du, np.zeros(3)) - inertia(block, v, du)
    # F is rounded by some EPS times the displacements (5) over the size of an element (0.4)
    assert internal.norm() <= 500 * EPS * HALF_DT2 * 20
    assert abs(energy(block, u)) <= 100 * EPS * 20 * np.prod(SIZE)


@all_kinds
@all_laws
def test_strain_energy_is_frame_invariant(make, cell, degree, law):
    block = make(cell, degree, law)
    u, Q = nodal(block, wild(11, 0.02)), rotation_about((1, 2, 0.5), 2.5)
    turned = block.new_vector()
    x = block.positions + u.array_r.reshape(-1, 3)
    turned.array[:] = (x @ Q.T + [1.0, -2.0, 0.5] - block.positions).ravel()
    W = energy(block, u)
    assert W > 1e-3
    assert energy(block, turned) == pytest.approx(W, abs=200 * EPS * 20)  # moduli of 20


@all_kinds
def test_nodal_mass_adds_up_to_density_times_volume(make, cell, degree):
    block = make(cell, degree, "svk")
    assert total(block, block.nodal_mass) == pytest.approx(MASS, rel=1e-14)
    centre = total(block, block.nodal_mass[:, None] * block.positions) / MASS
    assert np.allclose(centre, SIZE / 2, rtol=0, atol=1e-14)


@all_kinds
def test_momenta_and_kinetic_energy_of_a_turning_block_equal_those_of_a_rigid_one(
    make, cell, degree
):
    """Inertia is integrated exactly, so that J is that of the cuboid."""
    block = make(cell, degree, "svk")
    c, w = np.array([1.0, -2.0, 0.5]), np.array([0.3, -1.0, 0.7])
    v = nodal(block, lambda X: c + np.cross(w, X))
    p = block.new_vector()
    block.momentum(v, p)
    momenta = p.array_r.reshape(-1, 3)
    m, x = MASS, SIZE / 2
    J = m / 12 * np.diag(np.sum(SIZE**2) - SIZE**2)
    V = c + np.cross(w, x)
    assert np.allclose(total(block, momenta), m * V, rtol=1e-13, atol=0)
    L = total(block, np.cross(block.positions, momenta))
    assert np.allclose(L, np.cross(x, m * V) + J @ w, rtol=0, atol=1e-13)
    assert kinetic(block, v) == pytest.approx(0.5 * m * V @ V + 0.5 * w @ J @ w, rel=1e-13)


@all_kinds
def test_a_free_block_at_rest_is_in_balance_in_free_fall_only(make, cell, degree):
    block = make(cell, degree, "svk")
    zero = block.new_vector()
    R = residual(block, zero, zero, zero).array_r.reshape(-1, 3)
    assert np.allclose(total(block, R), -HALF_DT2 * MASS * GRAVITY, rtol=1e-13, atol=0)
    fall = nodal(block, affine(np.zeros((3, 3)), HALF_DT2 * GRAVITY))
    assert residual(block, zero, zero, fall).norm() <= 100 * EPS * MASS * 2


STRETCH = np.diag([1.1, 0.97, 1.02])


def cauchy_by_hand(law):
    C = STRETCH @ STRETCH
    J = np.linalg.det(STRETCH)
    if law == "svk":
        E = 0.5 * (C - np.eye(3))
        S = LAMBDA * np.trace(E) * np.eye(3) + 2 * MU * E
    else:
        inverse = np.linalg.inv(C)
        S = MU * (np.eye(3) - inverse) + LAMBDA * np.log(J) * inverse
    return STRETCH @ S @ STRETCH / J


@all_kinds
@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_cauchy_stress_norm_of_a_uniform_stretch_equals_the_hand_value(make, cell, degree, law):
    block = make(cell, degree, law)
    Q = rotation_about((1, 2, 0.5), 2.5)
    norm = block.cauchy_stress_norm(nodal(block, affine(Q @ STRETCH - np.eye(3))))
    cells = block.body.mesh.topology.index_map(3)
    assert norm.shape == (cells.size_local + cells.num_ghosts,)
    assert np.allclose(norm, np.linalg.norm(cauchy_by_hand(law)), rtol=1e-12, atol=0)


@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_von_mises_stress_of_a_uniform_stretch_equals_the_hand_value(make, law):
    block = make("hexahedron", 1, law)
    _, found = block.cauchy_stresses(nodal(block, affine(STRETCH - np.eye(3))))
    s = cauchy_by_hand(law)
    shear = s[0, 1] ** 2 + s[1, 2] ** 2 + s[2, 0] ** 2
    normal = (s[0, 0] - s[1, 1]) ** 2 + (s[1, 1] - s[2, 2]) ** 2 + (s[2, 2] - s[0, 0]) ** 2
    assert np.allclose(found, np.sqrt(0.5 * normal + 3.0 * shear), rtol=1e-12, atol=0)


@all_kinds
def test_strain_energy_of_a_uniform_stretch_equals_the_hand_value(make, cell, degree):
    block = make(cell, degree, "svk")
    E = 0.5 * (STRETCH @ STRETCH - np.eye(3))
    W = 0.5 * LAMBDA * np.trace(E) ** 2 + MU * np.sum(E * E)
    u = nodal(block, affine(STRETCH - np.eye(3)))
    assert energy(block, u) == pytest.approx(W * np.prod(SIZE), rel=1e-12)


@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("tetrahedron", 2)])
def test_fibres_turn_with_the_body(comm, cell, degree):
    block = build(comm, cell, degree, "orthotropic", fibre=True)
    F = rotation_about((1, 2, 0.5), 2.5) @ STRETCH
    directions = block.fibre_directions(nodal(block, affine(F - np.eye(3))))
    cells = block.body.mesh.topology.index_map(3)
    assert directions.shape == (cells.size_local + cells.num_ghosts, 3)
    expected = F @ FRAME[:, 0] / np.linalg.norm(F @ FRAME[:, 0])
    assert np.allclose(directions, expected, rtol=0, atol=1e-13)


def test_a_body_without_fibres_has_no_fibre_directions(make):
    block = make("hexahedron", 1, "svk")
    assert block.fibre_directions(block.new_vector()) is None


@all_kinds
def test_nodal_values_come_with_ghosts(make, cell, degree):
    block = make(cell, degree, "svk")
    f = fem.Function(block.space)
    f.interpolate(lambda x: np.array([x[0], 2 * x[1], x[2] - x[0]]))
    X = nodal(block, affine([[1, 0, 0], [0, 2, 0], [-1, 0, 1]]))
    assert np.allclose(block.nodal_values(X).ravel(), f.x.array, rtol=0, atol=1e-14)


@all_kinds
@all_laws
def test_numbers_do_not_depend_on_the_number_of_ranks(make, cell, degree, law):
    """The same block on all ranks together and on each rank alone."""
    found = []
    for comm in (MPI.COMM_WORLD, MPI.COMM_SELF):
        block = make(cell, degree, law, comm=comm)
        u, v, du = (nodal(block, wild(k, s)) for k, s in enumerate((0.02, 0.1, 0.02), start=12))
        R = residual(block, u, v, du)
        block.assemble_tangent(du)
        product = block.new_vector()
        block.tangent.mult(v, product)
        stress = block.cauchy_stress_norm(u)
        largest = comm.allreduce(np.max(stress, initial=0.0), op=MPI.MAX)
        found.append([R.norm(), product.norm(), energy(block, u), kinetic(block, v), largest])
        found[-1].append(comm.allreduce(block.round_off))
    assert np.allclose(*found, rtol=1e-12, atol=0)  # sums in another order


@all_kinds
@all_laws
def test_round_off_of_the_forces_is_of_the_size_that_is_estimated(make, cell, degree, law):
    """A body turned by a small angle has no other forces than those of round-off."""
    block = make(cell, degree, law)
    u = nodal(block, affine(rotation_about((1, 2, 0.5), 0.02) - np.eye(3)))
    zero = block.new_vector()
    forces = residual(block, u, zero, zero, np.zeros(3)).norm() / HALF_DT2
    estimate = np.sqrt(MPI.COMM_WORLD.allreduce(block.round_off)) / HALF_DT2
    # 1.2 to 3.8 times; all cells are turned alike, so that their errors do not average out
    assert 0.1 <= forces / estimate <= 10.0


def test_round_off_grows_with_the_increment_and_with_viscosity_over_the_step(make):
    """Strains from increments have the round-off of these, and strain rates that over dt."""
    block = make("hexahedron", 1, "svk")
    zero, v = block.new_vector(), block.new_vector()

    def estimate(speed, dt, damped):
        v.array[:] = np.tile([speed, 0.0, 0.0], block.n_owned)
        damped.begin(zero, v, dt, np.zeros(3))
        return np.sqrt(MPI.COMM_WORLD.allreduce(damped.round_off)) / (0.5 * dt**2)

    rest = estimate(0.0, 0.1, block)
    assert estimate(0.0, 0.01, block) == pytest.approx(rest, rel=1e-12)
    moving = [estimate(speed, 0.1, block) for speed in (1e4, 2e4)]
    assert moving[0] > 10.0 * rest
    assert moving[1] - rest == pytest.approx(2.0 * (moving[0] - rest), rel=0.02)
    tau = 0.5
    law = KelvinVoigt(block.body.material, tau * MU, tau * (LAMBDA + 2.0 * MU / 3.0))
    viscous = FlexibleModel(FlexibleBody("viscous", block.body.mesh, law, DENSITY))
    assert estimate(0.0, 0.1, viscous) == pytest.approx(rest, rel=1e-12)
    more = [estimate(1e4, dt, viscous) - estimate(1e4, dt, block) for dt in (0.1, 0.01)]
    assert more[0] > 0.0
    # the same increment per step ten times as large takes the same strain rate
    assert more[1] == pytest.approx(more[0], rel=0.2)


@pytest.mark.parametrize("law", ["svk", "neo_hooke"])
def test_scale_of_the_terms_bounds_inertia_and_weight(make, law):
    """A backward error needs it: |M (du - dt v - h g)| can round no better than EPS of this."""
    block = make("hexahedron", 1, law)
    u, v, du = (nodal(block, wild(k, s)) for k, s in enumerate((0.0, 0.1, 0.02), start=12))
    terms = []
    for a, b, g in ((du, 0 * v, 0 * GRAVITY), (0 * du, v, 0 * GRAVITY), (0 * du, 0 * v, GRAVITY)):
        block.begin(u, b, DT, g)
        terms.append(np.sqrt(block.body.mesh.comm.allreduce(block.term_scale(a))))
    block.begin(u, v, DT, GRAVITY)
    scale = np.sqrt(block.body.mesh.comm.allreduce(block.term_scale(du)))
    assert 0.0 < min(terms) <= max(terms) < scale <= sum(terms)
    # lumped and consistent masses bound each other up to a small factor
    assert residual(block, u, v, du).norm() <= 2 * scale


def test_setting_up_a_step_does_not_change_the_state(make):
    block = make("hexahedron", 1, "neo_hooke")
    vectors = [nodal(block, wild(k, 0.02)) for k in range(20, 23)]
    before = [x.array_r.copy() for x in vectors]
    residual(block, *vectors)
    block.assemble_tangent(vectors[2])
    energy(block, vectors[0]), block.cauchy_stress_norm(vectors[0])
    assert all(np.array_equal(a, x.array_r) for a, x in zip(before, vectors, strict=True))


def test_looking_at_another_state_does_not_change_the_step(make):
    """An energy or a stress asked for between ``begin`` and the solution, by a monitor say."""
    block = make("hexahedron", 1, "svk")
    u, v, du, other = (nodal(block, wild(k, 0.02)) for k in range(23, 27))
    before = residual(block, u, v, du)
    block.begin(u, v, DT, GRAVITY)
    energy(block, other)
    after = block.new_vector()
    block.residual(du, after)
    assert (after - before).norm() == 0.0


def test_a_step_forgets_the_previous_one(make):
    block = make("hexahedron", 1, "neo_hooke")
    u, v, du = (nodal(block, wild(k, 0.02)) for k in range(27, 30))
    before = residual(block, u, v, du)
    residual(block, du, u, v, 2 * GRAVITY)
    block.begin(v, u, 3 * DT, -GRAVITY)
    block.assemble_tangent(u)
    assert (residual(block, u, v, du) - before).norm() == 0.0

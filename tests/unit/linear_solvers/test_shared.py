"""Claims about components that share a factor."""

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest
from newton_steps import options, run, values
from rotor_meshes import BLADE, ROTOR
from scipy.linalg import block_diag
from scipy.sparse import csr_matrix
from test_factor import error_of_solution, take_values

from turbine_fenicsx import Gravity, Revolute, StVenantKirchhoff, cell_field
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.rotations import E3, rotation_about
from turbine_fenicsx.linear_solvers import substructures, symmetric
from turbine_fenicsx.linear_solvers.congruence import Copy, find_groups
from turbine_fenicsx.linear_solvers.shared import Nodes, find_surroundings
from turbine_fenicsx.linear_solvers.substructures import Substructures
from turbine_fenicsx.meshing import MeshOptions, load_arrays
from turbine_fenicsx.meshing.rotor import mesh_rotor
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum

pytestmark = pytest.mark.parallel

CUBE = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T
alone = pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="a matrix of one rank")


def random_rotations(rng, n):
    """Rotations of n nodes, shape (3, 3, n)."""
    turns = [rotation_about(rng.normal(size=3), rng.uniform(0, 3)) for _ in range(n)]
    return np.moveaxis(np.array(turns), 0, -1)


def cubes(rng):
    """Three cubes of any stiffness: positions, rotations of the material, and the matrix.

    The second is the first after a rigid motion, with nodes in another order and turned each in
    its own way; as a cube looks alike from all sides, 24 motions fit the nodes, but one the matrix.
    The third differs from it in one entry.
    """
    S = rng.normal(size=(24, 24))
    A = S @ S.T + np.eye(24)
    Q, order = rotation_about((1.0, -2.0, 0.4), 2.2), rng.permutation(8)
    R = random_rotations(rng, 24)
    matrices = [A]
    for k in (1, 2):
        T = np.einsum("ian,ab,jbn->nij", R[:, :, 8 * k : 8 * k + 8], Q, R[:, :, :8])
        B = np.einsum("nij,njmk,mlk->niml", T, A.reshape(8, 3, 8, 3), T)
        if k == 2:
            B[3, 1, 3, 1] *= 1.0 + 1e-2
        matrices.append(B[order][:, :, order].reshape(24, 24))
    X = [CUBE, (CUBE @ Q.T + 5.0)[order], (CUBE @ Q.T - 5.0)[order]]
    # nodes of the components mixed
    mixed = rng.permutation(24)
    dofs = (3 * mixed[:, None] + np.arange(3)).ravel()
    all_ = block_diag(*matrices)[np.ix_(dofs, dofs)]
    R = np.concatenate([R[:, :, :8], R[:, :, 8:16][:, :, order], R[:, :, 16:][:, :, order]], axis=2)
    return np.concatenate(X)[mixed], R[:, :, mixed], csr_matrix(all_)


def test_of_all_motions_that_fit_the_nodes_the_one_is_found_that_fits_the_stiffness():
    X, R, A = cubes(np.random.default_rng(5))
    groups = find_groups(A, X, R)
    assert sorted(len(group) for group in groups) == [1, 2]
    for group in groups:
        first = A.toarray().reshape(24, 3, 24, 3)[group[0].nodes][:, :, group[0].nodes]
        for copy in group:
            B = A.toarray().reshape(24, 3, 24, 3)[copy.nodes][:, :, copy.nodes]
            turned = np.einsum("ijn,njmk,lkm->niml", copy.rotation, first, copy.rotation)
            # round-off; the differing entry may be on either side
            assert np.max(np.abs(B - turned)) < 1e-12 * np.max(np.abs(B))


def test_any_copy_can_be_the_first():
    """What leads from the second of three copies to the third takes one stiffness to the other."""
    rng = np.random.default_rng(8)
    S, R = rng.normal(size=(24, 24)), random_rotations(rng, 24)
    first, copies, matrices = (S @ S.T).reshape(8, 3, 8, 3), [], []
    for k, motion in enumerate(np.moveaxis(random_rotations(rng, 3), -1, 0)):
        nodes = np.arange(8 * k, 8 * k + 8)
        copies.append(Copy(nodes, R[:, :, nodes], motion))
        matrices.append(np.einsum("ijn,njmk,lkm->niml", R[:, :, nodes], first, R[:, :, nodes]))
    third = copies[2].relative_to(copies[1])
    found = np.einsum("ijn,njmk,lkm->niml", third.rotation, matrices[1], third.rotation)
    assert np.allclose(found, matrices[2], rtol=0, atol=1e-12)
    assert np.allclose(third.motion @ copies[1].motion, copies[2].motion, rtol=0, atol=1e-14)
    assert np.array_equal(third.nodes, copies[2].nodes)


def test_nodes_on_a_line_fit_no_single_motion():
    """Whatever turns about the line fits: each component keeps a factor of its own."""
    X = np.arange(4.0)[:, None] * [1.0, 2.0, -1.0]
    A = csr_matrix(block_diag(*[np.ones((12, 12)) + np.eye(12)] * 2))
    R = np.repeat(np.eye(3)[:, :, None], 8, axis=2)
    groups = find_groups(A, np.concatenate([X, X + 5.0]), R)
    assert [len(group) for group in groups] == [1, 1]


@pytest.mark.parametrize("differs", ["nothing", "place", "number"])
def test_what_surrounds_a_copy_is_matched_by_place(differs):
    rng, Q, t = np.random.default_rng(9), rotation_about((0.3, -1.0, 2.0), 1.1), np.full(3, 20.0)
    X, around, order = rng.normal(size=(6, 3)), rng.normal(size=(4, 3)), rng.permutation(4)
    own = Nodes(np.concatenate([X, X @ Q.T + t]), random_rotations(rng, 12))
    S = Nodes(np.concatenate([around, (around @ Q.T + t)[order]]), random_rotations(rng, 8))
    touched = [np.arange(4), np.arange(4, 8)]
    if differs == "place":
        S.positions[5] += 1e-3
    elif differs == "number":
        touched[1] = touched[1][:3]
    copies = [
        Copy(np.arange(6) + 6 * k, own.rotations[:, :, 6 * k :], M)
        for k, M in ((0, np.eye(3)), (1, Q))
    ]
    found, T = find_surroundings(copies, own, S, touched)
    if differs != "nothing":
        assert len(found) == len(T) == 1
        return
    assert np.array_equal(found[0], np.arange(4))
    assert np.allclose(S.positions[found[1]], around @ Q.T + t, rtol=0, atol=1e-12)
    for n, (a, b) in enumerate(zip(*found, strict=True)):
        expected = S.rotations[:, :, b] @ Q @ S.rotations[:, :, a].T
        assert np.allclose(T[1][:, :, n], expected, rtol=0, atol=1e-14)


@alone
@pytest.mark.parametrize("package", ["cholmod", "mumps"])
def test_solves_whatever_the_order_of_the_nodes(monkeypatch, package):
    if package == "mumps":
        monkeypatch.setattr(symmetric, "has_cholmod", lambda: False)
    X, R, A = cubes(np.random.default_rng(6))
    matrix = PETSc.Mat().createAIJ(A.shape, csr=(A.indptr, A.indices, A.data))
    own = matrix.copy()
    factor = Substructures(own, X, np.zeros(24, bool), "test_")
    factor.rotations = R
    for shift in (0.0, 1.0):
        matrix.shift(shift)
        take_values(own, matrix)
        factor.update()
        assert not own  # its place in memory is for the factors
        assert factor.factors == (2, 3)
        assert error_of_solution(factor, matrix) < 1e-11  # condition numbers of some 1e3
    B = np.sin(np.arange(72 * 5.0)).reshape(72, 5)
    B[:, 2] = 0.0
    dense = matrix.copy().convert("dense")  # by name: the array does not keep it
    assert np.allclose(dense.getDenseArray() @ factor.solve_many(B), B, rtol=0, atol=1e-11)
    assert not np.any(factor.solve_many(np.zeros((72, 2))))  # MUMPS refuses to solve for nothing
    factor.destroy()


@pytest.fixture(scope="module")
def rotor(comm):
    """Makes a rotor under its weight; a part of its second blade may be softer."""
    arrays = mesh_rotor(BLADE, ROTOR, MeshOptions("hexahedron", 1, elements=(2, 1, 24)))

    def make(spin=0.0, softer=0.0):
        loaded = load_arrays(comm, lambda: arrays, "rotor")
        mesh, n = loaded.mesh, loaded.mesh.topology.index_map(3).size_local
        shear, cells = np.full(n, 1e9), loaded.cells("blade_2")
        shear[cells[cells < n][::7]] *= 1.0 - softer
        hub = RigidBody("hub", 1e4, (1e5,) * 3, position=ROTOR.centre, angular_velocity=spin * E3)
        blades = FlexibleBody("b", mesh, StVenantKirchhoff(1e9, cell_field(mesh, shear)), 1500.0)
        roots = [Coupling(f"root {k}", blades, loaded.facets(f"root_{k}"), hub) for k in (1, 2, 3)]
        axis = Revolute("axis", None, hub, point=ROTOR.centre, axis=E3)
        return MultibodySystem(comm, [hub, axis, blades, *roots, Gravity()])

    return make


def solve(system, dt=0.02, steps=4):
    """Values and iterations after some steps, and the factors; None for one of all blades."""
    solver = EnergyMomentum(system, options=options("frozen"))
    state, reports = run(solver, system, steps, dt)
    factors = solver.factors
    solver.destroy()
    return values(state), [report.newton_iterations for report in reports], factors


def find_each_alone(matrix, positions, rotations):
    """Components, each the first of a group of its own."""
    groups = find_groups(matrix, positions, rotations)
    return [[copy.relative_to(copy)] for group in groups for copy in group]


@pytest.mark.parametrize(("softer", "factors"), [(0.0, 1), (0.01, 2)])
def test_results_and_iterations_are_those_of_a_factor_for_each(rotor, monkeypatch, softer, factors):
    found, iterations, used = solve(rotor(1.0, softer))
    monkeypatch.setattr(substructures, "find_groups", find_each_alone)
    expected, as_before, _ = solve(rotor(1.0, softer))
    size = rotor().comm.size
    assert used == (factors * size, 3 * size)  # each rank has the same slab of each blade
    assert iterations == as_before
    for x, y in zip(found, expected, strict=True):
        # equations solved to 1e-12, of multipliers that are sums of larger terms; four steps
        assert np.max(np.abs(x - y), initial=0.0) <= 1e-9 * np.max(np.abs(y), initial=0.0) + 1e-12

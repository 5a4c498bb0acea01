"""Claims about conjugate gradients with section motions, and the parts they are made of."""

from petsc4py import PETSc

import numpy as np
import pytest
from dolfinx.mesh import CellType, create_box, locate_entities_boundary
from test_factor import error_of_solution, tridiagonal
from walls import load_wall, wall_arrays

from turbine_fenicsx import StepTimes, StVenantKirchhoff
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.linear_solvers.iterative import (
    SectionMultigrid,
    take_diagonal,
    take_upper_triangle,
)
from turbine_fenicsx.linear_solvers.sections import section_motions
from turbine_fenicsx.linear_solvers.symmetric import GatheredFactor, SymmetricFactor
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep
from turbine_fenicsx.time_stepping.solver_options import SolverOptions

pytestmark = pytest.mark.parallel


def bar(comm, width=4, layers=64, poisson=0.3):
    """A clamped bar: body, coupling, A_II, free degrees of freedom and positions of free nodes."""
    corners = [np.zeros(3), np.array([1.0, 1.0, 16.0])]
    mesh = create_box(comm, corners, [width, width, layers], cell_type=CellType.hexahedron)
    law = StVenantKirchhoff(2e9 * poisson / (1.0 - 2.0 * poisson), 1e9)
    body = FlexibleBody("bar", mesh, law, 1e3)
    root = locate_entities_boundary(mesh, 2, lambda x: np.isclose(x[2], 0.0))
    system = MultibodySystem(comm, [body, Coupling("root", body, root, None)])
    (flexible,), (coupling,) = system.flexible_models, system.coupling_blocks
    step, rest = FlexibleStep(flexible), flexible.new_vector()
    step.start_step(rest, rest, StepTimes.from_start(0.0, 0.02), np.zeros(3))
    step.assemble_tangent(rest)
    nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
    free = (3 * nodes[:, None] + np.arange(3)).ravel() + step.tangent.getOwnershipRange()[0]
    rows = PETSc.IS().createGeneral(free.astype(PETSc.IntType), comm=comm)
    matrix = step.tangent.createSubMatrix(rows, rows)
    matrix.setBlockSize(3)
    return flexible, coupling, matrix, rows, flexible.positions[nodes]


def solve_for_forces(comm, tolerance=1e-2, **options):
    """Energy of the error relative to that of the solution, and iterations, for smooth forces."""
    flexible, coupling, matrix, free, X = bar(comm, **options)
    exact, kept = SymmetricFactor(matrix.copy(), "exact_"), matrix.copy()
    exact.update()
    solver = SectionMultigrid(flexible, coupling, matrix, free, "test_", tolerance)
    solver.update()
    expected, b = kept.createVecs()
    x, force = b.copy(), b.copy()
    b.array[:] = np.stack([np.sin(3.0 * X[:, 2]), np.cos(X[:, 0]), X[:, 1] ** 2], axis=1).ravel()
    solver.solve(b, x)
    exact.solve(b, expected)
    iterations, energy = solver.iterations, b.dot(expected)
    x.axpy(-1.0, expected)
    kept.mult(x, force)
    solver.destroy()
    exact.destroy()
    return force.dot(x) / energy, iterations


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_errors_are_as_small_as_asked_in_the_norm_of_the_energy(comm, tolerance, poisson):
    error, iterations = solve_for_forces(comm, tolerance, poisson=poisson)
    assert error < (2.0 * tolerance) ** 2  # what is left is estimated
    assert iterations <= {1e-2: 4, 1e-6: 12}[tolerance] * (3 if poisson > 0.4 else 1)


def test_iterations_depend_neither_on_ranks_nor_on_the_mesh(comm):
    alone = solve_for_forces(PETSc.COMM_SELF.tompi4py())
    assert solve_for_forces(comm)[1] == alone[1] == solve_for_forces(comm, width=6, layers=96)[1]


def test_solutions_of_several_right_hand_sides_are_those_of_each(comm):
    flexible, coupling, matrix, free, X = bar(comm)
    solver = SectionMultigrid(flexible, coupling, matrix, free, "test_")
    solver.update()
    B = np.stack([X.ravel(), np.cos(X).ravel()], axis=1)
    both = solver.solve_many(B)
    assert np.array_equal(both, np.hstack([solver.solve_many(b[:, None]) for b in B.T]))
    solver.destroy()


def polynomials(x, degree):
    """Displacements in all directions that are linear along x_2 and of a degree across, columns."""
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    across = [x[:, 0] ** i * x[:, 1] ** j for i, j in powers]
    each = np.stack([f * g for f in across for g in (np.ones(len(x)), x[:, 2])], axis=1)
    return np.kron(each, np.eye(3))


@pytest.mark.parametrize(("width", "degree", "unknowns"), [(1, 2, 18), (6, 2, 18), (9, 3, 30)])
def test_section_motions_contain_bending_and_how_sections_change_with_it(
    comm, width, degree, unknowns
):
    flexible, coupling, matrix, _, X = bar(comm, width, layers=12)
    nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
    P = section_motions(flexible, nodes)
    # gathered and dense: the least squares distance of what is to be contained from the range of P
    rows = P.getOwnershipRange()
    assert P.getSize()[0] == matrix.getSize()[0] and rows[1] - rows[0] == 3 * len(nodes)
    P_all = np.concatenate(comm.allgather(P.getValues(range(*rows), range(P.getSize()[1]))))
    motions = np.concatenate(comm.allgather(polynomials(X, degree)))
    found = np.linalg.lstsq(P_all, motions, rcond=1e-10)[0]
    assert np.max(np.abs(P_all @ found - motions)) < 1e-10 * np.max(np.abs(motions))
    assert P_all.shape[1] == 12 * unknowns
    assert np.all(np.any(P_all != 0.0, axis=0))


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_section_motions_contain_every_rigid_motion(machine, cell):
    system = machine(cell=cell).system()
    (block,), (coupling,) = system.flexible_models, system.coupling_blocks
    nodes = np.setdiff1d(np.arange(block.n_owned), coupling.nodes)
    P, x = section_motions(block, nodes), block.positions[nodes] - [1.0, 0.2, -1.1]
    rows, comm = P.getOwnershipRange(), system.comm
    P_all = np.concatenate(comm.allgather(P.getValues(range(*rows), range(P.getSize()[1]))))
    moved = [np.broadcast_to(e, x.shape) for e in np.eye(3)] + [np.cross(e, x) for e in np.eye(3)]
    rigid = np.concatenate(comm.allgather(np.stack([m.ravel() for m in moved], axis=1)))
    found = np.linalg.lstsq(P_all, rigid, rcond=1e-10)[0]
    assert np.max(np.abs(P_all @ found - rigid)) < 1e-10


def test_sections_belong_to_a_rank_that_has_nodes_of_them(comm):
    flexible, coupling, *_ = bar(comm)
    nodes = np.setdiff1d(np.arange(flexible.n_owned), coupling.nodes)
    P = section_motions(flexible, nodes)
    first, last = P.getOwnershipRangeColumn()
    columns = P.getValuesCSR()[1]
    own = (columns >= first) & (columns < last)
    # ranks meet in one section or two; the others are nobody else's
    assert set(range(first, last)) <= set(columns) and np.count_nonzero(own) > 0.8 * own.size


def test_upper_triangle_and_diagonal_are_those_of_the_matrix(comm):
    _, _, matrix, *_ = bar(comm, layers=8)
    upper, diagonal = take_upper_triangle(matrix), take_diagonal(matrix)
    assert upper.getType().endswith("sbaij") and upper.getBlockSize() == 3
    x, one, two = (matrix.createVecLeft() for _ in range(3))
    x.array[:] = np.arange(x.array_r.size) + 1.0
    matrix.mult(x, one)
    upper.mult(x, two)
    two.axpy(-1.0, one)
    assert two.norm() <= 1e-14 * one.norm()
    rows = range(*matrix.getOwnershipRange())
    blocks = np.kron(np.eye(len(rows) // 3), np.ones((3, 3)))
    expected = matrix.getValues(rows, rows) * blocks
    assert np.array_equal(diagonal.getValues(rows, rows), expected)
    assert upper.getInfo()["nz_used"] < 0.6 * matrix.getInfo()["nz_used"]


def test_gathered_factor_solves_and_follows_new_values(comm):
    A = tridiagonal(comm, 50, 2.5)
    ksp = PETSc.KSP().create(comm)
    ksp.setType("preonly")
    ksp.getPC().setType("python")
    ksp.getPC().setPythonContext(GatheredFactor())
    for shift in (0.0, 1.0):
        A.shift(shift)
        ksp.setOperators(A)
        assert error_of_solution(ksp, A) < 1e-13
    ksp.destroy()


def test_iterative_solver_refuses_thin_walls_in_words(comm):
    def tube(s, a, zeta):
        r = 1.0 + 2e-3 * zeta
        return np.stack([30.0 * s, r * np.cos(2 * np.pi * a), -r * np.sin(2 * np.pi * a)], axis=-1)

    loaded, _ = load_wall(comm, wall_arrays(tube, 10, 16, closed=True))
    body = FlexibleBody("tube", loaded.mesh, StVenantKirchhoff(1e9, 1e9), 1e3, 2)
    root = Coupling("root", body, loaded.facets("root"), None)
    system = MultibodySystem(comm, [body, root])
    solver = EnergyMomentum(system, options=SolverOptions("iterative"))
    state = system.initial_state()
    with pytest.raises(ModelError, match=r"body 'tube'.*thin walls; use solver.linear_solver = "):
        solver.advance(state, 0.01, state.copy())
    solver.destroy()

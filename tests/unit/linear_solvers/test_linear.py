"""Claims about the linear solvers: exact ones solve, and all agree with each other."""

from petsc4py import PETSc

import numpy as np
import pytest
from wild_steps import begun, loaded, wild_state, wild_unknowns

from turbine_fenicsx.analysis.statics import EquilibriumBlocks
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.dense import ScaledFactor
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.linear_solvers import LINEAR_SOLVERS, shared
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.linear_solvers.monolithic import MonolithicLU
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentumStep

EXACT = [Elimination, MonolithicLU]
all_exact = pytest.mark.parametrize("solver", EXACT)
DT = 0.05


def solution(solver, step, b):
    """Prepare for the tangent at the step's unknowns, and solve."""
    solver.update(step.x)
    x = step.new_nested_vector()
    solver.solve(b, x)
    return x


def relative_error(step, x, b):
    """|J x - b| over |b|, block by block, with the tangent assembled anew."""
    step.tangent(step.x)
    Jx = step.new_nested_vector()
    step.tangent_matrix.mult(x, Jx)
    Jx.axpy(-1.0, b)
    pairs = zip(Jx.getNestSubVecs(), b.getNestSubVecs(), strict=True)
    return np.max([error.norm() / max(part.norm(), 1.0) for error, part in pairs])


def distance(x, y):
    """Largest relative difference of any block."""
    pairs = zip(x.getNestSubVecs(), y.getNestSubVecs(), strict=True)
    return np.max([(a - b).norm() / max(b.norm(), 1e-10) for a, b in pairs])


@all_exact
@pytest.mark.parametrize("form", ["regular", "paper"])
@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("tetrahedron", 2)])
def test_exact_solvers_solve_with_the_nested_tangent(machine, solver, form, cell, degree):
    step, _ = begun(loaded(machine, cell=cell, degree=degree), form=form)
    linear = solver(step, "test_")
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    x = solution(linear, step, b)
    # condition numbers up to 1e4 of saddle points that are of order one otherwise
    assert relative_error(step, x, b) <= 1e-11
    linear.destroy()


def tip(m, carrier):
    return Coupling("tip", m.beam, m.facets(1.5), carrier)


def other_body(machine):
    return FlexibleBody("other", machine(cell="tetrahedron").beam.mesh, SVK, 2.0)


SVK = StVenantKirchhoff(1000.0, 500.0)
KINDS = {
    "one carrier": lambda m, _: m.parts,
    "two carriers": lambda m, _: [*m.parts, tip(m, m.nacelle)],
    "carrier and ground": lambda m, _: [*m.parts, tip(m, None)],
    "ground only": lambda m, _: [m.beam, tip(m, None)],
    "ground beside rigid": lambda m, _: [*m.parts[:5], tip(m, None)],
    "free": lambda m, _: m.parts[:5],
    "free alone": lambda m, _: [m.beam],
    "two bodies": lambda m, machine: [*m.parts, other_body(machine)],
    "rigid only": lambda m, _: m.parts[:4],
}
"""Parts of systems with all kinds of couplings: to one body, to two, to the ground, none."""


@pytest.fixture
def make(comm, machine):
    """System of a kind."""
    return lambda kind: MultibodySystem(comm, KINDS[kind](machine(spin=1.0), machine))


def kinds(*names):
    return pytest.mark.parametrize("kind", names or KINDS)


@pytest.mark.parallel
@kinds()
def test_elimination_and_monolithic_solver_find_the_same_solution(make, kind):
    step, _ = begun(make(kind))
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    solvers = [solver(step, "test_") for solver in EXACT]
    one, other = (solution(solver, step, b) for solver in solvers)
    assert relative_error(step, one, b) <= 1e-11
    assert distance(one, other) <= 1e-9
    for solver in solvers:
        solver.destroy()


@all_exact
def test_an_update_replaces_the_factors(machine, solver):
    """No value of the tangent before is left anywhere."""
    system = loaded(machine)
    step, _ = begun(system)
    linear = solver(step, "test_")
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    first = solution(linear, step, b)
    step.start_step(wild_state(system, seed=7), 2 * DT)
    wild_unknowns(step, seed=8).copy(step.x)
    second = solution(linear, step, b)
    assert relative_error(step, second, b) <= 1e-11
    assert distance(first, second) > 1e-2
    linear.destroy()


@all_exact
def test_solving_twice_gives_the_same_and_leaves_the_right_hand_side(machine, solver):
    step, _ = begun(loaded(machine))
    linear = solver(step, "test_")
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    before, x = b.copy(), solution(linear, step, b)
    again = wild_unknowns(step, seed=31)  # the start value must not matter
    linear.solve(b, again)
    again.axpy(-1.0, x)
    assert again.norm() == 0.0
    before.axpy(-1.0, b)
    assert before.norm() == 0.0
    linear.destroy()


@pytest.mark.parallel
@kinds("carrier and ground", "free", "two bodies")
@pytest.mark.parametrize("squeezed", [0.0, 0.6])
def test_negative_eigenvalues_are_counted_as_of_the_nested_matrix(make, kind, squeezed):
    """Each coupled displacement and its multiplier make one positive and one negative pair."""
    system = make(kind)
    state, comm = wild_state(system), system.comm
    for model, u in zip(system.flexible_models, state.u, strict=True):
        u.array[:] = -squeezed * model.positions.ravel()
    blocks = EquilibriumBlocks(system, state)
    blocks.mass = 1.0  # free bodies resist, too
    solver = Elimination(blocks, "test_", symmetric=True)
    solver.update(blocks.residual_vector)
    whole = blocks.tangent_matrix.convert("aij", PETSc.Mat())
    rows = whole.getValues(range(*whole.getOwnershipRange()), range(whole.getSize()[1]))
    values = np.linalg.eigvalsh(np.concatenate(comm.allgather(rows)))
    coupled = comm.allreduce(sum(c.dofs.size for c in system.coupling_blocks))
    assert np.min(np.abs(values)) > 1e-6  # no sign is in doubt
    assert solver.count_negative() == np.count_nonzero(values < 0.0) - coupled
    solver.destroy()
    blocks.destroy()


def at_rest(state):
    """The state without velocities, where the tangent is symmetric."""
    state.q_dot[:] = 0.0
    state.joint_rates[:] = 0.0
    for vector in state.v:
        vector.set(0.0)
    return state


def guessed(step, state):
    """A step at its first guess."""
    step.start_step(state, DT)
    step.guess(True)
    return step


@pytest.fixture
def accuracy(comm):
    """Of the frozen factor where it was made; ranks that meet leave out what is negligible."""
    return 1e-9 if comm.size == 1 else shared.NEGLIGIBLE


@pytest.mark.parallel
@kinds()
def test_frozen_factor_is_exact_where_it_was_made(make, kind, accuracy):
    system = make(kind)
    step = EnergyMomentumStep(system)
    guessed(step, at_rest(wild_state(system)))
    frozen, exact = (LINEAR_SOLVERS[name](step, "test_") for name in ("frozen", "lu"))
    frozen.start_iteration()
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    assert distance(solution(frozen, step, b), solution(exact, step, b)) <= accuracy
    for solver in (frozen, exact):
        solver.destroy()


def turned(system, state, R):
    """The state at rest after a rotation about the origin of everything."""
    out = state.copy()
    out.q[:] = (out.q.reshape(-1, 3) @ R.T).ravel()
    for block, u in zip(system.flexible_models, out.u, strict=True):
        x = block.positions + u.array_r.reshape(-1, 3)
        u.array[:] = (x @ R.T - block.positions).ravel()
    return out


@kinds("one carrier", "two carriers", "free", "two bodies")
def test_frozen_factor_turns_with_the_system(make, kind, accuracy):
    """After a rotation of everything it is as exact as where it was made."""
    system = make(kind)
    step = EnergyMomentumStep(system)
    state = at_rest(wild_state(system))
    guessed(step, state)
    frozen, exact = (LINEAR_SOLVERS[name](step, "test_") for name in ("frozen", "lu"))
    frozen.start_iteration()
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    guessed(step, turned(system, state, rotation_about((1.0, 2.0, -0.5), 2.0)))
    frozen.start_iteration()
    assert distance(solution(frozen, step, b), solution(exact, step, b)) <= accuracy
    for solver in (frozen, exact):
        solver.destroy()


@pytest.mark.parallel
@kinds("two carriers", "two bodies")
def test_a_restored_frozen_factor_solves_as_the_one_that_was_saved(make, kind):
    """To the last bit, although the state that it was made at is another one by then."""
    system = make(kind)
    step = EnergyMomentumStep(system)
    state = at_rest(wild_state(system))
    guessed(step, state)
    one, other = (LINEAR_SOLVERS["frozen"](step, "test_") for _ in range(2))
    one.start_iteration()
    data = one.save()
    later = turned(system, state, rotation_about((1.0, 2.0, -0.5), 0.1))
    state.q += 1.0
    for u in state.u:
        u.shift(1.0)
    other.restore(data)
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    found = []
    for solver in (one, other):
        guessed(step, later)
        solver.start_iteration()
        found.append(solution(solver, step, b))
        solver.destroy()
    assert distance(*found) == 0.0


def test_frozen_factor_never_opens_the_coupling(machine):
    """However poor the factor: a correction fulfils the linear rows to round-off."""
    system = loaded(machine)
    step = EnergyMomentumStep(system)
    guessed(step, wild_state(system))
    frozen = LINEAR_SOLVERS["frozen"](step, "test_")
    frozen.start_iteration()
    guessed(step, wild_state(system, seed=9))
    frozen.start_iteration()
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    x = solution(frozen, step, b)
    Jx = step.new_nested_vector()
    step.tangent(step.x)
    step.tangent_matrix.mult(x, Jx)
    (found,), (expected,) = step.split(Jx)[1], step.split(b)[1]
    size = x.norm()
    assert (found - expected).norm() <= 1e-14 * size
    frozen.destroy()


def test_solvers_without_flexible_bodies_are_exact_under_every_name(make):
    step, _ = begun(make("rigid only"))
    b = wild_unknowns(step, seed=30, sizes=(1.0, 1.0, 1.0))
    for name, make in LINEAR_SOLVERS.items():
        solver = make(step, "test_")
        solver.start_iteration()
        assert relative_error(step, solution(solver, step, b), b) <= 1e-11, name
        solver.destroy()


def test_scaled_solution_survives_rows_and_columns_of_any_size():
    """Units must not matter: twenty powers of ten between rows and columns."""
    rng = np.random.default_rng(1)
    A, x = rng.normal(size=(8, 8)), rng.normal(size=8)
    rows, columns = 10.0 ** rng.integers(-10, 10, (2, 8))
    y = ScaledFactor(rows[:, None] * A * columns).solve(rows * (A @ x))
    assert np.allclose(y * columns, x, rtol=1e-12, atol=0)  # condition number of A some ten


def test_small_rows_are_not_lost_beside_large_ones():
    """Without scaling, elimination of the first row would wipe out the second."""
    A = np.array([[1.0, 1e17], [1.0, 1.0]])
    assert np.allclose(ScaledFactor(A).solve(A @ np.ones(2)), np.ones(2), rtol=1e-12, atol=0)


def test_a_singular_matrix_gives_no_number_instead_of_an_exception():
    """An exception on rank 0 alone would leave the other ranks waiting."""
    A = np.zeros((2, 2))
    assert np.all(np.isnan(ScaledFactor(A).solve(np.ones(2))))
    A[0, 0] = 1.0
    assert np.all(np.isnan(ScaledFactor(A).solve(np.ones(2))))


def test_no_equations_have_the_empty_solution():
    assert ScaledFactor(np.zeros((0, 0))).solve(np.zeros(0)).shape == (0,)

"""Claims about the elimination of reduced bodies, alone and beside a full one."""

import numpy as np
import pytest
from reduced_beams import COMM, beam, facets_at, gusts, march, on_hub, rotor
from scipy.linalg import block_diag

from turbine_fenicsx import Coupling, EnergyMomentum, MultibodySystem, SolverOptions
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.linear_solvers import LINEAR_SOLVERS
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentumStep

pytestmark = pytest.mark.parallel
DT = 0.02


def machine(mixed):
    """Three reduced blades on a hub, and perhaps a full one in the fourth place."""
    body = rotor()
    system = on_hub([body], *gusts(body), speed=2.0)
    if not mixed:
        return system
    hub, full = system.rigid_bodies[0], beam()
    parts = [*system.rigid_bodies, *system.joints, body, full, *system.couplings, *gusts(body)]
    return MultibodySystem(
        COMM, [*parts, Coupling("root of beam", full, facets_at(full, 0.0), hub)]
    )


def start(system):
    """A step from its guess, and a direct solver for the tangent there."""
    step = EnergyMomentumStep(system)
    step.start_step(system.initial_state(), DT)
    step.guess(True)
    solver = LINEAR_SOLVERS["lu"](step, "test_dense_")
    solver.update(step.x)
    return step, solver


def check_solution(step, solver):
    """A random right-hand side is solved for."""
    rng = np.random.default_rng(COMM.rank)
    b, x, Ax = (step.new_nested_vector() for _ in range(3))
    for part in b.getNestSubVecs():
        part.array[:] = rng.standard_normal(part.getLocalSize())
    solver.solve(b, x)
    step.tangent_matrix.mult(x, Ax)
    Ax.axpy(-1.0, b)
    size = max(part.norm() for part in b.getNestSubVecs())
    assert max(part.norm() for part in Ax.getNestSubVecs()) < 1e-7 * size
    solver.destroy()


@pytest.mark.parametrize("mixed", [False, True])
def test_corrections_solve_the_equations_of_the_step(mixed):
    check_solution(*start(machine(mixed)))


def test_corrections_solve_the_equations_of_copies_that_have_turned():
    """A_uu of the matrix is turned by hand."""
    step, solver = start(machine(False))
    Q = np.array([rotation_about((k, 1.0, -2.0), 0.5 + k) for k in range(3)])
    Q = Q[: 3 if COMM.rank == 0 else 0]
    step.turn_tangents = lambda x: [(Q, 0.0)]
    assert solver.turn(step.x)
    if COMM.rank == 0:
        dense = step.tangents[0].getDenseArray()
        size = len(dense) // 3
        turns = block_diag(*(np.kron(np.eye(size // 3), R) for R in Q))
        dense[:] = turns @ dense @ turns.T
    step.tangents[0].assemble()
    check_solution(step, solver)


@pytest.mark.parametrize("mixed", [False, True])
def test_all_linear_solvers_make_the_same_steps(mixed):
    ends = {}
    for name in ("frozen", "lu", "monolithic"):
        system = machine(mixed)
        options = SolverOptions(linear_solver=name)
        state, _, _ = march(EnergyMomentum(system, options=options), system.initial_state(), DT, 4)
        ends[name] = np.concatenate([state.q, *(COMM.bcast(u.array_r.copy()) for u in state.u)])
    for name in ("frozen", "monolithic"):
        assert np.max(np.abs(ends[name] - ends["lu"])) < 1e-10


def test_systems_without_full_bodies_need_no_approximate_solver():
    system = machine(False)
    solver = EnergyMomentum(system)
    _, _, reports = march(solver, system.initial_state(), DT, 3)
    assert solver.factors == (0, 0)
    assert solver.fallbacks == 0
    assert len(reports) == 3

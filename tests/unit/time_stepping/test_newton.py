"""Claims about Newton's method for one step: how it converges, fails, and takes options."""

import gc

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest
from newton_steps import DT, PREFIX, all_solvers, loaded, options, run, spinning_top

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.linear_solvers import LINEAR_SOLVERS
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.solver_options import SolverOptions


@pytest.fixture
def database():
    """PETSc's options; what a test added goes away afterwards."""
    found = PETSc.Options()
    before = found.getAll()
    yield found
    for key in set(found.getAll()) - set(before):
        found.delValue(key)


@pytest.mark.parametrize("name", ["lu", "monolithic"])
def test_newton_converges_quadratically_with_the_exact_tangent(solve, machine, name):
    """A long step of the soft beam, in which it bends visibly, so that there is something to see:
    the error at least squares with each iteration, from 1e-3 down to round-off."""
    system = loaded(machine(spin=3.0))
    solver, errors = solve(system, options(name)), []

    def watch(snes, iteration, norm):
        errors.append(np.max(solver.step.relative_residuals(snes.getFunction()[0])))

    solver.snes.setMonitor(watch)
    solver.advance(system.initial_state(), 0.1, system.initial_state())
    e = np.array([x for x in errors if x > 1e-12])
    assert len(e) >= 4
    assert e[0] > 1e-3
    orders = np.log(e[2:] / e[1:-1]) / np.log(e[1:-1] / e[:-2])
    assert np.max(orders) > 1.8 and orders[-1] > 1.5, e


def test_a_linear_solver_is_made_at_the_first_step(solve, machine, monkeypatch):
    """Its matrices would take memory that the search of a start needs."""
    made = []

    def make(*arguments):
        made.append(1)
        return wanted(*arguments)

    wanted = LINEAR_SOLVERS["frozen"]
    monkeypatch.setitem(LINEAR_SOLVERS, "frozen", make)
    system = loaded(machine(spin=3.0))
    solver = solve(system, options("frozen"))
    assert not made
    run(solver, system, steps=2)
    assert made == [1]


@pytest.mark.parallel
@all_solvers
def test_a_step_conserves_energy_and_keeps_constraints(solve, machine, name):
    system = loaded(machine(spin=3.0))
    solver = solve(system, options(name))
    state, reports = run(solver, system, steps=5)
    initial, final = (system.balance(s) for s in (system.initial_state(), state))
    work = sum(r.work for r in reports)
    assert abs(work) > 1e-4
    # tolerance 1e-12 of Newton's method times energies of order ten, over five steps
    assert abs(final.total - initial.total - work) <= 1e-10
    assert system.constraint_error(state) <= 1e-12
    assert state.time == pytest.approx(5 * DT, rel=1e-15)
    assert max(r.residual for r in reports) <= 1e-9


@pytest.mark.parallel
def test_all_linear_solvers_lead_to_the_same_state(solve, machine):
    system = loaded(machine(spin=3.0, cell="tetrahedron", degree=2))
    found = []
    for name in LINEAR_SOLVERS:
        solver = solve(system, options(name))
        state, _ = run(solver, system)
        found.append([state.q, state.joint_coordinates, state.u[0].array_r.copy()])
        solver.destroy()
    for other in found[1:]:
        for a, b in zip(found[0], other, strict=True):
            assert np.allclose(a, b, rtol=0, atol=1e-9)  # positions of order one


@pytest.mark.parallel
@all_solvers
def test_the_state_does_not_depend_on_the_number_of_ranks(solve, comm, machine, name):
    found = []
    for c in (comm, MPI.COMM_SELF):
        system = loaded(machine(spin=3.0, comm=c))
        solver = solve(system, options(name))
        state, _ = run(solver, system)
        b = system.balance(state)
        found.append(
            [*state.q, *state.joint_coordinates, b.kinetic, b.strain, b.potential, *b.angular]
        )
    assert np.allclose(*found, rtol=0, atol=1e-9)  # numbers of order one to ten


@pytest.mark.parametrize("dt", [1e-2, 1e-4, 1e-6])
def test_short_steps_converge_to_the_same_accuracy(solve, machine, dt):
    """The residual floor does not grow as 1/dt: increments are solved for, not positions."""
    system = loaded(machine(spin=3.0))
    solver = solve(system, options())
    state, reports = run(solver, system, steps=2, dt=dt)
    assert max(r.newton_iterations for r in reports) <= 6
    assert system.constraint_error(state) <= 1e-13
    rate = state.joint_rates[1]
    assert rate == pytest.approx(3.0, abs=10 * dt + 1e-7)  # a start from rest of the beam


@all_solvers
def test_a_system_without_flexible_bodies_advances(solve, comm, name):
    solver = solve(spinning_top(comm, spin=3.0), options(name))
    state, _ = run(solver, solver.step.system)
    # torque-free about its axis: tan(D/2) = spin dt/2 in each step
    assert state.joint_coordinates[0] == pytest.approx(6 * np.arctan(3.0 * DT / 2), rel=1e-12)


def test_a_step_after_many_turns_takes_no_more_iterations(solve, comm):
    """Of an angle of 1e5 the last digit is worth 1e-11; nothing smaller can be asked of it."""
    system = spinning_top(comm, spin=3.0)
    solver = solve(system, options("lu"))
    state, out = system.initial_state(), system.initial_state()
    first = solver.advance(state, DT, out)
    turns = 2 * np.pi * 20_000
    state.joint_coordinates[:] = turns
    late = solver.advance(state, DT, out)
    assert late.newton_iterations <= first.newton_iterations
    assert out.joint_coordinates[0] - turns == pytest.approx(2 * np.arctan(3.0 * DT / 2), rel=1e-9)


@all_solvers
def test_a_system_without_rigid_bodies_advances(solve, comm, machine, name):
    m = machine()
    system = MultibodySystem(
        comm, [m.beam, Coupling("foot", m.beam, m.facets(0.5), None), Gravity()]
    )
    solver = solve(system, options(name))
    state, _ = run(solver, system)
    assert abs(system.balance(state).total) <= 1e-10
    assert system.constraint_error(state) <= 1e-14


@all_solvers
def test_options_leave_no_trace_in_the_database(solve, machine, database, name):
    prefix = f"no_trace_of_{name}_"  # used by no other test
    before, system = database.getAll(), loaded(machine())
    solver = solve(system, SolverOptions(linear_solver=name, prefix=prefix))
    assert database.getAll() == before
    run(solver, system, steps=1)
    solver.destroy()
    assert database.getAll() == before
    assert not any(key.startswith(prefix) for key in before)


def described(solver, folder):
    """What PETSc says about the solver's settings."""
    viewer = PETSc.Viewer().createASCII(str(folder / "snes.txt"), comm=solver.step.system.comm)
    solver.snes.view(viewer)
    viewer.destroy()
    solver.step.system.comm.barrier()
    return (folder / "snes.txt").read_text()


def test_full_newton_steps_are_the_default_and_options_with_the_prefix_win(
    solve, machine, database, shared_tmp_path
):
    system = loaded(machine())
    solver = solve(system, options())
    assert "type: basic" in described(solver, shared_tmp_path)
    assert solver.snes.getKSP().getType() == "preonly"
    database[PREFIX + "snes_linesearch_type"] = "bt"
    database[PREFIX + "ksp_type"] = "gmres"
    mine = database.getAll()
    solver = solve(system, options())
    assert "type: bt" in described(solver, shared_tmp_path)
    assert solver.snes.getKSP().getType() == "gmres"
    assert database.getAll() == mine
    state, _ = run(solver, system)
    assert system.constraint_error(state) <= 1e-12


def test_options_of_another_prefix_do_nothing(solve, machine, database):
    database["other_ksp_type"] = "gmres"
    database["ksp_type"] = "gmres"
    solver = solve(loaded(machine()), options())
    assert solver.snes.getKSP().getType() == "preonly"


def test_the_frozen_factor_serves_a_fast_rotor(solve, machine):
    """It turns with the rotor, a fifth of a radian in each step."""
    system = machine(spin=10.0).system()
    solver = solve(system, options("frozen"))
    _, reports = run(solver, system, steps=6)
    # eight to ten; full Newton takes three or four, and the factor of a fixed frame fails
    assert max(r.newton_iterations for r in reports) <= 12


def test_the_report_counts_what_was_done(solve, machine):
    system = loaded(machine(spin=3.0))
    solver, iterations = solve(system, options()), []
    solver.snes.setMonitor(lambda snes, iteration, norm: iterations.append(iteration))
    report = solver.advance(system.initial_state(), DT, system.initial_state())
    assert report.newton_iterations == iterations[-1] >= 2
    assert report.krylov_iterations == report.newton_iterations  # one exact solve each
    assert 0.0 <= report.residual <= 1e-9


def test_two_solvers_of_one_prefix_do_not_disturb_each_other(solve, machine):
    system = loaded(machine(spin=3.0))
    alone = solve(system, options())
    expected, _ = run(alone, system)
    alone.destroy()
    one, other = (solve(system, options()) for _ in range(2))
    run(other, system, steps=1, dt=2 * DT)
    found, _ = run(one, system)
    assert np.array_equal(found.q, expected.q)


@all_solvers
def test_a_solver_frees_its_objects_once_when_told_or_when_forgotten(machine, name):
    system = loaded(machine())
    solver = EnergyMomentum(system, options=options(name))
    run(solver, system, steps=1)
    destroy = solver.destroy
    assert destroy.alive
    del solver
    gc.collect()
    assert not destroy.alive
    destroy()
    told = EnergyMomentum(system, options=options(name))
    told.destroy()
    told.destroy()

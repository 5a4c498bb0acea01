"""Claims about modes at rest: against closed forms and plain scripts, and what is refused."""

import logging
import runpy
import sys
from pathlib import Path

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest
from bricks import DENSITY, LAME, body_system, box, brick, clamped, facets_at, frequencies

from turbine_fenicsx import Gravity, PointSpring, Prismatic, Revolute, Spherical, StVenantKirchhoff
from turbine_fenicsx.analysis.bordered_solver import BorderedSolver
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import InputError, ModelError, StepFailure
from turbine_fenicsx.system.system import MultibodySystem

pytest.importorskip("slepc4py")

PLAIN = Path(__file__).parents[3] / "demos" / "verification" / "small_vibrations" / "plain.py"


@pytest.fixture(scope="module")
def plain_frequencies():
    """Frequencies by DOLFINx and SLEPc alone."""
    return runpy.run_path(str(PLAIN))["frequencies"]


def modal_matrix(system, found):
    """Products of all modes with the mass matrix."""
    linear = LinearSystem(system, found.state)
    y = [linear.vectors.vector(m.real) for m in found.modes]
    Y = []
    for b in y:
        product = b.duplicate()
        linear.mass.mult(b, product)
        Y.append([a.dot(product) for a in y])
    linear.destroy()
    return np.array(Y)


# --- flexible bodies, against a plain script


def test_frequencies_of_a_clamped_body_are_those_of_a_plain_script(comm, plain_frequencies):
    body = brick(comm)
    found = modes(MultibodySystem(comm, [body, clamped(body)]), count=8)
    root = facets_at(body.mesh, 0.0)
    expected = plain_frequencies(body.mesh, LAME, DENSITY, 8, 1.0, clamped=root)
    assert np.max(np.abs(frequencies(found) / expected - 1.0)) <= 1e-10
    assert not any(m.is_rigid or m.is_unstable or m.damping_ratio for m in found.modes)
    assert np.max(np.abs(modal_matrix(body_system(comm, body), found) - np.eye(8))) <= 1e-9
    found.destroy()


def test_a_free_body_has_six_motions_without_stiffness_and_then_those_of_a_plain_script(
    comm, plain_frequencies
):
    body = brick(comm)
    found = modes(MultibodySystem(comm, [body]), count=10)
    expected = plain_frequencies(body.mesh, LAME, DENSITY, 10, 1e5)[6:]
    assert [m.is_rigid for m in found.modes] == 6 * [True] + 4 * [False]
    assert np.all(frequencies(found)[:6] == 0.0)
    assert np.max(np.abs(frequencies(found)[6:] / expected - 1.0)) <= 1e-10


@pytest.mark.parametrize("shift", [1.0, 1e6, 3e6])
def test_the_shift_changes_nothing(comm, shift):
    body = brick(comm)
    usual, other = (modes(MultibodySystem(comm, [body]), count=8, shift=s) for s in (None, shift))
    assert frequencies(other)[6:] == pytest.approx(frequencies(usual)[6:], rel=1e-11)
    assert [m.is_rigid for m in other.modes] == 6 * [True] + 2 * [False]


def test_a_body_on_a_rigid_one_that_weighs_much_is_nearly_clamped(comm):
    body = brick(comm)
    anchor = RigidBody("anchor", 1e12, (1e12, 1e12, 1e12))
    held = [Coupling("root", body, facets_at(body.mesh, 0.0), anchor), anchor]
    found = modes(MultibodySystem(comm, [body, *held]), count=9)
    assert [m.is_rigid for m in found.modes] == 6 * [True] + 3 * [False]
    expected = modes(body_system(comm, body), count=3)
    assert frequencies(found)[6:] == pytest.approx(frequencies(expected), rel=1e-8)


def test_weight_changes_frequencies_as_it_does_in_a_difference_of_forces(comm):
    """A soft beam that hangs is stiffer than one that stands."""
    body = FlexibleBody(
        "beam", box(comm, [2.0, 0.1, 0.1], [8, 1, 1]), StVenantKirchhoff(0.0, 3e7), DENSITY, 2
    )
    found = [
        frequencies(
            modes(MultibodySystem(comm, [body, clamped(body), Gravity((g, 0, 0))]), count=1)
        )
        for g in (9.81, 0.0, -9.81)
    ]
    squares = np.square(found).ravel()
    assert squares[0] > 1.1 * squares[1] > 1.2 * squares[2]
    # of first order in the load: w^2 grows by as much as it shrinks, to some per cent
    assert squares[0] + squares[2] == pytest.approx(2.0 * squares[1], rel=0.02)


# --- rigid bodies, against closed forms

A = RigidBody("a", 2.0, (1, 2, 3), position=(0.0, -1.0, 0.0))
PIN = Revolute("pin", None, A, point=(0.0, 0.0, 0.0), axis=(0, 0, 1))
DOWN = Gravity((0.0, -9.81, 0.0))


def test_a_pendulum_swings_with_the_frequency_of_its_closed_form(comm):
    found = modes(MultibodySystem(comm, [A, PIN, DOWN]), count=1)
    expected = np.sqrt(2.0 * 9.81 / (3.0 + 2.0)) / (2.0 * np.pi)  # J3 = E1 + E2, m l^2 = 2
    assert frequencies(found) == pytest.approx(expected, rel=1e-12)
    motion = found.modes[0].real
    # of unit modal mass: 5 (kg m^2) times the square of the amplitude
    assert abs(motion.joint_coordinates[0]) == pytest.approx(5.0**-0.5, rel=1e-12)


def test_a_pendulum_that_stands_is_unstable_with_its_rate_of_growth(comm):
    body = RigidBody("a", 2.0, (1, 2, 3), position=(0.0, 1.0, 0.0))
    found = modes(
        MultibodySystem(
            comm, [body, Revolute("p", None, body, point=(0, 0, 0), axis=(0, 0, 1)), DOWN]
        ),
        count=1,
    )
    (mode,) = found.modes
    assert mode.is_unstable and mode.frequency == 0.0 and mode.damping_ratio == -1.0
    assert mode.eigenvalue.real == pytest.approx(np.sqrt(2.0 * 9.81 / 5.0), rel=1e-12)


def test_all_motions_of_a_chain_are_found_and_no_more(comm):
    """As many modes as degrees of freedom; each of five pendulums also turns about its axis."""
    parts, last = [DOWN], None
    for k in range(5):
        body = RigidBody(f"b{k}", 1.0 + 0.1 * k, (0.01, 0.02, 0.03), position=(0.0, -k - 0.5, 0.0))
        parts += [body, Spherical(f"s{k}", last, body, (0.0, -k, 0.0))]
        last = body
    system = MultibodySystem(comm, parts)
    found = modes(system, count=15)
    assert sum(m.is_rigid for m in found.modes) == 5
    assert np.max(np.abs(modal_matrix(system, found) - np.eye(15))) <= 1e-9
    with pytest.raises(ModelError, match="16 modes, but the system has 15 degrees of freedom"):
        modes(system, count=16)


def test_a_free_rigid_body_has_six_motions_without_stiffness(comm):
    found = modes(MultibodySystem(comm, [A]), count=6)
    assert [m.is_rigid for m in found.modes] == 6 * [True]
    assert not any(m.is_unstable or m.damping_ratio for m in found.modes)


def test_two_masses_on_springs_swing_in_and_against_phase(comm):
    """k/m and 3 k/m, for three equal springs between two walls."""
    a, b = (RigidBody(n, 2.0, (1, 1, 1), position=(x, 0, 0)) for n, x in (("a", 1.0), ("b", 2.0)))
    rails = [Prismatic(f"rail {x.name}", None, x, point=x.position, axis=(1, 0, 0)) for x in (a, b)]
    springs = [
        PointSpring(
            f"spring {x}",
            first,
            second,
            first_point=(x, 0, 0),
            second_point=(x + 1, 0, 0),
            stiffness=50.0,
            length=1.0,
        )
        for x, (first, second) in enumerate(((None, a), (a, b), (b, None)))
    ]
    found = modes(MultibodySystem(comm, [a, b, *rails, *springs]), count=2)
    assert frequencies(found) * 2.0 * np.pi == pytest.approx(np.sqrt([25.0, 75.0]), rel=1e-12)
    first, second = (m.real.q.reshape(-1, 4, 3)[:, 0, 0] for m in found.modes)
    assert first[0] == pytest.approx(first[1], rel=1e-9)
    assert second[0] == pytest.approx(-second[1], rel=1e-9)


# --- one choice among many


@pytest.mark.parallel
def test_equal_blades_move_each_alone(comm):
    blades = [brick(comm, name=name) for name in "abc"]
    found = modes(MultibodySystem(comm, [*blades, *(clamped(b) for b in blades)]), count=6)
    assert np.ptp(frequencies(found)[:3]) <= 1e-9 * frequencies(found)[0]
    for group in (found.modes[:3], found.modes[3:]):
        shares = np.array([[u.norm() for u in m.real.u] for m in group])
        assert np.allclose(shares / np.max(shares), np.eye(3), atol=1e-6)
    for mode in found.modes:
        largest = max(u.max()[1] for u in mode.real.u)
        smallest = min(u.min()[1] for u in mode.real.u)
        assert largest >= (1.0 - 1e-5) * -smallest > 0.0


@pytest.mark.parametrize("count", [1, 2, 10, 11])
def test_no_copy_of_a_repeated_frequency_is_missing(comm, count):
    """A Krylov space holds one; here each is there six times."""
    blades = [brick(comm, cells=(2, 1, 1), name=name) for name in "abcdef"]
    system = MultibodySystem(comm, [*blades, *(clamped(b) for b in blades)])
    one = frequencies(modes(body_system(comm, blades[0]), count=2))
    assert frequencies(modes(system, count=count)) == pytest.approx(np.repeat(one, 6)[:count])


@pytest.mark.parallel
def test_any_number_of_ranks_finds_the_same_modes(comm, machine):
    """Six bodies' worth of coordinates and equal bending both ways; on ranks alone and together."""
    together, alone = (modes(machine(comm=c).system(), count=6) for c in (comm, MPI.COMM_SELF))
    assert frequencies(together) == pytest.approx(frequencies(alone), rel=1e-10)
    for a, b in zip(together.modes, alone.modes, strict=True):
        for mine, other in (
            (a.real.q, b.real.q),
            (a.real.joint_coordinates, b.real.joint_coordinates),
        ):
            assert np.max(np.abs(mine - other)) <= 1e-8
        assert a.real.u[0].max()[1] == pytest.approx(b.real.u[0].max()[1], rel=1e-8)


@pytest.mark.parametrize("count", [1, 13])
def test_motions_that_grow_but_are_not_among_the_modes_are_told(comm, caplog, count):
    """A short rod that stands grows faster than long ones swing."""
    parts = [DOWN]
    for y in (0.1, *np.linspace(-4.0, -15.0, 12)):
        body = RigidBody(f"at {y}", 1.0, (1e-3, 1e-3, 1e-3), position=(0.0, y, 0.0))
        parts += [body, Revolute(f"pin of {y}", None, body, point=(0, 0, 0), axis=(0, 0, 1))]
    with caplog.at_level(logging.WARNING):
        found = modes(MultibodySystem(comm, parts), count=count)
    told = [r.message for r in caplog.records if "1 motions grow, and only 0 of them" in r.message]
    assert len(told) == (count == 1 and comm.rank == 0)
    assert sum(m.is_unstable for m in found.modes) == (count == 13)


@pytest.mark.parallel
@pytest.mark.parametrize("strain, growing", [(3e-4, 0), (3e-3, 2)])
def test_directions_in_which_a_beam_buckles_are_counted(comm, strain, growing):
    """Euler's column of a clamped and a free end: at strains of pi^2/4 (r/l)^2, 5.1e-4 and 7.4e-4.

    Only MUMPS factorises what has buckled.
    """
    cells = box(comm, [2.0, 0.1, 0.12], [8, 1, 1])
    body = FlexibleBody("beam", cells, StVenantKirchhoff(0.0, 1e7), DENSITY, 2)
    system = body_system(comm, body)
    state = system.initial_state()
    state.u[0].array[:] = (system.flexible_models[0].positions * [-strain, 0.0, 0.0]).ravel()
    linear = LinearSystem(system, state)
    solver = linear.solver(linear.stiffness)
    solver.factorise()
    assert solver.count_negative() == growing
    solver.destroy()
    linear.destroy()


# --- what is refused


@pytest.mark.parallel
def test_a_state_that_is_not_in_equilibrium_is_refused_with_its_residual(comm):
    body = RigidBody("a", 2.0, (1, 2, 3), position=(1.0, 0.0, 0.0))
    system = MultibodySystem(
        comm, [body, Revolute("p", None, body, point=(0, 0, 0), axis=(0, 0, 1)), DOWN]
    )
    with pytest.raises(ModelError, match=r"not in equilibrium: forces of 2\.0e\+01 N .* 1e-06"):
        modes(system, system.initial_state(), count=1)
    other = MultibodySystem(comm, [body])
    with pytest.raises(ModelError, match="another system"):
        modes(other, system.initial_state(), count=1)
    with pytest.raises(TypeError, match="got a str"):
        modes(system, "state")


def test_a_given_equilibrium_is_taken_as_it_is(comm):
    body = brick(comm, cells=(2, 1, 1))
    system = MultibodySystem(comm, [body, clamped(body), Gravity((0.0, -9.81, 0.0))])
    state = equilibrium(system)
    found = modes(system, state, count=2)
    assert found.state is state
    assert frequencies(found) == pytest.approx(frequencies(modes(system, count=2)), rel=1e-12)


@pytest.mark.parametrize("count", [0, -3, 2.5, "two"])
def test_numbers_of_modes_that_are_none_are_refused(comm, count):
    with pytest.raises(ModelError, match=f"positive whole number, got {count!r}"):
        modes(MultibodySystem(comm, [A]), count=count)


@pytest.mark.parametrize("name", ["shift", "tolerance"])
def test_shifts_and_tolerances_are_positive(comm, name):
    with pytest.raises(ModelError, match=f"{name} must be positive, got -1"):
        modes(MultibodySystem(comm, [A]), count=1, **{name: -1.0})


def test_without_slepc_one_sentence_says_what_brings_it(comm, monkeypatch):
    monkeypatch.setitem(sys.modules, "slepc4py", None)
    with pytest.raises(InputError, match="apt install python3-slepc4py-real"):
        modes(MultibodySystem(comm, [A]), count=1)


def test_options_of_petsc_reach_the_iteration_and_its_failure_is_told(comm):
    body = brick(comm)
    options = PETSc.Options()
    options["modes_eps_max_it"] = 1
    options["modes_eps_ncv"] = 9
    try:
        with pytest.raises(StepFailure, match=r"of 8 modes were found"):
            modes(body_system(comm, body), count=8)
    finally:
        del options["modes_eps_max_it"], options["modes_eps_ncv"]


def test_a_mode_that_does_not_fulfil_the_equations_is_not_returned(comm, monkeypatch):
    solve = BorderedSolver.solve

    def wrong(self, b, y):
        solve(self, b, y)
        y.array[:] += 1e-3 * y.array_r[::-1]

    monkeypatch.setattr(BorderedSolver, "solve", wrong)
    with pytest.raises(StepFailure, match="do not fulfil their equations"):
        modes(body_system(comm, brick(comm)), count=2)

"""Claims about viscosity, numerical dissipation and dampers: what they take out, and what not."""

from mpi4py import MPI

import numpy as np
import pytest
import scipy.linalg

from turbine_fenicsx import (
    Gravity,
    JointDamper,
    KelvinVoigt,
    PointDamper,
    StepTimes,
    StVenantKirchhoff,
)
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

LAMBDA, MU = 1200.0, 800.0
ELASTIC = StVenantKirchhoff(LAMBDA, MU)
DT = 0.02


def viscous(time):
    """All modes are damped by the ratio time w/2."""
    return KelvinVoigt(ELASTIC, time * MU, time * (LAMBDA + 2 * MU / 3))


def beam(m, material):
    return FlexibleBody("beam", m.beam.mesh, material, m.beam.density)


def advance(system, state, steps, dt=DT, names=None, **scheme):
    """Yields report, balance and state of each step; checks the names of what dissipates."""
    solver = EnergyMomentum(system, **scheme)
    assert names is None or solver.dissipation_names == names
    for _ in range(steps):
        other = state.copy()
        report = solver.advance(state, dt, other)
        yield report, system.balance(other), other
        state = other
    solver.destroy()


def tumbling(comm, m, material=ELASTIC):
    """A free beam that turns and is stretched at the start."""
    system = MultibodySystem(comm, [beam(m, material)])
    state = system.initial_state()
    X = system.flexible_models[0].positions
    state.u[0].array[:] = (X @ np.diag([0.1, -0.05, 0.05])).ravel()
    spin = np.cross([0.5, 1.0, 2.0], X) + 0.4 * np.sin(X[:, [1, 2, 0]])
    state.v[0].array[:] = spin.ravel()
    return system, state


CASES = {
    "viscosity": (viscous(0.01), 0.0, ("viscosity of beam",)),
    "numerical": (ELASTIC, 0.5, ("numerical dissipation of beam",)),
    "both": (viscous(0.01), 0.5, ("viscosity of beam", "numerical dissipation of beam")),
}


@pytest.mark.parallel
@pytest.mark.parametrize(("material", "chi", "names"), CASES.values(), ids=CASES)
def test_energy_falls_steadily_by_what_is_dissipated_and_momenta_stay(
    comm, machine, material, chi, names
):
    system, state = tumbling(comm, machine(), material)
    last = first = system.balance(state)
    for report, b, _ in advance(system, state, 40, names=names, numerical_dissipation=chi):
        assert len(report.dissipated) == len(names) and min(report.dissipated) > 0.0
        assert b.total < last.total
        # Newton's method stops at 1e-12 of the forces
        assert last.total - b.total == pytest.approx(sum(report.dissipated), abs=3e-12 * last.total)
        assert np.allclose(b.linear, first.linear, rtol=0, atol=1e-12)
        assert np.allclose(b.angular, first.angular, rtol=0, atol=1e-11)
        last = b
    assert last.total < 0.9 * first.total  # a good part of it


def test_a_rigid_motion_is_not_damped(comm, machine):
    m = machine()
    body = beam(m, viscous(10.0))
    block = FlexibleModel(body)
    step = FlexibleStep(block, numerical_dissipation=100.0)
    X = block.positions
    ends = []
    for axis, angle in (((1, 0, 0), 0.3), ((1, 2, 0.5), 1.5)):
        u = block.new_vector()
        u.array[:] = (X @ (rotation_about(axis, angle) - np.eye(3)).T + 2.0 * angle).ravel()
        ends.append(u)
    step.start_step(ends[0], 0 * ends[0], StepTimes.from_start(0.0, DT), np.zeros(3))
    taken = comm.allreduce(step.midpoint.works(ends[1] - ends[0])[1])
    assert taken.size == 2
    assert np.max(np.abs(taken)) <= 1e-20 * LAMBDA * 10.0 / DT


def modes(block):
    """Squares of angular frequencies and modes of a body that is held at its root, and the rest."""
    free = np.repeat(block.positions[:, 0] > 0.51, 3)
    M = block.mass_matrix()[:, :][np.ix_(free, free)]
    stiffness = block.new_stiffness()
    block.assemble_stiffness(block.new_vector(), 0.0, stiffness)
    K = stiffness[:, :][np.ix_(free, free)]
    squares, vectors = scipy.linalg.eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
    return np.sqrt(squares), vectors, free


def decay(machine, mode, steps, dt, make_options):
    """Frequency times step, and mean logarithmic decrement of the energy per step of a mode."""
    comm = MPI.COMM_SELF
    m = machine(comm=comm)
    frequencies, vectors, free = modes(FlexibleModel(m.beam))
    w = frequencies[mode]
    options = make_options(w)
    body = beam(m, options.pop("material", ELASTIC))
    foot = Coupling("foot", body, m.facets(0.5), None)
    system = MultibodySystem(comm, [body, foot])
    state = system.initial_state()
    velocity = np.zeros(free.size)
    velocity[free] = 1e-4 * vectors[:, mode]  # so small that it is linear
    state.v[0].array[:] = velocity
    energies = [system.balance(state).total]
    energies += [b.total for _, b, _ in advance(system, state, steps, dt / w, **options)]
    return dt, -np.log(energies[-1] / energies[0]) / steps


PERIOD = 2 * np.pi / 50  # fifty steps


@pytest.mark.parametrize("mode", [0, 3, 8])
def test_each_mode_loses_chi_times_half_the_square_of_w_dt_of_its_energy_per_step(machine, mode):
    x, found = decay(machine, mode, 100, PERIOD, lambda w: {"numerical_dissipation": 0.4})
    assert found == pytest.approx(0.5 * 0.4 * x**2, rel=1e-2)


@pytest.mark.parametrize("x", [1.0, 2.0, 3.0])
def test_long_steps_lose_what_the_spectral_radius_says(machine, x):
    """Its square is the determinant of the step; at w dt = 4/chi it is least."""
    chi = 0.8
    _, found = decay(machine, 0, 15, x, lambda w: {"numerical_dissipation": chi})
    square = (4 + x**2 * (1 - chi)) / (4 + x**2 * (1 + chi))
    assert found == pytest.approx(-np.log(square), rel=0.1)


@pytest.mark.parametrize("mode", [0, 3, 8])
def test_each_mode_is_damped_by_half_of_viscous_time_times_frequency(machine, mode):
    x, found = decay(machine, mode, 100, PERIOD, lambda w: {"material": viscous(0.03 / w)})
    ratio = 0.5 * 0.03
    assert found == pytest.approx(2 * ratio * x, rel=1e-2)


def test_numerical_dissipation_is_of_first_order_and_viscosity_does_not_depend_on_the_step(
    comm, machine
):
    lost = {}
    for dt in (0.001, 0.0005):
        for name, material, chi in (
            ("numerical", ELASTIC, 0.01),
            ("viscosity", viscous(1e-4), 0.0),
        ):
            system, state = tumbling(comm, machine(), material)
            run = advance(system, state, round(0.02 / dt), dt, numerical_dissipation=chi)
            lost[name, dt] = sum(sum(report.dissipated) for report, *_ in run)
    assert lost["numerical", 0.001] / lost["numerical", 0.0005] == pytest.approx(2.0, rel=0.03)
    assert lost["viscosity", 0.001] / lost["viscosity", 0.0005] == pytest.approx(1.0, rel=0.01)


def test_there_is_none_by_default_bit_for_bit(comm, machine):
    found = []
    for options in ({}, {"numerical_dissipation": 0.0}):
        system, state = tumbling(comm, machine())
        *_, (report, balance, last) = advance(system, state, 10, names=(), **options)
        assert report.dissipated == ()
        found.append((balance.total, last.u[0].array.copy(), last.v[0].array.copy()))
    assert found[0][0] == found[1][0]
    assert all(np.array_equal(a, b) for a, b in zip(found[0][1:], found[1][1:], strict=True))


def test_a_viscosity_of_zero_takes_nothing_out(comm, machine):
    found = []
    for material in (ELASTIC, viscous(0.0)):
        system, state = tumbling(comm, machine(), material)
        *_, (report, balance, last) = advance(system, state, 10)
        found.append((balance.total, last.u[0].norm()))
        assert sum(report.dissipated) == 0.0
    assert found[0] == pytest.approx(found[1], rel=1e-11)


@pytest.mark.parametrize("chi", [-1e-3, np.nan, np.inf])
def test_numerical_dissipation_must_not_be_negative(comm, machine, chi):
    with pytest.raises(ValueError, match=f"numerical_dissipation must be >= 0, got {chi:g}"):
        EnergyMomentum(machine().system(), numerical_dissipation=chi)


@pytest.mark.parallel
def test_dampers_dissipate_by_name_and_the_balance_closes(comm, machine):
    m = machine(spin=3.0)
    hinge = JointDamper("bearing", "rotor", 0.3)
    strut = PointDamper(
        "strut",
        m.nacelle,
        None,
        first_point=(0.5, 0.5, 0.0),
        second_point=(2.0, 1.0, 1.0),
        damping=0.4,
    )
    system = MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, hinge, strut, Gravity()])
    state = system.initial_state()
    last, taken = system.balance(state).total, np.zeros(2)
    for report, b, _ in advance(system, state, 40, names=("bearing", "strut")):
        assert min(report.dissipated) >= 0.0
        assert last - b.total == pytest.approx(sum(report.dissipated), abs=1e-12)
        taken, last = taken + report.dissipated, b.total
    assert taken[0] > 0.1

"""Claims about static equilibrium of flexible bodies."""

from itertools import pairwise

import numpy as np
import pytest
from dolfinx import mesh
from equilibria import HINGE, A, residual_in_rest

from turbine_fenicsx import (
    FollowerForce,
    Gravity,
    JointSpring,
    KelvinVoigt,
    NodeForce,
    PointSpring,
    Pressure,
    Ramp,
    StepTimes,
    StVenantKirchhoff,
    SurfaceTraction,
)
from turbine_fenicsx.analysis import statics
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum
from turbine_fenicsx.time_stepping.flexible_step import FlexibleStep

pytestmark = pytest.mark.parallel

YOUNG = 1e4


def clamped(comm, degree=2, n=(8, 1, 1), size=(8.0, 0.5, 0.5), material=None, loads=()):
    """A beam along e1 held at its root, with what makes loads from it."""
    box = mesh.create_box(comm, [(0, 0, 0), size], n, mesh.CellType.hexahedron)
    law = material or StVenantKirchhoff(0.0, 0.5 * YOUNG)  # no Poisson effect
    body = FlexibleBody("beam", box, law, 1.0, degree)

    def facets(on):
        return mesh.locate_entities_boundary(box, 2, on)

    root = facets(lambda x: np.isclose(x[0], 0.0))
    parts = [body, Coupling("root", body, root, None)]
    return MultibodySystem(comm, [*parts, *(x for make in loads for x in make(body, facets))])


def tip_forces(force):
    """Forces on the four corners of the tip."""

    def make(body, facets):
        return [
            NodeForce(
                f"f{y}{z}",
                body,
                point=(8.0, y, z),
                force=np.asarray(force) / 4,
                function=lambda t: t,
            )
            for y in (0.0, 0.5)
            for z in (0.0, 0.5)
        ]

    return make


def tip(system, state):
    """Mean displacement of the corners of the tip. Collective."""
    X = system.flexible_models[0].positions
    at = np.isclose(X[:, 0], 8.0) & (np.abs(X[:, 1:] - 0.25).min(axis=1) > 0.2)
    u = state.u[0].array_r.reshape(-1, 3)[at]
    return system.comm.allreduce(u.sum(axis=0)) / system.comm.allreduce(len(u))


INERTIA = 0.5**4 / 12


def test_small_loads_bend_a_beam_as_the_linear_theory_says(comm):
    system = clamped(comm, loads=[tip_forces((0.0, 1e-4, 0.0))])
    state = equilibrium(system, [1.0])
    shear = 8.0 / (5 / 6 * 0.5 * YOUNG * 0.25)
    expected = 1e-4 * (8.0**3 / (3 * YOUNG * INERTIA) + shear)
    u = tip(system, state)
    # cells of 1 m x 0.5 m, and corners that are pulled: 1 per cent
    assert u[1] == pytest.approx(expected, rel=0.01)
    twice = tip(system, equilibrium(system, [2.0]))
    assert twice[1] == pytest.approx(2 * u[1], rel=1e-5)


def test_equilibrium_of_large_loads_is_a_stationary_point_of_the_potential(comm):
    """Energy minus work does not change to first order with any admissible displacement."""
    force = np.array([0.0, 1.5, 0.3])
    system = clamped(comm, loads=[tip_forces(force)])
    state = equilibrium(system, [0.25, 0.5, 0.75, 1.0])
    block = system.flexible_models[0]
    assert np.linalg.norm(tip(system, state)) > 2.0
    rng = np.random.default_rng(3)
    for _ in range(3):
        K, phase = rng.uniform(0.1, 1, (3, 3)), rng.uniform(0, 7, 3)
        w = block.new_vector()
        X = block.positions
        w.array[:] = (X[:, :1] * np.sin(X @ K + phase)).ravel()
        ends = []
        for h in (1e-6, -1e-6):
            moved = state.copy()
            moved.u[0].axpy(h, w)
            ends.append(system.balance(moved).strain - force @ tip(system, moved))
        slope = (ends[0] - ends[1]) / 2e-6
        moved.u[0].axpy(1e-6 + 1.0, w)
        work = abs(force @ (tip(system, moved) - tip(system, state)))
        assert work > 0.1 and abs(slope) <= 1e-4 * work


def increments(system, caught, **options):
    """Sizes of Newton's increments of one load step, relative to the largest displacement."""
    seen = []

    def record(*args):
        size, extent = caught(*args)
        seen.append(size / extent)
        return size, extent

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statics, "_move", record)
        equilibrium(system, [1.0], **options)
    return seen


@pytest.mark.parametrize("follows", [False, True])
def test_the_tangent_is_factorised_as_symmetric_unless_a_load_follows_a_surface(
    comm, monkeypatch, follows
):
    def press(body, facets):
        return [Pressure("p", body, facets(lambda x: np.isclose(x[0], 8.0)), 1e-3)]

    seen = []
    monkeypatch.setattr(
        statics, "Elimination", lambda *args: seen.append(args[2]) or Elimination(*args)
    )
    system = clamped(comm, n=(2, 1, 1), loads=[press] if follows else [])
    equilibrium(system).destroy()
    assert seen == [not follows]


def test_newton_converges_quadratically_also_with_loads_that_follow(comm):
    """Each of the last increments is less than a multiple of the square of the one before."""
    bent = clamped(comm, loads=[tip_forces((0.0, 0.8, 0.2))])
    hinged = MultibodySystem(
        comm,
        [
            A,
            HINGE,
            JointSpring("s", "hinge", 100.0),
            Gravity(),
            FollowerForce("f", A, point=(3, 5, 2), force=(0, 30, 0)),
            PointSpring(
                "p",
                A,
                None,
                first_point=(3, 5, 2),
                second_point=(3, 8, 3),
                stiffness=20.0,
                length=1.0,
            ),
        ],
    )
    for system in (bent, hinged, pressed(comm)):
        sizes = increments(system, statics._move)
        last = [(x, y) for x, y in pairwise(sizes) if x < 0.01]
        assert last and len(sizes) <= 12
        for before, after in last:
            assert after < 100 * before**2 + 1e-13


def test_a_damped_motion_of_a_flexible_body_comes_to_rest_in_the_equilibrium(comm):
    law = StVenantKirchhoff(1200.0, 800.0)
    viscous = KelvinVoigt(law, 0.3 * 800.0, 0.3 * 1700.0)
    sizes = {"degree": 1, "n": (3, 1, 1), "size": (8.0, 2.0, 2.0)}

    def gravity(body, facets):
        return [Gravity((0.0, -3.0, 1.0))]

    system = clamped(comm, **sizes, material=law, loads=[gravity])
    state = equilibrium(system)
    damped = clamped(comm, **sizes, material=viscous, loads=[gravity])
    solver = EnergyMomentum(damped, numerical_dissipation=1.0)
    at = damped.initial_state()
    other = at.copy()
    for dt in [1.0] * 60 + [0.02] * 60:  # for low and high frequencies
        solver.advance(at, dt, other)
        at, other = other, at
    solver.destroy()
    u = state.u[0]
    assert u.norm() > 3.0
    assert (at.u[0] - u).norm() <= 1e-5 * u.norm()
    assert (at.coupling[0] - state.coupling[0]).norm() <= 1e-3 * state.coupling[0].norm()


def pressed(comm, p=0.4):
    """A stout beam under pressure on its tip and its upper side."""

    def make(body, facets):
        end, top = (facets(lambda x, k=k, s=s: np.isclose(x[k], s)) for k, s in ((0, 8), (1, 2)))
        return [
            SurfaceTraction("t", body, end, (0, 0, 0.1), Ramp(1.0, 1.0)),
            Pressure("p", body, np.append(end, top), p, Ramp(1.0, 1.0)),
        ]

    return clamped(comm, 1, (3, 1, 1), (8.0, 2.0, 2.0), StVenantKirchhoff(1200.0, 800.0), [make])


def test_a_follower_pressure_bends_and_the_root_carries_its_resultant(comm):
    """The resultant on the present area, which is another than that at the start."""
    system = pressed(comm)
    state = equilibrium(system, [0.5, 1.0])
    block = system.flexible_models[0]
    step, rest = FlexibleStep(block), block.new_vector()
    step.start_step(state.u[0], rest, StepTimes(1.0, 1.0, 1.5), np.zeros(3))
    loads = []
    for axis in np.eye(3):  # work of a unit displacement
        du = block.new_vector()
        du.array[:] = np.tile(axis, block.n_owned)
        loads.append(comm.allreduce(step.midpoint.works(du)[0]).sum())
    # the multipliers are what the beam exerts on the ground, with the sign of C = -1
    reaction = comm.allreduce(state.coupling[0].array_r.reshape(-1, 3).sum(axis=0))
    assert np.allclose(reaction, np.negative(loads), rtol=0, atol=1e-10)
    assert abs(loads[0] + 0.4 * 4.0) > 0.01  # the tip has turned, and the top with it
    assert residual_in_rest(system, state)[0] <= 1e-8


@pytest.mark.parametrize("load", [1e-9, 1e-3])
def test_tiny_displacements_end_at_round_off(comm, load):
    system = clamped(comm, loads=[tip_forces((0.0, load, 0.0))])
    first, again = (tip(system, equilibrium(system, [1.0]))[1] for _ in range(2))
    assert first == again > 0.0

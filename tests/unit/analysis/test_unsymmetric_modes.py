"""Claims about modes where stiffness is unsymmetric: pressures and follower forces."""

import numpy as np
import pytest
from bricks import brick, clamped, facets_at, frequencies
from dolfinx import mesh

from turbine_fenicsx import FollowerForce, JointSpring, Pressure, Revolute
from turbine_fenicsx.analysis import squared_frequencies
from turbine_fenicsx.analysis.linear_system import LinearSystem
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

pytest.importorskip("slepc4py")


def ziegler(comm, load):
    """Two equal massless rods with a mass at each end, springs, and a force along the second."""
    rods = [
        RigidBody(n, 1.0, (1e-9, 1e-9, 1e-9), position=(x, 0.0, 0.0))
        for n, x in (("a", 1.0), ("b", 2.0))
    ]
    pins = [
        Revolute("pin a", None, rods[0], point=(0, 0, 0), axis=(0, 0, 1)),
        Revolute("pin b", rods[0], rods[1], point=(1, 0, 0), axis=(0, 0, 1)),
    ]
    springs = [JointSpring(f"s{k}", f"pin {k}", 10.0) for k in "ab"]
    push = FollowerForce("push", rods[1], point=(2.0, 0.0, 0.0), force=(-load, 0.0, 0.0))
    return MultibodySystem(comm, [*rods, *pins, *springs, push])


def ziegler_squares(load):
    """w^2 of Ziegler's pendulum with the angles of both rods from the axis."""
    M = np.array([[2.0, 1.0], [1.0, 1.0]])
    K = np.array([[20.0 - load, load - 10.0], [-10.0, 10.0]])
    return np.linalg.eigvals(np.linalg.solve(M, K))


def test_a_follower_force_below_its_critical_value_changes_real_frequencies(comm):
    found = modes(ziegler(comm, 8.0), count=2)
    expected = np.sqrt(np.sort(ziegler_squares(8.0).real)) / (2.0 * np.pi)
    assert frequencies(found) == pytest.approx(expected, rel=1e-7)  # the rods' inertia
    assert not any(m.is_unstable or m.imaginary for m in found.modes)


def test_a_follower_force_beyond_its_critical_value_makes_vibrations_grow(comm):
    found = modes(ziegler(comm, 25.0), count=2)
    squares = ziegler_squares(25.0)
    roots = np.sqrt(-squares)
    roots = np.where(roots.imag > 0.0, roots, -roots)
    expected = roots[np.argsort(-roots.real)]
    assert [m.eigenvalue for m in found.modes] == pytest.approx(expected, rel=1e-7)
    assert [m.is_unstable for m in found.modes] == [True, False]
    assert all(m.imaginary is not None for m in found.modes)


def test_pressure_on_a_closed_surface_has_an_energy_and_on_a_part_of_it_none(comm):
    body = brick(comm)
    everywhere = mesh.locate_entities_boundary(body.mesh, 2, lambda x: np.full(x.shape[1], True))
    for facets, symmetric in ((everywhere, True), (facets_at(body.mesh, 1.0), False)):
        system = MultibodySystem(comm, [body, clamped(body), Pressure("p", body, facets, 1e4)])
        linear = LinearSystem(system, system.initial_state())
        problem = squared_frequencies.SquaredFrequencies(None, linear, None)
        assert problem.symmetric == symmetric
        problem.destroy()
        linear.destroy()


@pytest.mark.parametrize("count", [6, 11])
def test_a_repeated_frequency_of_an_unsymmetric_problem_is_found_or_told(comm, count):
    blades = [brick(comm, cells=(2, 1, 1), name=name) for name in "abcdef"]

    def loaded(b):
        return [clamped(b), Pressure(f"p {b.name}", b, facets_at(b.mesh, 1.0), 1e5)]

    one = frequencies(modes(MultibodySystem(comm, [blades[0], *loaded(blades[0])]), count=2))
    parts = [p for b in blades for p in (b, *loaded(b))]
    try:
        found = frequencies(modes(MultibodySystem(comm, parts), count=count))
    except StepFailure as failure:
        assert "a mode of a repeated frequency is missing" in str(failure)
    else:
        assert found == pytest.approx(np.repeat(one, 6)[:count], rel=1e-7)

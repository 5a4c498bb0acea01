"""Claims about modes of damped systems."""

import sys
from contextlib import contextmanager

from petsc4py import PETSc

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx import (
    Gravity,
    JointDamper,
    JointSpring,
    KelvinVoigt,
    PointDamper,
    PointSpring,
    Prismatic,
    Revolute,
    StVenantKirchhoff,
)
from turbine_fenicsx.analysis import quadratic_problem
from turbine_fenicsx.analysis.damped_modes import damped_modes
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.system.system import MultibodySystem

LAMBDA, MU, DENSITY, TAU = 6e4, 4e4, 3.0, 2e-3
BODY = RigidBody("a", 2.0, (1.0, 2.0, 3.0))
HINGE = Revolute("hinge", None, BODY, point=(0, 0, 0), axis=(0, 0, 1))


def eigenvalues(found):
    return np.array([mode.eigenvalue for mode in found.modes])


def free(found):
    found.destroy()
    found.state.destroy()


def box(comm, *, viscous=True, held=True, degree=1):
    cells = mesh.create_box(comm, [[0, 0, 0], [1.0, 0.3, 0.2]], [4, 2, 1])
    law = StVenantKirchhoff(LAMBDA, MU)
    if viscous:
        law = KelvinVoigt(law, TAU * MU, TAU * (LAMBDA + 2.0 * MU / 3.0))
    body = FlexibleBody("b", cells, law, DENSITY, degree)
    root = mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[0], 0.0))
    return MultibodySystem(comm, [body, *([Coupling("root", body, root, None)] if held else [])])


# --- one degree of freedom: J = 3 kg m^2


@pytest.mark.parametrize("damping", [0.0, 0.5, 20.0, 34.0])
def test_a_damped_pendulum_has_the_roots_of_its_quadratic(comm, damping):
    spring, damper = JointSpring("s", "hinge", 100.0), JointDamper("d", "hinge", damping)
    found = damped_modes(MultibodySystem(comm, [BODY, HINGE, spring, damper]), count=1)
    expected = -damping / 6.0 + 1j * np.sqrt(100.0 / 3.0 - (damping / 6.0) ** 2)
    (mode,) = found.modes
    assert mode.eigenvalue == pytest.approx(expected, rel=1e-10)
    ratio = damping / (2.0 * np.sqrt(300.0))
    assert mode.damping_ratio == pytest.approx(ratio, rel=1e-10, abs=1e-10)
    assert mode.frequency == pytest.approx(expected.imag / (2.0 * np.pi), rel=1e-10)
    free(found)


def test_a_motion_damped_beyond_critical_does_not_vibrate(comm):
    parts = [BODY, HINGE, JointSpring("s", "hinge", 100.0), JointDamper("d", "hinge", 60.0)]
    found = damped_modes(MultibodySystem(comm, parts), count=1)
    slower = np.max(np.roots([3.0, 60.0, 100.0]))
    assert eigenvalues(found) == pytest.approx([slower], rel=1e-10)
    assert found.modes[0].frequency == 0.0 and found.modes[0].damping_ratio == 1.0
    assert found.modes[0].imaginary is None
    free(found)


def test_a_free_body_with_a_damper_has_a_rigid_mode(comm):
    found = damped_modes(
        MultibodySystem(comm, [BODY, HINGE, JointDamper("d", "hinge", 6.0)]), count=1
    )
    (mode,) = found.modes
    assert mode.is_rigid and mode.eigenvalue == 0.0 and not mode.is_unstable
    free(found)


def test_two_masses_with_a_damper_between_points(comm):
    """M s^2 + D s + K as a linear eigenvalue problem of four."""
    b = RigidBody("b", 5.0, (1.0, 1.0, 1.0), position=(2.0, 0.0, 0.0))
    parts = [BODY, b]
    parts += [
        Prismatic(n, None, x, point=(0, 0, 0), axis=(1, 0, 0)) for n, x in (("x", BODY), ("y", b))
    ]
    ends = {"first_point": (0.0, 0.0, 0.0), "second_point": (2.0, 0.0, 0.0)}
    parts += [PointSpring("k", BODY, b, **ends, stiffness=70.0)]
    parts += [PointDamper("d", BODY, b, **ends, damping=3.0)]
    parts += [JointSpring("k1", "x", 40.0), JointDamper("d1", "x", 0.4)]
    found = damped_modes(MultibodySystem(comm, parts), count=2)
    M, K = np.diag([2.0, 5.0]), np.array([[110.0, -70.0], [-70.0, 70.0]])
    D = np.array([[3.4, -3.0], [-3.0, 3.0]])
    inverse = np.linalg.inv(M)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ D]])
    exact = np.linalg.eigvals(A)
    exact = sorted(exact[exact.imag > 0.0], key=lambda s: s.imag)
    assert eigenvalues(found) == pytest.approx(exact, rel=1e-9)
    for mode in found.modes:
        mass = sum(p.q @ (np.repeat([2.0, 1, 2, 3, 5, 1, 1, 1], 3) * p.q) for p in _parts(mode))
        assert mass == pytest.approx(1.0, rel=1e-10)
        z = (mode.real.q + 1j * mode.imaginary.q)[[0, 12]]
        residual = (mode.eigenvalue**2 * M + mode.eigenvalue * D + K) @ z
        assert np.linalg.norm(residual) <= 1e-8 * np.linalg.norm(K @ z)
        assert mode.imaginary.joint_coordinates == pytest.approx(z.imag, abs=1e-9)
    free(found)


def _parts(mode):
    return [mode.real, mode.imaginary]


# --- flexible bodies


@pytest.mark.parametrize("degree", [1, 2])
def test_viscosity_proportional_to_stiffness_damps_by_half_tau_times_frequency(comm, degree):
    damped, plain = (
        damped_modes(box(comm, degree=degree), count=6),
        modes(box(comm, viscous=False, degree=degree), count=6),
    )
    w = 2.0 * np.pi * np.array([mode.frequency for mode in plain.modes])
    assert np.abs(eigenvalues(damped)) == pytest.approx(w, rel=1e-8)
    ratios = [mode.damping_ratio for mode in damped.modes]
    assert ratios == pytest.approx(0.5 * TAU * w, rel=1e-7)
    free(damped)
    free(plain)


def test_without_damping_modes_are_those_of_the_symmetric_problem(comm):
    found, plain = (
        damped_modes(box(comm, viscous=False), count=5),
        modes(box(comm, viscous=False), count=5),
    )
    w = [2.0 * np.pi * mode.frequency for mode in plain.modes]
    assert eigenvalues(found).imag == pytest.approx(w, rel=1e-8)
    assert np.max(np.abs(eigenvalues(found).real)) <= 1e-8 * min(w)
    free(found)
    free(plain)


@pytest.mark.parallel
def test_a_free_viscous_body_has_six_rigid_modes_and_damped_ones(comm):
    found = damped_modes(box(comm, held=False), count=8)
    assert [mode.is_rigid for mode in found.modes] == 6 * [True] + 2 * [False]
    assert all(mode.damping_ratio > 0.0 for mode in found.modes[6:])
    total = np.zeros((6, 6))
    model = box(comm, held=False).flexible_models[0]
    image = model.new_vector()
    for i, a in enumerate(found.modes[:6]):
        for k, b in enumerate(found.modes[:6]):
            model.momentum(b.real.u[0], image)
            total[i, k] = a.real.u[0].dot(image)
    assert total == pytest.approx(np.eye(6), abs=1e-8)
    free(found)


@pytest.mark.parametrize("failures", [1, 3])
def test_another_start_helps_where_lapack_fails_on_the_projected_problem(
    comm, monkeypatch, failures
):
    system = box(comm, degree=2)
    expected = eigenvalues(damped_modes(system, count=3))
    toar, left = quadratic_problem._toar, [failures]

    class Failing:
        """SLEPc's solver, whose first runs fail as PETSc reports an error of LAPACK."""

        def __init__(self, iteration):
            self._iteration = iteration

        def __getattr__(self, name):
            return getattr(self._iteration, name)

        def solve(self):
            if left[0]:
                left[0] -= 1
                raise PETSc.Error(quadratic_problem.ERROR_OF_LIBRARY)
            self._iteration.solve()

    @contextmanager
    def failing(*arguments):
        with toar(*arguments) as iteration:
            yield Failing(iteration)

    monkeypatch.setattr(quadratic_problem, "_toar", failing)
    assert eigenvalues(damped_modes(system, count=3)) == pytest.approx(expected, rel=1e-9)
    assert not left[0]


@pytest.mark.parallel
def test_two_ranks_find_what_one_finds(comm):
    found = damped_modes(box(comm), count=4)
    expected = np.array(ONE_RANK)  # of a run on one rank
    assert np.max(np.abs(eigenvalues(found) - expected) / np.abs(expected)) <= 1e-8
    free(found)


ONE_RANK = [
    -5.596066019016122 + 74.59725238993414j,
    -7.537581485959404 + 86.49142357079573j,
    -91.24090037084521 + 287.9513821296269j,
    -112.0119549042285 + 315.3811612363091j,
]


# --- what is refused


@pytest.mark.parametrize("count", [0, -1, 2.0, True, 2])
def test_numbers_of_modes_that_there_are_not_are_refused(comm, count):
    with pytest.raises(ModelError, match="modes"):
        damped_modes(MultibodySystem(comm, [BODY, HINGE]), count=count)


@pytest.mark.parallel
def test_a_state_that_is_not_in_equilibrium_is_refused(comm):
    hinge = Revolute("hinge", None, BODY, point=(1.0, 0, 0), axis=(0, 0, 1))
    system = MultibodySystem(comm, [BODY, hinge, Gravity()])
    with pytest.raises(ModelError, match="not in equilibrium"):
        damped_modes(system, system.initial_state(), 1)


def test_without_slepc4py_one_sentence_says_how_to_get_it(comm, monkeypatch):
    monkeypatch.setitem(sys.modules, "slepc4py", None)
    with pytest.raises(InputError, match="modes need slepc4py"):
        damped_modes(MultibodySystem(comm, [BODY, HINGE]), count=1)


def test_options_of_petsc_reach_the_iteration(comm, capfd):
    options = PETSc.Options()
    options["modes_pep_view"] = None
    try:
        free(damped_modes(box(comm, degree=2), count=2))
    finally:
        options.delValue("modes_pep_view")
    if comm.rank == 0:
        assert "type: toar" in capfd.readouterr().out

"""Matrices of a system as SciPy's, beside what the package finds with its own."""

from dataclasses import replace

from mpi4py import MPI

import numpy as np
import pytest
from scipy import linalg, sparse

from turbine_fenicsx import (
    Gravity,
    JointDamper,
    JointSpring,
    KelvinVoigt,
    MultibodySystem,
    StVenantKirchhoff,
    modes,
    system_matrices,
)


@pytest.fixture
def clamped(machine):
    """The machine with its bearings held, so that it has no rigid motion."""
    m = machine()
    springs = [JointSpring(f"spring {b}", b, stiffness=900.0) for b in ("yaw", "rotor")]
    return m.system(*springs, JointDamper("damper", "rotor", damping=7.0))


def null_space(G):
    """A basis of the motions that constraints allow."""
    return linalg.null_space(G.toarray())


def test_frequencies_of_the_matrices_are_the_modes(clamped):
    M, _, K, G, _ = vars(system_matrices(clamped)).values()
    Z = null_space(G)
    squares = linalg.eigh(Z.T @ K @ Z, Z.T @ M @ Z, eigvals_only=True)
    found = modes(clamped, clamped.initial_state(), count=6)
    np.testing.assert_allclose(
        np.sqrt(squares[:6]) / (2 * np.pi), [m.frequency for m in found.modes], rtol=1e-6
    )


def test_mass_and_damping_are_those_of_the_parts(clamped):
    found = system_matrices(clamped)
    beam, rigid = found.parts["beam"], found.parts["rigid bodies"]
    n = found.mass.shape[0]
    y = np.zeros(n)
    y[beam][1::3] = 1.0
    assert y @ found.mass @ y == pytest.approx(3.0 * 1.0 * 0.5 * 0.4)  # density times volume
    y = np.zeros(n)
    y[rigid][1::12] = 1.0
    assert y @ found.mass @ y == pytest.approx(3.0)  # nacelle and hub
    T = found.parts["joint coordinates"]
    assert found.damping[T, T].toarray() == pytest.approx(np.diag([0.0, 7.0]))
    assert found.damping.nnz == 1
    assert abs(found.stiffness - found.stiffness.T).max() < 1e-9 * abs(found.stiffness).max()


def test_a_rigid_motion_meets_the_constraints_and_strains_nothing(machine):
    system = machine().system()
    found = system_matrices(system)
    state, model = system.initial_state(), system.flexible_models[0]
    speeds = machine(spin=1.0).system().initial_state()
    v = np.concatenate(system.comm.allgather(speeds.v[0].array))
    T = np.zeros(state.joint_coordinates.size)
    T[1] = 1.0
    y = np.concatenate([v, speeds.q_dot, T])
    assert model.n_owned <= v.size / 3
    assert np.abs(found.constraints @ y).max() < 1e-12
    force = found.stiffness @ y
    assert np.abs(force).max() < 1e-9 * abs(found.stiffness).max()
    assert repr(found).startswith(f"SystemMatrices({y.size} unknowns")


def test_the_matrices_do_not_depend_on_the_number_of_ranks(machine):
    system = machine().system(Gravity())
    found = system_matrices(system)
    norms = [sparse.linalg.norm(A) for A in (found.mass, found.stiffness, found.constraints)]
    alone = system_matrices(machine(comm=MPI.COMM_SELF).system(Gravity()))
    expected = [sparse.linalg.norm(A) for A in (alone.mass, alone.stiffness, alone.constraints)]
    np.testing.assert_allclose(norms, expected, rtol=1e-12)


def test_viscosity_is_in_the_damping(machine):
    m = machine()
    viscous = KelvinVoigt(StVenantKirchhoff(1200.0, 800.0), 3.0, 0.0)
    found = system_matrices(MultibodySystem(m.comm, [replace(m.beam, material=viscous)]))
    beam = found.parts["beam"]
    assert found.damping[beam, beam].nnz > 0

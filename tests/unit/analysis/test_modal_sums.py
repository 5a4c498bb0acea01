"""Claims about sums over the parts of a system in small motions."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    JointDamper,
    JointSpring,
    MultibodySystem,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
)
from turbine_fenicsx.analysis.modal_sums import ModalSums, Piece
from turbine_fenicsx.analysis.mode import Motion

pytestmark = pytest.mark.parallel

DENSITY, SIZE, SPRING = 3.0, np.array([2.0, 0.5, 0.4]), 70.0
MASS = DENSITY * np.prod(SIZE)


@pytest.fixture(scope="module")
def system():
    """A rigid arm on a spring, and a box on the arm."""
    comm = MPI.COMM_WORLD
    arm = RigidBody("arm", 2.0, (0.1, 0.2, 0.3), position=(-0.5, 0.2, 0.1))
    cells = mesh.create_box(comm, [(0, 0, 0), SIZE], [8, 2, 2], mesh.CellType.hexahedron)
    root = mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[0], 0.0))
    box = FlexibleBody("box", cells, StVenantKirchhoff(100.0, 80.0), DENSITY)
    pivot = Revolute("pivot", None, arm, point=(-1, 0, 0), axis=(0, 0, 1))
    forces = [JointSpring("spring", "pivot", SPRING), JointDamper("damper", "pivot", 5.0)]
    return MultibodySystem(comm, [arm, box, pivot, Coupling("root", box, root, arm), *forces])


@pytest.fixture(scope="module")
def sums(system):
    """With the box in two halves."""
    x = system.flexible_models[0].positions[:, 0]
    halves = [Piece("near", 0, np.flatnonzero(x < 1.01)), Piece("far", 0, np.flatnonzero(x > 1.01))]
    return ModalSums(system, system.initial_state(), halves)


def motion(system, field, q=None, angle=0.0):
    u = system.flexible_models[0].new_vector()
    u.array[:] = field(system.flexible_models[0].positions).ravel()
    return Motion(np.zeros(12) if q is None else q, np.array([angle]), (u,))


def shift(system, v):
    """A translation of everything."""
    q = np.concatenate([v, np.zeros(9)])
    return motion(system, lambda X: np.tile(v, (len(X), 1)), q)


def test_modal_masses_of_a_translation_are_the_masses_of_the_parts(system, sums):
    v = np.array([0.3, -0.4, 1.2])
    found = sums.modal_masses(shift(system, v))
    assert list(found) == ["arm", "near", "far"]
    assert found["arm"] == pytest.approx(2.0 * v @ v, rel=1e-13)
    assert found["near"] + found["far"] == pytest.approx(MASS * v @ v, rel=1e-12)
    # of eight layers of elements, four and a half belong to the nodes of the near part
    assert found["near"] == pytest.approx(4.5 / 8 * MASS * v @ v, rel=1e-12)


def test_inner_products_are_those_of_the_mass_matrix(system, sums):
    rng = np.random.default_rng(3)
    a = motion(
        system, lambda X: np.sin(X @ np.array([[1.0, 2, 3], [2, 1, 0], [0, 3, 1]])), rng.random(12)
    )
    b = shift(system, np.array([1.0, 0.0, 0.0]))
    assert sum(sums.modal_masses(a).values()) == pytest.approx(sums.inner_product(a, a), rel=1e-12)
    assert sums.inner_product(a, b) == pytest.approx(sums.inner_product(b, a), rel=1e-12)


def test_strain_energy_is_in_the_piece_that_is_strained(system, sums):
    stretch = 1e-3

    def pulled(X):
        return np.column_stack([stretch * np.maximum(X[:, 0] - 1.25, 0.0), 0 * X[:, :2]])

    found = sums.strain_energies(motion(system, pulled, angle=0.2))
    modulus = 100.0 + 2 * 80.0
    assert found["near"] == pytest.approx(0.0, abs=1e-14)
    assert found["far"] == pytest.approx(modulus * stretch**2 * 0.75 * 0.5 * 0.4, rel=1e-10)
    assert found["spring"] == pytest.approx(SPRING * 0.2**2, rel=1e-12)
    assert "damper" not in found


def test_a_translation_strains_nothing(system, sums):
    found = sums.strain_energies(shift(system, np.array([1.0, 2.0, 3.0])))
    assert found == pytest.approx({"near": 0.0, "far": 0.0, "spring": 0.0}, abs=1e-10)

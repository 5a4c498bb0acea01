"""Claims about ``modes.xdmf``: one time for each mode, everything moves, at a sensible size."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import mesh
from outputs import read_fields

from turbine_fenicsx import (
    Coupling,
    FlexibleBody,
    MultibodySystem,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
)
from turbine_fenicsx.analysis.mode import Mode, Modes, Motion
from turbine_fenicsx.simulation.mode_shapes import AMPLITUDE_RATIO, write_mode_shapes
from turbine_fenicsx.simulation.observers.field_grid import FieldGrid

pytestmark = pytest.mark.parallel

E3 = np.array([0.0, 0.0, 1.0])
PIVOT = np.array([1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """System and content of a file: a rotation as a rigid mode, then a bending that goes round."""
    comm = MPI.COMM_WORLD
    arm = RigidBody("arm", 2.0, (0.1, 0.2, 0.3), position=(-0.5, 0.0, 0.0))
    cells = mesh.create_box(comm, [(0, 0, 0), (4, 0.5, 0.5)], [8, 1, 1], mesh.CellType.hexahedron)
    root = mesh.locate_entities_boundary(cells, 2, lambda x: np.isclose(x[0], 0.0))
    rod = FlexibleBody("rod", cells, StVenantKirchhoff(100.0, 80.0), 3.0)
    pivot = Revolute("pivot", None, arm, point=(-1, 0, 0), axis=E3)
    system = MultibodySystem(comm, [arm, rod, pivot, Coupling("root", rod, root, arm)])
    model, state = system.flexible_models[0], system.initial_state()
    state.u[0].array[:] = np.column_stack(
        [0 * model.positions[:, :2], 0.1 + 0 * model.positions[:, :1]]
    ).ravel()

    def bend(way):
        u = model.new_vector()
        u.array.reshape(-1, 3)[:, way] = model.positions[:, 0] ** 2
        return Motion(np.zeros(12), np.zeros(1), (u,))

    turn = model.new_vector()
    turn.array[:] = np.cross(E3, model.positions + PIVOT).ravel()
    q = np.concatenate([np.cross(E3, (0.5, 0, 0)), *np.cross(E3, np.eye(3))])
    rigid = Mode(1e-5j, Motion(q, np.ones(1), (turn,)), is_rigid=True)
    modes = Modes(state, (rigid, Mode(-0.1 + 5j, bend(1), bend(2))))
    path = comm.bcast(str(tmp_path_factory.mktemp("shapes") / "modes.xdmf"))
    write_mode_shapes(path, FieldGrid(system), modes, {"modes": "words"})
    from pathlib import Path

    return Path(path), read_fields(Path(path))


def test_times_are_the_numbers_of_the_modes(written):
    assert list(written[1]) == [1.0, 2.0]
    assert 'Name="modes" Value="words"' in written[0].read_text()


def test_points_are_where_the_equilibrium_has_them(written):
    for fields in written[1].values():
        X = fields["Geometry"] - fields["displacement"]
        _, cells = np.unique(fields["part"], return_counts=True)
        assert 8 in cells  # those of the rod, in the order of the ranks
        nodes = fields["displacement"][:, 2] > 0.05
        assert nodes.sum() == 9 * 4
        assert X[nodes].min() == pytest.approx(0.0, abs=1e-7)


def test_the_largest_displacement_is_a_tenth_of_the_size(written):
    for fields in written[1].values():
        size = np.ptp(fields["Geometry"], axis=0).max()
        phases = np.linspace(0.0, 2 * np.pi, 721)[:, None, None]
        moved = np.cos(phases) * fields["mode_real"] - np.sin(phases) * fields["mode_imaginary"]
        assert np.linalg.norm(moved, axis=2).max() == pytest.approx(
            AMPLITUDE_RATIO * size, rel=1e-4
        )


def test_rigid_bodies_move_with_the_mode(written):
    fields = written[1][1.0]
    assert not np.any(fields["mode_imaginary"])
    X = fields["Geometry"] - fields["displacement"]
    turned = np.cross(E3, X + PIVOT)
    factor = np.sum(turned * fields["mode_real"]) / np.sum(turned**2)
    assert factor > 0.0
    assert fields["mode_real"] == pytest.approx(factor * turned, abs=1e-6)


def test_both_parts_of_a_motion_are_written(written):
    fields = written[1][2.0]
    real, imaginary = fields["mode_real"], fields["mode_imaginary"]
    assert real[:, 1] == pytest.approx(imaginary[:, 2], abs=1e-7)
    assert np.abs(real[:, [0, 2]]).max() == np.abs(imaginary[:, :2]).max() == 0.0

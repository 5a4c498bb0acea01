"""Claims about the frames of nodes in thin, curved walls."""

import numpy as np
import pytest

from turbine_fenicsx import StVenantKirchhoff, _compat
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.linear_solvers.frames import NodeFrames, mean_gradients
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.system.flexible_model import FlexibleModel

pytestmark = pytest.mark.parallel

RADIUS, WALL, LENGTH, ARC = 1.5, 1e-3, 3.0, np.pi / 4


def panel(comm, cells=2):
    """Quadratic hexahedra of the wall of a tube along e1, a millimetre thick, in a row."""
    reference = reference_cell("hexahedron", 2)
    span, around, through = (
        np.linspace(*ends, n)
        for ends, n in (((0.0, cells * LENGTH), 2 * cells + 1), ((0.0, ARC), 3), ((0.0, WALL), 3))
    )
    z, angle, depth = np.meshgrid(span, around, through, indexing="ij")
    r = RADIUS - depth
    points = np.stack([z, r * np.sin(angle), r * np.cos(angle)], axis=-1).reshape(-1, 3)
    i, j, k = reference.lattice.T
    corner = 2 * np.arange(cells)[:, None]
    nodes = np.ravel_multi_index((corner + i, 0 * corner + j, 0 * corner + k), z.shape)
    mine = comm.rank == 0
    mesh = _compat.mesh_of_arrays(
        comm, "hexahedron", 2, points if mine else points[:0], nodes if mine else nodes[:0]
    )
    return FlexibleModel(FlexibleBody("panel", mesh, StVenantKirchhoff(1e9, 1e9), 1e3, 2))


def test_frames_of_a_thin_curved_wall_follow_a_smooth_motion(comm):
    # In-plane bending, u = (-y^2/2, y z, 0)/radius: the material turns by y/radius about e3 and by
    # nothing about the other axes. The affine map nearest to the nodes of a cell turns by 1.4e-3
    # about e2, and half as far about e3 as it should: on a thin curved wall y^2 is almost linear
    # in the distance from the axis.
    rate = 1.0 / 400.0
    model = panel(comm)
    z, y, _ = model.positions.T
    u = model.new_vector()
    u.array[:] = np.column_stack([-0.5 * rate * y**2, rate * y * z, 0.0 * z]).ravel()
    (F,) = NodeFrames(model).rotations(u)
    spin = 0.5 * np.array([F[2, 1] - F[1, 2], F[0, 2] - F[2, 0], F[1, 0] - F[0, 1]])
    mean_y = RADIUS * (1.0 - np.cos(ARC)) / ARC
    # products of rotations and strains, which are up to 2.7e-3 and 1.5e-2
    assert np.allclose(spin.T, [0.0, 0.0, rate * mean_y], rtol=0, atol=2e-5)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_mean_gradients_are_exact_for_what_the_shape_functions_hold(machine, cell, degree):
    model = FlexibleModel(machine(cell=cell, degree=degree).beam)
    rng = np.random.default_rng(0)
    X = model.local_positions[_compat.dofs_of_cells(model.space)]
    bent = X + 0.02 * rng.normal(size=X.shape)
    W = mean_gradients(bent, cell, degree)
    # a constant has no gradient, the positions have the unit matrix; numbers of the size of 1/0.25
    assert np.max(np.abs(W.sum(axis=1)), initial=0.0) < 1e-11
    assert np.allclose(np.swapaxes(bent, 1, 2) @ W, np.eye(3), rtol=0, atol=1e-11)

"""Claims about strains of plies in bodies; oracles: exact strains of given deformations."""

import numpy as np
import pytest
from walls import CARBON, FOAM, GLASS, laminate, load_wall, wall_arrays

from turbine_fenicsx import FlexibleBody, ModelError, MultibodySystem, cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import tabulate_walls, total_thickness
from turbine_fenicsx.materials.ply_table import PlyTable
from turbine_fenicsx.system.ply_stresses import PlyStresses
from turbine_fenicsx.system.wall_strains import WallStrains

pytestmark = pytest.mark.parallel

PLIES = laminate((GLASS, 0.002, 45), (FOAM, 0.016, 0), (CARBON, 0.002, 10))
OTHER = laminate((CARBON, 0.02, -30))


def plate(s, a, z):
    return np.stack([2.0 * s, a, 0.02 * z], axis=-1)


def tube(s, a, z):
    angle = 2 * np.pi * a
    r = 1.0 + 0.02 * z
    return np.stack([3.0 * s, r * np.sin(angle), r * np.cos(angle)], axis=-1)


def walls_of(comm, place, *cells, closed=False):
    loaded, number = load_wall(comm, wall_arrays(place, *cells, closed=closed))
    plies = [PLIES if c % 2 else OTHER for c in number]
    table = tabulate_walls(plies, np.array([total_thickness(p) for p in plies]))
    law = Laminate.from_table(loaded.mesh, table)
    body = FlexibleBody("wall", loaded.mesh, law, cell_field(loaded.mesh, table.density), degree=2)
    system = MultibodySystem(comm, [body])
    return system, PlyStresses(system, body, plies), number


def strain_of(system, stresses, displacement):
    state, X = system.initial_state(), system.flexible_models[0].positions
    state.u[0].array[:] = displacement(X).ravel()
    stresses.update(state)
    return state


def test_faces_of_a_bent_plate_are_strained_by_curvature_and_stretch(comm):
    """u = (e x - k x z, 0, k x^2/2) has the linear strain e - k z along the span; E is to 1e-10."""
    system, stresses, number = walls_of(comm, plate, 3, 2)
    e, k = 1e-6, 4e-5

    def bend(X):
        x, _, z = X.T
        return np.stack([e * x - k * x * z, 0 * x, 0.5 * k * x**2], axis=1)

    strain_of(system, stresses, bend)
    for found, z in ((stresses.inner, -0.01), (stresses.outer, 0.01)):
        assert found.shape == (len(number), 4, 3)
        expected = np.broadcast_to([e - k * z, 0, 0], found.shape)
        assert np.allclose(found, expected, rtol=0, atol=1e-8)
    strains = stresses.strains()
    mine = [c for c in range(len(number)) if number[c] % 2]
    for c in mine:
        of_cell = strains[np.flatnonzero(stresses.table.wall == c)]
        # the foam from z = 0.008 to -0.008, its fibre along the span
        assert np.allclose(of_cell[1, :, :, 0], [[e - k * 0.008], [e + k * 0.008]], atol=1e-8)


def test_strains_follow_the_axes_of_a_curved_wall(comm):
    """A tube that is stretched, widened and twisted: the same strain all around."""
    system, stresses, _ = walls_of(comm, tube, 4, 12, closed=True)

    def deform(X):
        x, y, z = X.T
        turn = 3e-6 * x
        return np.stack([1e-6 * x, 2e-6 * y + turn * z, 2e-6 * z - turn * y], axis=1)

    strain_of(system, stresses, deform)
    # angles rise from z to y: the twist turns y by + z, which is towards rising angles
    for found, r in ((stresses.inner, 0.99), (stresses.outer, 1.01)):
        expected = np.broadcast_to([1e-6, 2e-6, 3e-6 * r], found.shape)
        assert np.allclose(found, expected, rtol=0, atol=3e-9)  # a cell spans 30 degrees


def test_large_strains_are_those_of_the_deformation_gradient(comm):
    """Of many states at once, as sums of nodes and as sums of vectors."""
    system, _, _ = walls_of(comm, tube, 2, 8, closed=True)
    space, rng = system.flexible_models[0].space, np.random.default_rng(0)
    walls, X = WallStrains.of(space), space.tabulate_dof_coordinates()
    H = 0.3 * rng.standard_normal((5, 3, 3))
    found = walls.strains(np.einsum("kj,mij->kmi", X, H))
    F = np.eye(3) + H
    E = 0.5 * (np.einsum("mki,mkj->mij", F, F) - np.eye(3))
    e = np.einsum("...ai,mij,...bj->...mab", walls.axes, E, walls.axes)
    wanted = np.stack([e[..., 0, 0], e[..., 1, 1], 2.0 * e[..., 0, 1]], axis=-1)
    assert np.allclose(found, wanted, rtol=0, atol=1e-12)
    of_vectors = walls.over(X).strains(H.transpose(2, 0, 1))
    assert np.allclose(of_vectors, wanted, rtol=0, atol=1e-12)


def test_rigid_motion_strains_nothing(comm):
    system, stresses, _ = walls_of(comm, tube, 2, 8, closed=True)
    c, s = np.cos(1.0), np.sin(1.0)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    strain_of(system, stresses, lambda X: X @ R.T - X + [1.0, 2.0, 3.0])
    assert np.max(np.abs(stresses.strains()), initial=0.0) < 1e-13


def test_largest_index_is_that_of_the_worst_ply_of_each_cell(comm):
    system, stresses, number = walls_of(comm, plate, 3, 2)
    strain_of(system, stresses, lambda X: 1e-4 * X)

    def criterion(table: PlyTable, strains):
        return np.array([ply.thickness for ply in table.plies])[:, None, None] * np.ones((1, 2, 4))

    index, ply = stresses.largest(criterion)
    assert index.tolist() == [0.016 if c % 2 else 0.02 for c in number]
    assert ply.tolist() == [1 if c % 2 else 0 for c in number]


def test_stresses_are_those_of_plane_stress_in_each_ply(comm):
    system, stresses, _ = walls_of(comm, plate, 2, 2)
    strain_of(system, stresses, lambda X: X * [1e-6, -2e-6, 0.0])
    for ply, strain, stress in zip(
        stresses.table.plies, stresses.strains(), stresses.stresses(), strict=True
    ):
        (E1, E2, _), nu12 = ply.material.young, ply.material.poisson[0]
        e1, e2, g = strain[0, 0]
        share = 1.0 - nu12**2 * E2 / E1
        by_hand = [(E1 * e1 + nu12 * E2 * e2) / share, E2 * (e2 + nu12 * e1) / share]
        assert np.allclose(stress[0, 0], [*by_hand, ply.material.shear[0] * g], rtol=1e-10)


def test_wrong_numbers_of_laminates_are_refused_on_all_ranks(comm):
    system, stresses, number = walls_of(comm, plate, 3, 2)
    body = stresses.body
    short = [PLIES] * (len(number) - (comm.rank == 0))
    with pytest.raises(ModelError, match=r"plies of 'wall' are needed for each of the \d+ cells"):
        PlyStresses(system, body, short)
    bare = [() if comm.rank == 0 and c == 0 else PLIES for c in range(len(number))]
    with pytest.raises(ModelError, match="a cell of 'wall' has no plies"):
        PlyStresses(system, body, bare)

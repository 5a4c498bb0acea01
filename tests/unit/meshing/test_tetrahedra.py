"""Claims about blades of tetrahedra."""

import numpy as np
import pytest
from rotor_meshes import BLADE, ONE_BLADE, arrays

from turbine_fenicsx.meshing import MeshOptions
from turbine_fenicsx.meshing.rotor import mesh_rotor


@pytest.mark.parametrize(("degree", "bound"), [(1, 0.1), (2, 0.05)])
@pytest.mark.parametrize("fineness", [{}, {"size": 1.0}, {"size": 0.6}])
def test_worst_quality_of_tetrahedra(fineness, degree, bound):
    assert arrays("tetrahedron", degree, **fineness).examine().worst_quality >= bound


def test_volume_of_tetrahedra_converges():
    coarse, fine = (
        {d: 1 - sum(arrays("tetrahedron", d, size=s).examine().volumes.values()) / BLADE.volume
         for d in (1, 2)}
        for s in (1.0, 0.6)
    )  # fmt: skip
    for errors, bound in ((coarse, 0.12), (fine, 0.06)):
        assert 0 < errors[1] < bound
        assert abs(errors[2]) < errors[1] / 7
    assert fine[1] < coarse[1] / 2


def test_quadratic_tetrahedra_follow_the_ellipses():
    mesh = arrays("tetrahedron", 2, size=0.6)
    x = mesh.points[np.unique(mesh.facets[mesh.facet_groups == 2])]
    local = (x - ONE_BLADE.centre) @ ONE_BLADE.frame(1).T
    fraction = (local[:, 0] - BLADE.hub_radius) / BLADE.length
    axes = np.stack([BLADE.chord_at(fraction), BLADE.thickness_at(fraction)], axis=1) / 2
    radius = np.linalg.norm(local[:, 1:] / axes, axis=1)[fraction < 1 - 1e-9]
    # gmsh's own nodes are off by up to 2e-6; the edges below were straightened for quality
    assert radius.max() < 1 + 1e-5
    assert np.mean(radius > 1 - 1e-5) > 0.8


def test_the_same_tetrahedra_come_out_twice():
    first = arrays("tetrahedron", 1)
    again = mesh_rotor(BLADE, ONE_BLADE, MeshOptions("tetrahedron"))
    np.testing.assert_array_equal(first.points, again.points)
    np.testing.assert_array_equal(first.cells, again.cells)

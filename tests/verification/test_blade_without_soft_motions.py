"""Walls of a whole blade: few points of quadrature leave no soft motions."""

import numpy as np
import pytest
from walls import load_wall
from windio_files import IEA_22, load_turbine

from turbine_fenicsx import Coupling, FlexibleBody, MultibodySystem, cell_field, modes
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import tabulate_walls
from turbine_fenicsx.materials.wall_quadrature import gauss_quadrature
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.model import MeshArrays

pytestmark = pytest.mark.slow


def clamped_blade(comm):
    """Makes the clamped blade with more arguments for the law, of a coarse mesh."""
    shape = load_turbine(IEA_22).blade
    block = mesh_hollow(shape, 12, 20)
    facets, groups = np.concatenate([block.root, block.skin]), [len(block.root), len(block.skin)]
    n = len(block.cells)
    arrays = MeshArrays(
        block.reference,
        block.points,
        block.cells,
        np.arange(1, n + 1),
        facets,
        np.repeat([1, 2], groups),
        {f"cell_{c}": c + 1 for c in range(n)},
        {"root": 1, "skin": 2},
    )
    loaded, number = load_wall(comm, arrays)
    cells = zip(block.part, block.span.tolist(), block.arc.tolist(), strict=True)
    layups = [shape.layup(block.parts[p], tuple(s), tuple(a)) for p, s, a in cells]

    def make(moments, **law):
        table = tabulate_walls(layups, block.thickness, moments)[number]
        fields = (cell_field(loaded.mesh, table.in_plane), cell_field(loaded.mesh, table.through))
        density = cell_field(loaded.mesh, table.density)
        body = FlexibleBody("blade", loaded.mesh, Laminate(*fields, **law), density, degree=2)
        root = Coupling("root", body, loaded.facets("root"), None)
        return MultibodySystem(comm, [body, root])

    return make


def test_modes_of_a_blade_are_those_of_full_integration_or_a_little_softer(comm):
    """Motions that the points do not see would come first, with frequencies near zero."""
    make = clamped_blade(comm)

    def frequencies(moments, **law):
        found = modes(make(moments, **law), count=8).modes
        return np.array([mode.frequency for mode in found])

    full = frequencies(False, quadrature=gauss_quadrature(3, 3, 3))
    for moments in (False, True):
        used = frequencies(moments)
        # the first eight bend and twist the blade; from the ninth on panels vibrate
        assert np.all(used > 0.95 * full) and np.all(used < 1.01 * full)

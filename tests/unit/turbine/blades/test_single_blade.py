"""Claims about one blade out of the mesh of a rotor."""

from dataclasses import replace

import numpy as np
import pytest

from turbine_fenicsx.meshing import BladeGeometry, MeshOptions, RotorLayout
from turbine_fenicsx.meshing.rotor import mesh_rotor
from turbine_fenicsx.turbine.blades.single_blade import list_unequal_blades, take_blade

LAYOUT = RotorLayout(centre=(0.0, 1.0, -4.0), axis=(0.0, -0.1, 1.0), cone=-0.05)


@pytest.fixture(scope="module")
def rotor():
    return mesh_rotor(BladeGeometry(), LAYOUT, MeshOptions(elements=(1, 1, 5)))


@pytest.mark.parametrize("blade", [1, 2, 3])
def test_a_blade_has_its_own_axes_and_groups(rotor, blade):
    found = take_blade(rotor, LAYOUT, blade)
    assert set(found.volumes) == {f"blade_{blade}"}
    assert set(found.surfaces) == {f"root_{blade}", f"skin_{blade}"}
    assert len(found.cells) == len(rotor.cells) // 3
    assert found.cells.max() == len(found.points) - 1
    assert found.points[:, 0].min() == pytest.approx(2.25)
    assert found.points[:, 0].max() == pytest.approx(56.25)
    placed = LAYOUT.place(found.points, blade)
    own = rotor.cells[rotor.cell_groups == rotor.volumes[f"blade_{blade}"]]
    assert placed[found.cells] == pytest.approx(rotor.points[own], abs=1e-12)
    report = found.examine()
    assert report.bad_cells == 0
    volume = rotor.examine().volumes[f"blade_{blade}"]
    assert report.volumes[f"blade_{blade}"] == pytest.approx(volume, rel=1e-12)


def test_blades_that_differ_are_found(rotor):
    assert list_unequal_blades(rotor, LAYOUT) == []
    points = rotor.points.copy()
    third = np.unique(rotor.cells[rotor.cell_groups == rotor.volumes["blade_3"]])
    points[third[-1]] += 0.01
    (sentence,) = list_unequal_blades(replace(rotor, points=points), LAYOUT)
    assert sentence.startswith("blade_3 differs from blade_1")
    second = rotor.cell_groups == rotor.volumes["blade_2"]
    fewer = np.ones(len(rotor.cells), dtype=bool)
    fewer[np.flatnonzero(second)[0]] = False
    short = replace(rotor, cells=rotor.cells[fewer], cell_groups=rotor.cell_groups[fewer])
    (sentence,) = list_unequal_blades(short, LAYOUT)
    assert sentence.startswith("blade_2 differs from blade_1")

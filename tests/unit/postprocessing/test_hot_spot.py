"""Where a field is largest, and from where one looks at it."""

import importlib.util

import numpy as np
import pytest
from outputs import PARTS, turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.field_reader import FieldReader
from turbine_fenicsx.postprocessing.hot_spot import find_hot_spot

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("pyvista") is None, reason="PyVista, which reads fields, is missing"
)


def test_the_place_of_the_largest_value_is_seen_from_its_side(tmp_path):
    reader = FieldReader(str(turbine(tmp_path / "fields.xdmf")), PARTS)
    grid = reader.grid(0)
    blade = reader.cells(PARTS.parts[3])
    grid.cell_data["load"] = np.zeros(grid.n_cells)
    grid.cell_data["load"][blade] = 3.0
    spot = find_hot_spot(grid, reader, PARTS, "load")
    assert (spot.part.name, spot.value) == ("blade_2", 3.0)
    x = grid.extract_cells(blade).points
    assert spot.point == pytest.approx(x.mean(axis=0))
    root, tip = spot.ends
    assert np.linalg.norm(tip - root) == pytest.approx(54.0, rel=1e-3)
    assert np.linalg.norm(root - (0, 0, -5)) < np.linalg.norm(tip - (0, 0, -5))
    for direction in (spot.flat, spot.normal):  # the thinnest one, along e3
        assert np.abs(direction) == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)


def test_a_field_that_is_not_there_is_named(tmp_path):
    reader = FieldReader(str(turbine(tmp_path / "fields.xdmf")), PARTS)
    with pytest.raises(InputError, match="there is no field 'load' of cells"):
        find_hot_spot(reader.grid(0), reader, PARTS, "load")

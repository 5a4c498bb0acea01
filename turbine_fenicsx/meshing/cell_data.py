"""Data of cells in files of gmsh: one view of numbers for each name."""

from __future__ import annotations

from typing import Any

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.model import MeshArrays


def write_cell_data(gmsh: Any, arrays: MeshArrays, path: str) -> None:
    """Append the data of the cells of a mesh to its file.

    Args:
        gmsh: The module, with the mesh as its current model.
        arrays: The mesh; its cells have the numbers that `MeshArrays.add_to` gives them.
    """
    tags = len(arrays.facets) + 1 + np.arange(len(arrays.cells))
    model = gmsh.model.getCurrent()
    for name, values in arrays.cell_data.items():
        view = gmsh.view.add(name)
        gmsh.view.addHomogeneousModelData(view, 0, model, "ElementData", tags, values)
        gmsh.view.write(view, path, True)
        gmsh.view.remove(view)


def pick_cell_data(
    found: dict[str, tuple[IntArray, Array]], elements: IntArray
) -> dict[str, Array]:
    """Data of cells out of all that a file knows of elements.

    Args:
        found: Numbers of elements and a value of each, by name.
        elements: gmsh's numbers of the cells, shape (n_cells,).

    Returns:
        Values of the cells by name, shape (n_cells,) each; without data that some cells lack.
    """
    data = {}
    for name, (tags, values) in found.items():
        order = np.argsort(tags)
        row = order[np.minimum(np.searchsorted(tags, elements, sorter=order), len(tags) - 1)]
        if np.array_equal(tags[row], elements):
            data[name] = values[row]
    return data

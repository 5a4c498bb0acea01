"""The mesh of one blade in its own axes, out of that of a rotor of equal blades."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing import RotorLayout
from turbine_fenicsx.meshing.model import MeshArrays

EQUAL = 1e-6
"""Maximum distance of nodes of equal blades in the axes of each, relative to the blade."""


def take_blade(mesh: MeshArrays, layout: RotorLayout, blade: int = 1) -> MeshArrays:
    """The mesh of a blade along a1, a2, a3 from the rotor centre, with its own groups alone.

    Args:
        blade: Number of the blade, from 1.
    """
    volume = f"blade_{blade}"
    own = mesh.cell_groups == mesh.volumes[volume]
    nodes, cells = np.unique(mesh.cells[own], return_inverse=True)
    names = [name for name in mesh.surfaces if name in (f"root_{blade}", f"skin_{blade}")]
    shown = np.isin(mesh.facet_groups, [mesh.surfaces[name] for name in names])
    points = (mesh.points[nodes] - np.asarray(layout.centre)) @ layout.frame(blade).T
    return replace(
        mesh,
        points=points,
        cells=cells.reshape(-1, mesh.cells.shape[1]),
        cell_groups=mesh.cell_groups[own],
        facets=np.searchsorted(nodes, mesh.facets[shown]),
        facet_groups=mesh.facet_groups[shown],
        volumes={volume: mesh.volumes[volume]},
        surfaces={name: mesh.surfaces[name] for name in names},
        cell_data={name: values[own] for name, values in mesh.cell_data.items()},
    )


def list_unequal_blades(mesh: MeshArrays, layout: RotorLayout) -> list[str]:
    """A sentence for each blade of a mesh that is not the first one in another place."""
    blades = [take_blade(mesh, layout, k) for k in range(1, layout.n_blades + 1)]
    first = _describe_cells(blades[0])
    size, tree = float(np.ptp(first[:, 0])), cKDTree(first)
    found = []
    for k, blade in enumerate(blades[1:], start=2):
        other = _describe_cells(blade)
        equal = len(other) == len(first)
        if equal:
            distance, order = tree.query(other)
            equal = np.max(distance) <= EQUAL * size and np.unique(order).size == len(order)
        if not equal:
            found.append(
                f'blade_{k} differs from blade_1, and blade.model = "reduced" needs equal blades'
            )
    return found


def _describe_cells(blade: MeshArrays) -> Array:
    """Middle of each cell, shape (cells, 3) [m]."""
    return np.asarray(blade.points[blade.cells].mean(axis=1))

"""The mesh of one blade as plain arrays, in the frame of the blade."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.cells import ReferenceCell


@dataclass(frozen=True)
class BladeBlock:
    """Nodes, cells and boundary faces of one blade.

    Attributes:
        points: Coordinates along span (from the rotor centre), chord and thickness,
            shape (n_points, 3) [m].
        cells: Nodes of each cell in gmsh's order, shape (n_cells, n).
        root: Nodes of each face on the hub surface, shape (n_root, m).
        skin: Nodes of each other boundary face, tip included, shape (n_skin, m).
    """

    reference: ReferenceCell
    points: Array
    cells: IntArray
    root: IntArray
    skin: IntArray

    @property
    def cell_data(self) -> dict[str, Array]:
        """Per-cell data by name, each of shape (n_cells,). Empty for solid blades."""
        return {}


def boundary_faces(cells: IntArray, reference: ReferenceCell) -> IntArray:
    """Return the faces that belong to one cell only, shape (n_faces, nodes per face)."""
    faces = cells[:, reference.faces].reshape(-1, reference.faces.shape[1])
    _, first, count = np.unique(face_keys(faces, reference), return_index=True, return_counts=True)
    outer: IntArray = faces[np.sort(first[count == 1])]
    return outer


def face_keys(faces: IntArray, reference: ReferenceCell) -> npt.NDArray[np.uint64]:
    """Return a number for each face that depends on its corners, not on their order.

    The key is the sum of random numbers of the corners modulo 2^64; two of a million different
    faces have the same key with a probability of 3e-8.
    """
    corners = faces[:, : 4 if reference.cell == "hexahedron" else 3]
    n_points = int(corners.max(initial=0)) + 1
    number = np.random.default_rng(0).integers(2**64, size=n_points, dtype=np.uint64)
    return np.asarray(number[corners].sum(axis=1, dtype=np.uint64))


def split_boundary(points: Array, faces: IntArray, hub_radius: float) -> tuple[IntArray, IntArray]:
    """Split boundary faces into the root, all nodes at the hub radius, and the skin."""
    # round-off of the coordinates is 1e-15 of the radius, elements are larger than 1e-6 of it
    on_hub = np.abs(points[:, 0] - hub_radius) <= 1e-9 * hub_radius
    is_root = on_hub[faces].all(axis=1)
    return faces[is_root], faces[~is_root]

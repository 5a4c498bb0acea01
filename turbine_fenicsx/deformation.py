"""The grid of ``fields.xdmf`` at one time, its deformation scaled if that is asked for.

The cell field ``part`` says what is what: 0 nacelle, 1 hub, 2 to 4 the blades, 5 the tower.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

NACELLE, HUB, FIRST_BLADE, TOWER = 0, 1, 2, 5
"""Values of the cell field ``part``."""

_VOLUMES = (10, 12)  # VTK's numbers of tetrahedra and hexahedra

Points = NDArray[np.float64]


def scaled_deformation(
    x: Points, u: Points, hub: NDArray[Any], flexible: NDArray[Any], scale: float
) -> Points:
    """Points with the deformation of the flexible parts scaled, but not the motion of the hub.

    The rigid motion of the hub is fitted to its points [least squares, by the singular values of
    the correlation]. Where it alone would have taken a point of a flexible part is the origin of
    the deformation of this point, so that turning rotor and nacelle are not exaggerated.

    Args:
        x: Present positions, shape (n, 3) [m].
        u: Displacements, shape (n, 3) [m].
        hub: Which points are on the hub, shape (n,) of bool.
        flexible: Which points are on flexible parts, shape (n,) of bool.
        scale: Factor; 1 shows the deformation as it is, 0 the rigid motion.

    Returns:
        Positions, shape (n, 3) [m].

    Raises:
        ValueError: if the hub has less than three points.
    """
    if np.count_nonzero(hub) < 3:
        raise ValueError("the deformation cannot be scaled: there is no hub (part 1) to refer to")
    X = x - u
    centre, present = X[hub].mean(axis=0), x[hub].mean(axis=0)
    left, _, right = np.linalg.svd((x[hub] - present).T @ (X[hub] - centre))
    left[:, 2] *= np.sign(np.linalg.det(left @ right))  # a rotation, no reflection
    rigid = (X - centre) @ (left @ right).T + present
    return np.where(flexible[:, None], rigid + scale * (x - rigid), x)


def read_grid(reader: Any, step: int, scale: float) -> Any:
    """Read one time.

    Args:
        reader: PyVista's reader of ``fields.xdmf``.
        step: Number of the time.
        scale: Factor of the deformation.

    Raises:
        ValueError: if the parts are not marked, or there is no hub to scale the deformation.
    """
    reader.set_active_time_point(step)
    grid = reader.read().copy()  # the reader gives the same one for the same step
    if "part" not in grid.cell_data:
        raise ValueError(f"{reader.path} has no cell field 'part'")
    if scale != 1.0:
        u = np.asarray(grid.point_data["displacement"], dtype=float)
        part = np.asarray(grid.cell_data["part"])
        hub = points_of(grid, part == HUB)
        flexible = points_of(grid, flexible_cells(grid) & (part != TOWER))
        x = np.asarray(grid.points, dtype=float)
        grid.points = scaled_deformation(x, u, hub, flexible, scale)
    return grid


def flexible_cells(grid: Any) -> NDArray[Any]:
    """Which cells have a volume; rigid parts are surfaces."""
    return np.isin(np.asarray(grid.celltypes), _VOLUMES)


def points_of(grid: Any, cells: NDArray[Any]) -> NDArray[Any]:
    """Which points some cells touch, shape (n_points,) of bool."""
    found = np.zeros(grid.n_points, dtype=bool)
    if cells.any():
        found[np.asarray(grid.extract_cells(cells).point_data["vtkOriginalPointIds"])] = True
    return found

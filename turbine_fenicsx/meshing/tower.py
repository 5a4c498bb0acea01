"""Tower: a hollow tube of hexahedra below the origin.

The tube stands on its foot at e2 = -height, and its head is at the origin. Elements are numbered
through the wall, around the axis and up; with the azimuth from e3 to e1 these three directions are
right-handed. Vertices lie on the circles of the section. First-order cells are flat, so a section
of n cells around lacks 1 - sin(2 pi/n)/(2 pi/n) of its area: 10 % for n = 8 and 1 % for n = 24.
Second-order cells follow the circles, with 0.1 % for n = 8.
"""

import os
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.meshing.block import boundary_faces
from turbine_fenicsx.meshing.cells import reference_cell
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.rotor import write_msh

TOWER, BOTTOM, TOP = "tower", "tower_bottom", "tower_top"
"""Names of the physical volume and of the two physical surfaces."""


@dataclass(frozen=True)
class TowerGeometry:
    """Hollow tube whose diameter and wall are linear between stations.

    Attributes:
        height: From the foot to the head [m].
        stations: Fractions of the height, rising from 0 to 1 [-].
        diameters: Outer diameter at each station [m].
        walls: Thickness of the wall at each station, measured horizontally [m].
    """

    height: float
    stations: tuple[float, ...]
    diameters: tuple[float, ...]
    walls: tuple[float, ...]

    def __post_init__(self) -> None:
        for name, values in (
            ("height", (self.height,)),
            ("diameter", self.diameters),
            ("wall", self.walls),
        ):
            for value in values:
                if not 0.0 < value < np.inf:
                    raise ModelError(f"tower.{name} = {value!r}: must be greater than 0")
        s = self.stations
        if len(s) < 2 or (s[0], s[-1]) != (0.0, 1.0) or not (np.diff(s) > 0.0).all():
            raise ModelError(f"tower.stations = {s}: must rise from 0 to 1")
        if not len(s) == len(self.diameters) == len(self.walls):
            raise ModelError(
                f"tower.stations = {s}: needs as many diameters and walls, got "
                f"{len(self.diameters)} and {len(self.walls)}"
            )
        for diameter, wall in zip(self.diameters, self.walls, strict=True):
            if wall >= 0.5 * diameter:
                raise ModelError(
                    f"tower.wall = {wall:g}: leaves no hollow, expected less than "
                    f"{0.5 * diameter:g} m, half of the diameter there"
                )

    @classmethod
    def cone(
        cls,
        height: float = 80.0,
        bottom_diameter: float = 6.0,
        top_diameter: float = 4.0,
        wall: float = 0.04,
    ) -> "TowerGeometry":
        """A cone with a wall of the same thickness everywhere; all lengths in metres."""
        return cls(height, (0.0, 1.0), (bottom_diameter, top_diameter), (wall, wall))

    @property
    def volume(self) -> float:
        """Exact volume of the wall [m^3]."""
        d, t = np.array(self.diameters), np.array(self.walls)
        middle = (d[1:] + d[:-1] - t[1:] - t[:-1]) * (t[1:] + t[:-1]) / 4.0
        ring = t * (d - t)  # Simpson's rule is exact: the integrand is quadratic between stations
        areas = (ring[1:] + 4.0 * middle + ring[:-1]) / 6.0
        return float(pi * self.height * (np.diff(self.stations) @ areas))


def mesh_tower(
    tower: TowerGeometry, elements: tuple[int, int, int], geometry_degree: int
) -> MeshArrays:
    """Mesh a tower.

    Args:
        tower: Its shape.
        elements: Numbers of elements around, through the wall and along the height; three or more
            around.
        geometry_degree: 1 for flat cells, 2 for curved ones.

    Returns:
        The mesh, with p n_around (p n_through + 1) (p n_along + 1) nodes for degree p.
    """
    n_around, n_through, n_along = elements
    p = geometry_degree
    azimuth = np.arange(p * n_around) * (2.0 * pi / (p * n_around))
    through, up = (np.linspace(0.0, 1.0, p * n + 1) for n in (n_through, n_along))
    outer, wall = (np.interp(up, tower.stations, v) for v in (tower.diameters, tower.walls))
    radius = 0.5 * outer - wall * (1.0 - through[:, None])
    shape = (through.size, azimuth.size, up.size)
    points = np.empty((*shape, 3))
    points[..., 0] = radius[:, None, :] * np.sin(azimuth)[:, None]
    points[..., 1] = tower.height * (up - 1.0)
    points[..., 2] = radius[:, None, :] * np.cos(azimuth)[:, None]

    number = np.arange(points[..., 0].size).reshape(shape)
    reference = reference_cell("hexahedron", p)
    corners = [p * np.arange(n) for n in (n_through, n_around, n_along)]
    first = np.stack(np.meshgrid(*corners, indexing="ij"), axis=-1).reshape(-1, 3)
    i, j, k = (first[:, axis, None] + reference.lattice[:, axis] for axis in range(3))
    cells = number[i, j % azimuth.size, k]

    faces = boundary_faces(cells, reference)
    ends = [faces[np.isin(faces, number[:, :, layer]).all(axis=1)] for layer in (0, -1)]
    return MeshArrays(
        reference=reference,
        points=points.reshape(-1, 3),
        cells=cells,
        cell_groups=np.ones(len(cells), dtype=np.int64),
        facets=np.concatenate(ends),
        facet_groups=np.repeat([1, 2], [len(end) for end in ends]),
        volumes={TOWER: 1},
        surfaces={BOTTOM: 1, TOP: 2},
    )


def build_tower(
    tower: TowerGeometry,
    elements: tuple[int, int, int],
    geometry_degree: int,
    path: str | os.PathLike[str],
) -> MeshReport:
    """Mesh a tower and write it to a file.

    Call it on one rank only. The physical volume is called ``tower``, its ends ``tower_bottom`` and
    ``tower_top``.

    Args:
        tower: Its shape.
        elements: Numbers of elements around, through the wall and along the height.
        geometry_degree: 1 for flat cells, 2 for curved ones.
        path: File to write, with the ending .msh; an existing file is replaced at the end.

    Returns:
        Numbers of nodes and cells, volume and worst quality.
    """
    arrays = mesh_tower(tower, elements, geometry_degree)
    report = arrays.examine()
    if report.bad_cells:
        raise MeshError(
            f"{report.bad_cells} of {report.cells} cells of the tower came out inverted or "
            f"degenerate with {elements} elements; choose other numbers"
        )
    write_msh(arrays, Path(path))
    return report

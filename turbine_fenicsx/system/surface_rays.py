"""The surface of a flexible body: where lines leave it, and what is there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_nodes import BodyNodes

_SIDE = 5
"""Points along each side of a facet, from which a search begins."""
_STEPS = 20
"""Of Newton's method, which needs three to five."""
_TOLERANCE = 1e-8
"""Round-off of coordinates in a facet; crossings that differ by less of their distance are one."""


@dataclass(frozen=True)
class Crossing:
    """A point of the surface, seen from one of the cells that meet there.

    Args:
        distance: From the origin of the line [m].
        nodes: Nodes of the cell, counted over all ranks, shape (nodes,).
        gradients: Of their shape functions in the initial configuration, shape (nodes, 3) [1/m].
        normal: Of the surface, a unit vector outwards, shape (3,).
    """

    distance: float
    nodes: IntArray
    gradients: Array
    normal: Array


class Skin:
    """Facets on the surface of a flexible body.

    Note:
        Collective, as are all methods.
    """

    def __init__(self, model: BodyNodes) -> None:
        mesh, body = model.space.mesh, model.body.full
        self._mesh, self._map = mesh, model.space.dofmap.index_map
        self._cell, self._degree = _compat.cell_name(mesh), body.degree
        facets = _compat.exterior_facets(mesh)
        mesh.topology.create_connectivity(3, 2)
        to_cell, to_facet = (mesh.topology.connectivity(*dims) for dims in ((2, 3), (3, 2)))
        cells = np.array([to_cell.links(f)[0] for f in facets], dtype=np.int32)
        sides = [
            np.flatnonzero(to_facet.links(c) == f)[0] for c, f in zip(cells, facets, strict=True)
        ]
        self._sides = np.array(sides, dtype=np.int64)
        self._nodes = _compat.dofs_of_cells(model.space)[cells]
        self._X = model.space.tabulate_dof_coordinates()[self._nodes]
        corners = _compat.reference_facets(self._cell)
        self._origins, self._axes = corners[:, 0], corners[:, 1:3] - corners[:, :1]
        centre = corners.mean(axis=(0, 1))
        self._outwards = np.cross(self._axes[:, 0], self._axes[:, 1])
        self._outwards *= np.sign(np.sum(self._outwards * (self._origins - centre), axis=1))[
            :, None
        ]
        self._grid = np.array([(i, j) for j in range(_SIDE) for i in range(_SIDE)]) / (_SIDE - 1)
        self._grid = self._grid[[self._is_inside(place) for place in self._grid]]
        tables = [
            _compat.shape_functions(self._cell, self._degree, start + self._grid @ axes)[0]
            for start, axes in zip(self._origins, self._axes, strict=True)
        ]
        self._points = np.einsum("fgn,fni->fgi", np.array(tables)[self._sides], self._X)

    def leave(self, origin: npt.ArrayLike, direction: npt.ArrayLike) -> list[Crossing]:
        """Where the half-line from a point crosses the surface last; equal on all ranks.

        Args:
            origin: The point in the initial configuration, shape (3,) [m].
            direction: Of the half-line, shape (3,).

        Returns:
            A crossing for each cell that meets there; none if the half-line misses the body.
        """
        d = np.asarray(direction, dtype=float)
        mine = list(self._cross(np.asarray(origin, dtype=float), d / np.linalg.norm(d)))
        found = [crossing for part in self._mesh.comm.allgather(mine) for crossing in part]
        last = max((crossing.distance for crossing in found), default=0.0)
        return [c for c in found if c.distance > last * (1.0 - 1e2 * _TOLERANCE)]

    def middle(self, normal: npt.ArrayLike, height: float, axes: npt.ArrayLike) -> Array | None:
        """Middle of the extents of the section that a plane cuts.

        Args:
            normal: Of the plane, a unit vector, shape (3,).
            height: Distance of the plane from the origin, along the normal [m].
            axes: Directions of the extents, unit vectors across the normal, shape (2, 3).

        Returns:
            Coordinates along the axes, shape (2,) [m]; None if the plane misses the body.
        """
        above = self._points @ np.asarray(normal, dtype=float) - height
        across = self._points @ np.asarray(axes, dtype=float).T
        gaps = np.abs(self._grid[:, None] - self._grid).sum(axis=2)
        a, b = np.nonzero(np.triu(np.isclose(gaps, 1.0 / (_SIDE - 1))))
        cut = (above[:, a] > 0.0) != (above[:, b] > 0.0)
        h_a, h_b, x_a, x_b = (
            above[:, a][cut],
            above[:, b][cut],
            across[:, a][cut],
            across[:, b][cut],
        )
        x = x_a + (h_a / (h_a - h_b))[:, None] * (x_b - x_a)
        extent = np.array([np.min(x, axis=0, initial=np.inf), np.min(-x, axis=0, initial=np.inf)])
        self._mesh.comm.Allreduce(MPI.IN_PLACE, extent, op=MPI.MIN)
        low, high = extent * [[1.0], [-1.0]]
        return None if np.isinf(low).any() else 0.5 * (low + high)

    def _cross(self, origin: Array, d: Array) -> Iterator[Crossing]:
        """Crossings with the facets of this rank."""
        p = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
        across = np.array([p, np.cross(d, p)]) / np.linalg.norm(p)
        offsets = (self._points - origin) @ across.T
        low, high = offsets.min(axis=1), offsets.max(axis=1)
        margin = 0.2 * (high - low)
        near = np.all((low - margin <= 0.0) & (high + margin >= 0.0), axis=1)
        for facet in np.flatnonzero(near):
            start = self._grid[np.argmin(np.sum(offsets[facet] ** 2, axis=1))]
            place = self._find_place(facet, start, origin, across)
            if place is not None:
                crossing = self._describe(facet, place, origin, d)
                if crossing.distance > 0.0:
                    yield crossing

    def _find_place(self, facet: int, start: Array, origin: Array, across: Array) -> Array | None:
        """Coordinates in a facet where a line crosses it, by Newton's method."""
        place = start
        for _ in range(_STEPS):
            x, dx = self._map_facet(facet, place)
            step = np.linalg.lstsq(across @ dx[:, :2], across @ (x - origin), rcond=None)[0]
            place = place - step
            if np.max(np.abs(step)) < 1e-3 * _TOLERANCE:
                return place if self._is_inside(place) else None
            if np.max(np.abs(place - 0.5)) > 1.5:
                return None
        return None

    def _map_facet(self, facet: int, place: Array) -> tuple[Array, Array]:
        """Position there, and its derivatives along the facet and outwards, shape (3, 3)."""
        N, dN = self._shapes(facet, place)
        side = self._sides[facet]
        into = np.vstack([self._axes[side], self._outwards[side]])
        return N @ self._X[facet], self._X[facet].T @ dN @ into.T

    def _describe(self, facet: int, place: Array, origin: Array, d: Array) -> Crossing:
        """The crossing at a place in a facet."""
        x, (a, b, out) = (found.T for found in self._map_facet(facet, place))
        normal = np.cross(a, b)
        normal *= np.sign(normal @ out) / np.linalg.norm(normal)
        dN = self._shapes(facet, place)[1]
        gradients = dN @ np.linalg.inv(self._X[facet].T @ dN)
        nodes = self._map.local_to_global(self._nodes[facet].astype(np.int32))
        return Crossing(float((x - origin) @ d), nodes.astype(np.int64), gradients, normal)

    def _shapes(self, facet: int, place: Array) -> tuple[Array, Array]:
        """Shape functions of the cell, (nodes,), and their derivatives there, (nodes, 3)."""
        side = self._sides[facet]
        point = self._origins[side] + place @ self._axes[side]
        N, dN = _compat.shape_functions(self._cell, self._degree, point[None])
        return N[0], dN[0]

    def _is_inside(self, place: Array) -> bool:
        """Whether coordinates are those of a point in the facet."""
        below = place.sum() <= 1.0 + _TOLERANCE if self._cell == "tetrahedron" else True
        return bool(below and np.all((place >= -_TOLERANCE) & (place <= 1.0 + _TOLERANCE)))

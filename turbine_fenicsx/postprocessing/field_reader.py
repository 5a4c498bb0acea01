"""Field files read by PyVista, time by time, with the deformation exaggerated if asked for.

Each flexible part is seen from what carries it: the ground, the hub, the ring of a pitch bearing.
Its displacement relative to that motion is multiplied, so that turning, yawing and pitching stay as
they are. Parts on a flexible part, as a nacelle on its tower, ride along with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.postprocessing.colours import DEFLECTION
from turbine_fenicsx.records.parts import Part, Parts
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A rotation about a point, and where this point goes.

    Args:
        rotation: Shape (3, 3).
        start: The point, shape (3,) [m].
        end: Where it goes, shape (3,) [m].
    """

    rotation: Points
    start: Points
    end: Points

    def __call__(self, points: Points) -> Points:
        """Moved points, shape (n, 3) [m]."""
        return (points - self.start) @ self.rotation.T + self.end


STILL = RigidMotion(np.eye(3), np.zeros(3), np.zeros(3))


def fit_motion(before: Points, after: Points) -> RigidMotion:
    """The rigid motion that fits best, by the singular values of the correlation.

    Points in a line, or fewer than three, say nothing about a rotation and are only shifted.

    Args:
        before: Points, shape (n, 3) [m].
        after: The same points later, shape (n, 3) [m].
    """
    start, end = before.mean(axis=0), after.mean(axis=0)
    if not span_a_plane(before):
        return RigidMotion(np.eye(3), start, end)
    return RigidMotion(nearest_rotation((after - end).T @ (before - start)), start, end)


def find_deflections(
    x: Points,
    u: Points,
    coupling: NDArray[np.int32],
    points_of: Callable[[int], NDArray[np.bool_]],
    parts: Parts,
) -> Points:
    """How far points of flexible parts are from those of a rigid part on the same root.

    Args:
        x: Present positions, shape (n, 3) [m].
        u: Displacements, shape (n, 3) [m].
        coupling: Number of the coupling that holds a point, 0 for none, shape (n,).
        points_of: Which points a part has, by its number; shape (n,) of bool.

    Returns:
        Shape (n, 3), zero for rigid parts [m].
    """
    X, found = x - u, np.zeros_like(x)
    for number in (p.number for p in parts.parts if p.stands_on is None):
        mine = points_of(number)
        roots = mine & np.isin(coupling, list(parts.roots))
        fixed = roots if span_a_plane(X[roots]) else mine
        found[mine] = x[mine] - fit_motion(X[fixed], x[fixed])(X[mine])
    return found


def exaggerate(
    x: Points,
    deflections: Points,
    coupling: NDArray[np.int32],
    points_of: Callable[[int], NDArray[np.bool_]],
    parts: Parts,
    scale: float,
) -> Points:
    """Points with the deformation of the flexible parts multiplied.

    Args:
        x, coupling, points_of: As of `find_deflections`.
        deflections: What it found, shape (n, 3) [m].
        scale: Factor of the deformation; 1 shows it as it is, 0 none.

    Returns:
        Positions, shape (n, 3) [m].
    """
    more = (scale - 1.0) * deflections
    moved = x.copy()
    rides: dict[int, RigidMotion] = {0: STILL}  # with the number of what one stands on
    flexible = [p.number for p in parts.parts if p.stands_on is None]
    mine = {number: points_of(number) for number in flexible}
    held = {number: set(coupling[mine[number]].tolist()) - {0} for number in flexible}
    while flexible:
        number = next(n for n in flexible if _find_ground(held[n], parts.roots) in rides)
        flexible.remove(number)
        ride, own = rides[_find_ground(held[number], parts.roots)], mine[number]
        moved[own] = ride(x[own] + more[own])
        for head in held[number] - set(parts.roots):
            there = own & (coupling == head)
            rides[head] = fit_motion(x[there], moved[there])
    for part in parts.parts:
        if part.stands_on:
            there = points_of(part.number)
            moved[there] = rides[part.stands_on](x[there])
    return moved


def _find_ground(held: set[int], roots: Mapping[int, int]) -> int:
    """Supports of the parent bodies of a part."""
    return min((roots[number] for number in held if number in roots), default=0)


def span_a_plane(points: Points) -> bool:
    """Whether there are three points or more that are not in a line."""
    if len(points) < 3:
        return False
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[1] > 1e-6 * sizes[0])


class _XdmfGrids:
    """The grids of an XDMF file.

    Attributes:
        times: Their times [s].
    """

    def __init__(self, path: str) -> None:
        import pyvista

        self._reader = pyvista.get_reader(path)
        self.times = np.asarray(self._reader.time_values)

    def read(self, step: int) -> Any:
        """The grid of a time by its number, from 0."""
        self._reader.set_active_time_point(step)
        return self._reader.read()


class _VtkHdfGrids:
    """The grids of a VTKHDF file.

    PyVista's reader knows nothing of its times, VTK's nothing of the time of one alone.

    Attributes:
        times: Their times [s].
    """

    def __init__(self, path: str) -> None:
        from vtkmodules.vtkIOHDF import vtkHDFReader

        with VtkHdfFile(path) as file:
            self.times = file.times
        self._reader = vtkHDFReader()
        self._reader.SetFileName(path)

    def read(self, step: int) -> Any:
        """The grid of a time by its number, from 0."""
        import pyvista

        self._reader.UpdateTimeStep(self.times[step])
        return pyvista.wrap(self._reader.GetOutput())


def open_grids(path: str) -> _XdmfGrids | _VtkHdfGrids:
    """The grids of a file of fields."""
    return _VtkHdfGrids(path) if path.endswith(".vtkhdf") else _XdmfGrids(path)


AMPLITUDE = "amplitude"
"""Field of `ModeReader`: how far a point moves, 1 where it moves most."""


class FieldReader:
    """Reads grids and cuts parts out of them.

    Args:
        path: The file.
        parts: What its parts are.
        scale: Factor of the deformation.

    Attributes:
        times: Times written [s].
        deflects: Whether grids get the field `DEFLECTION`.
    """

    def __init__(self, path: str, parts: Parts, scale: float = 1.0) -> None:
        self._grids = open_grids(path)
        self.times = self._grids.times
        self._parts, self._scale, self.deflects = parts, scale, False
        first = self._read(0)
        part = np.asarray(first.cell_data["part"])
        self._cells = {p.number: np.flatnonzero(part == p.number) for p in parts.parts}

    def grid(self, step: int) -> Any:
        """The grid of one time."""
        grid = self._read(step)
        if self._scale == 1.0 and not self.deflects:
            return grid
        x, u = (np.asarray(a, dtype=float) for a in (grid.points, grid.point_data["displacement"]))
        coupling = np.asarray(grid.point_data["coupling"])

        def points_of(number: int) -> NDArray[np.bool_]:
            found = np.zeros(len(x), dtype=bool)
            found[grid.extract_cells(self._cells[number]).point_data[_POINTS]] = True
            return found

        found = find_deflections(x, u, coupling, points_of, self._parts)
        if self.deflects:
            grid.point_data[DEFLECTION] = found
        if self._scale != 1.0:
            grid.points = exaggerate(x, found, coupling, points_of, self._parts, self._scale)
        return grid

    def cells(self, part: Part) -> NDArray[np.int64]:
        """Numbers of the cells of a part."""
        found: NDArray[np.int64] = self._cells[part.number]
        return found

    def surface(self, grid: Any, part: Part, smooth: bool) -> Any:
        """Surface of a part; None if it has no cells.

        Args:
            grid: Grid of one time.
            part: The part.
            smooth: Whether fields of cells become averages at the points.
        """
        cells = self._cells[part.number]
        if not len(cells):
            return None
        piece = grid.extract_cells(cells)
        if smooth and part.stands_on is None:
            piece = piece.cell_data_to_point_data()
        return piece.extract_surface()

    def bounds(self, grid: Any, name: str) -> tuple[float, ...] | None:
        """Least and greatest coordinates of the part of a name [m]; None if there is none."""
        cells = [self._cells[number] for number in self._parts.numbers(name)]
        if not cells or not len(cells[0]):
            return None
        return tuple(grid.extract_cells(cells[0]).bounds)

    def field_names(self) -> list[str]:
        """Names of the fields."""
        grid = self._read(0)
        return sorted({*grid.point_data, *grid.cell_data, DEFLECTION})

    def _read(self, step: int) -> Any:
        """The grid as it is written."""
        return self._grids.read(step).copy()  # the reader gives the same one for the same step


class ModeReader(FieldReader):
    """Reads the shapes of ``modes.xdmf``.

    Attributes:
        phase: Phase of the motion a cos(phase) - b sin(phase) that `grid` shows [rad].
    """

    def __init__(self, path: str, parts: Parts, scale: float = 1.0) -> None:
        super().__init__(path, parts, scale)
        self.phase = 0.0

    def field_names(self) -> list[str]:
        """Names of the fields."""
        return [AMPLITUDE]

    def grid(self, step: int) -> Any:
        """The grid of one mode at the present phase, with the field `AMPLITUDE`."""
        grid = self._read(step)
        a, b = (
            np.asarray(grid.point_data[name], dtype=float)
            for name in ("mode_real", "mode_imaginary")
        )
        moved = np.cos(self.phase) * a - np.sin(self.phase) * b
        grid.points = np.asarray(grid.points, dtype=float) + self._scale * moved
        size = np.sqrt(np.sum(a * a + b * b, axis=1))
        grid.point_data[AMPLITUDE] = size / max(float(size.max()), 1e-300)
        return grid

    def at_rest(self, step: int) -> Any:
        """The grid without the motion."""
        return self._read(step)


_POINTS = "vtkOriginalPointIds"

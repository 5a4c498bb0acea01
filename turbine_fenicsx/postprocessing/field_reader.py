"""``fields.xdmf`` read by PyVista, time by time, with its deformation exaggerated if asked for."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.postprocessing.deformation import exaggerate
from turbine_fenicsx.records.parts import Part, Parts

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
    """

    def __init__(self, path: str, parts: Parts, scale: float = 1.0) -> None:
        import pyvista

        self._reader = pyvista.get_reader(path)
        self.times = np.asarray(self._reader.time_values)
        self._parts, self._scale = parts, scale
        first = self._read(0)
        part = np.asarray(first.cell_data["part"])
        self._cells = {p.number: np.flatnonzero(part == p.number) for p in parts.parts}

    def grid(self, step: int) -> Any:
        """The grid of one time."""
        grid = self._read(step)
        if self._scale != 1.0:
            x, u = (
                np.asarray(a, dtype=float) for a in (grid.points, grid.point_data["displacement"])
            )
            coupling = np.asarray(grid.point_data["coupling"])

            def points_of(number: int) -> NDArray[np.bool_]:
                found = np.zeros(len(x), dtype=bool)
                found[grid.extract_cells(self._cells[number]).point_data[_POINTS]] = True
                return found

            grid.points = exaggerate(x, u, coupling, points_of, self._parts, self._scale)
        return grid

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
        return sorted({*grid.point_data, *grid.cell_data})

    def _read(self, step: int) -> Any:
        """The grid as it is written."""
        self._reader.set_active_time_point(step)
        return self._reader.read().copy()  # the reader gives the same one for the same step


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

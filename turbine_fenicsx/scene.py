"""Draws the turbine from ``fields.xdmf``; the process that `turbine_fenicsx.pictures` starts.

    python -m turbine_fenicsx.scene < job.json

Where a graphics library is missing, VTK ends the process instead of raising, which is why nothing
else runs in it. The job names the file, the steps and pictures to draw and how; one dot on stdout
says that another picture or frame is done, the last line on stderr what went wrong.

Where the tower is no part of the model a pale one is added, so that the picture shows a wind
turbine.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.deformation import (
    FIRST_BLADE,
    HUB,
    NACELLE,
    TOWER,
    flexible_cells,
    points_of,
    read_grid,
)

SIZE = (1200, 1440)
"""Width and height of a picture in pixels; movies need even numbers."""

VIEWS = {"oblique": (0.38, 0.09, 0.92), "front": (0.0, 0.0, 1.0), "side": (1.0, 0.0, 0.0)}
"""Direction from the turbine to the observer if the rotor is on the side of +e3; e2 is up."""

_LABELS = {
    "cauchy_stress_norm": ("Cauchy stress norm [MPa]", 1e-6),
    "displacement": ("displacement [m]", 1.0),
    "velocity": ("velocity [m/s]", 1.0),
}
_MOST_EDGES = 2000
"""Blades of more cells are drawn without their edges, which would hide the colours."""

_COLOUR_BAR = {
    "vertical": False,
    "position_x": 0.60,
    "position_y": 0.06,
    "width": 0.36,
    "height": 0.07,
    "font_family": "arial",
    "title_font_size": 26,
    "label_font_size": 24,
    "color": "black",
    "n_labels": 3,
}


class Scene:
    """The turbine at one time after another.

    Args:
        job: ``fields``, ``scalar`` (None for plain blades), ``scale``, ``view``, ``limits`` of the
            colours (None for all values of the given steps).
        steps: Numbers of the times that will be drawn.

    Raises:
        ValueError: if there is no such field or the parts are not marked.
    """

    def __init__(self, job: Mapping[str, Any], steps: Sequence[int]) -> None:
        """Open the file, find the limits of the colours and where to look from."""
        import pyvista

        self._reader = pyvista.get_reader(job["fields"])
        self._times = np.asarray(self._reader.time_values)
        self._scalar, self._scale = job["scalar"], job["scale"]
        self._limits = job["limits"]
        first = self._read(0)
        part = np.asarray(first.cell_data["part"])
        if not flexible_cells(first).any() and self._scalar == "cauchy_stress_norm":
            self._scalar = None  # rigid blades have no stress
        self._radius, self._side, self._centre = _size(first, part)
        if self._scalar is not None:
            self._coloured(first)  # fails at once if there is no such field
            if self._limits is None:
                largest = max(np.nanmax(self._coloured(self._read(i))[2]) for i in steps)
                self._limits = (0.0, _round_up(float(largest)))
        self._plotter = pyvista.Plotter(off_screen=True, window_size=SIZE, lighting="light kit")
        self._plotter.set_background("white")
        self._look_from(job["view"])
        self._plotter.enable_anti_aliasing("ssaa")

    def draw(self, step: int) -> NDArray[np.uint8]:
        """The picture of one step, shape (height, width, 3)."""
        plotter, grid = self._plotter, self._read(step)
        plotter.suppress_rendering = True  # until all is there, else it renders six times
        for title in list(plotter.scalar_bars.keys()):
            plotter.remove_scalar_bar(title, render=False)
        plotter.clear_actors()
        part = np.asarray(grid.cell_data["part"])
        if (part >= FIRST_BLADE).any():
            self._add_blades(grid, part >= FIRST_BLADE)
        for number, colour in ((NACELLE, "#b8bdc4"), (HUB, "#8f969f")):
            if (part == number).any():
                plotter.add_mesh(
                    grid.extract_cells(part == number),
                    color=colour,
                    ambient=0.25,
                    smooth_shading=True,
                    split_sharp_edges=True,
                )
        if (part == NACELLE).any() and not (part == TOWER).any():
            x_min, x_max, y_min, _, z_min, z_max = grid.extract_cells(part == NACELLE).bounds
            tower = _tower((0.5 * (x_min + x_max), y_min, 0.5 * (z_min + z_max)), self._radius)
            plotter.add_mesh(tower, color="#e8ecf1", ambient=0.6, diffuse=0.4, opacity=0.6)
        words = f"t = {self._times[step]:.2f} s"
        if self._scale != 1.0:
            words += f"\ndeformation \u00d7 {self._scale:g}"
        plotter.add_text(
            words, position=(60, 90), font_size=14, color="black", font="arial", name="words"
        )
        plotter.suppress_rendering = False
        plotter.render()
        return np.asarray(plotter.screenshot(return_img=True))

    def _read(self, step: int) -> Any:
        """Grid of one step."""
        return read_grid(self._reader, step, self._scale)

    def _coloured(self, grid: Any) -> tuple[Any, str, NDArray[np.float64]]:
        """Add the field that colours the blades under its label; also its values there."""
        fields = {**grid.point_data, **grid.cell_data}
        if self._scalar not in fields:
            names = sorted(name for name in fields if not name.startswith("vtk"))
            raise ValueError(f"there is no field '{self._scalar}', but {', '.join(names)}")
        label, factor = _LABELS.get(self._scalar, (self._scalar.replace("_", " "), 1.0))
        values = np.asarray(fields[self._scalar], dtype=float)
        values = factor * (np.linalg.norm(values, axis=1) if values.ndim == 2 else values)
        on_blades = np.asarray(grid.cell_data["part"]) >= FIRST_BLADE
        if self._scalar in grid.point_data:
            grid.point_data[label] = values
            on_blades = points_of(grid, on_blades)
        else:
            grid.cell_data[label] = values
        return grid, label, values[on_blades]

    def _add_blades(self, grid: Any, cells: NDArray[Any]) -> None:
        """Blades and the legend of their colours."""
        if self._scalar is not None:
            grid, label, _ = self._coloured(grid)
        blades = grid.extract_cells(cells)
        edges = bool(blades.n_cells <= _MOST_EDGES and flexible_cells(blades).any())
        how = {"ambient": 0.25, "show_edges": edges, "edge_color": "#333333", "line_width": 0.6}
        if self._scalar is None:
            self._plotter.add_mesh(blades, color="#56B4E9", **how)
            return
        self._plotter.add_mesh(
            blades,
            scalars=label,
            cmap="viridis",
            clim=self._limits,
            scalar_bar_args={**_COLOUR_BAR, "title": label + "\n", "fmt": "%.4g"},
            **how,
        )

    def _look_from(self, view: str) -> None:
        """Point the camera at the turbine, in parallel projection."""
        up, down = 1.04 * self._radius, 1.64 * self._radius  # of the rotor axis, with a margin
        x, y, z = self._centre
        focus = np.array([x, y + 0.5 * (up - down), z])
        direction = np.array(VIEWS[view]) * (self._side, 1.0, self._side)
        camera = self._plotter.camera
        camera.focal_point = focus
        camera.position = focus + 10.0 * self._radius * direction
        camera.up = (0.0, 1.0, 0.0)
        camera.enable_parallel_projection()
        camera.parallel_scale = 0.5 * (up + down)
        camera.clipping_range = (self._radius, 20.0 * self._radius)


def _round_up(x: float) -> float:
    """The next number that a scale of three marks can end at; 1 for zero."""
    if not x > 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(x))
    return float(
        next(
            n
            for n in (1.0, 1.2, 1.6, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
            if n * power >= x * (1.0 - 1e-9)
        )
        * power
    )


def _size(grid: Any, part: NDArray[Any]) -> tuple[float, float, tuple[float, float, float]]:
    """Radius of the rotor [m], side of the nacelle (along e3) on which it is, and its centre [m].

    The turbine stands at e1 = e3 = 0 of the centre, which is on the tower axis.
    """
    points = np.asarray(grid.points, dtype=float)
    hub = points[points_of(grid, part == HUB)] if (part == HUB).any() else points
    nacelle = points[points_of(grid, part == NACELLE)] if (part == NACELLE).any() else hub
    centre, axis = hub.mean(axis=0), nacelle.mean(axis=0)
    rotor = points[points_of(grid, part != TOWER)]
    radius = float(np.linalg.norm(rotor - centre, axis=1).max())
    return radius, 1.0 if centre[2] >= axis[2] else -1.0, (axis[0], centre[1], axis[2])


def _tower(top: Sequence[float], radius: float) -> Any:
    """Tapered cylinder from ``top`` [m] down, in proportion to the radius of the rotor [m]."""
    import pyvista

    angle, depth = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 65), np.linspace(0.0, 1.0, 2))
    thickness = (0.034 + 0.02 * depth) * radius
    return pyvista.StructuredGrid(
        top[0] + thickness * np.cos(angle),
        top[1] - 1.55 * radius * depth,
        top[2] + thickness * np.sin(angle),
    )


def _write_movie(path: str, fps: float, frames: Iterable[NDArray[np.uint8]]) -> Iterator[None]:
    """Write an MP4 frame by frame, yielding after each."""
    import imageio_ffmpeg

    writer = imageio_ffmpeg.write_frames(path, SIZE, fps=fps, quality=8, macro_block_size=2)
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
            yield
    finally:
        writer.close()


def draw(job: Mapping[str, Any]) -> Iterator[None]:
    """Draw the pictures of a job, then its movie; yields after each picture and frame."""
    if job["movie"]:
        import imageio_ffmpeg  # noqa: F401 (say at once if it is missing)
    movie = job["movie"] or {"steps": []}
    scene = Scene(job, [*(step for step, _ in job["pictures"]), *movie["steps"]])
    for step, path in job["pictures"]:
        _save(scene.draw(step), path)
        yield
    if job["movie"]:
        frames = (scene.draw(step) for step in movie["steps"])
        yield from _write_movie(movie["path"], movie["fps"], frames)


def _save(image: NDArray[np.uint8], path: str) -> None:
    """Write a picture as PNG."""
    from PIL import Image

    Image.fromarray(image).save(path, dpi=(300, 300))


def main() -> int:
    """Do the job on stdin; an error is one sentence on stderr and exit code 2."""
    try:
        for _ in draw(json.load(sys.stdin)):
            print(".", flush=True)
    except ModuleNotFoundError as problem:
        need = "movies need imageio-ffmpeg: pip install imageio-ffmpeg"
        if "imageio" not in str(problem):
            need = f"pictures need PyVista: pip install pyvista ({problem})"
        print(need, file=sys.stderr)
        return 2
    except (OSError, ValueError) as problem:
        print((str(problem).strip() or repr(problem)).splitlines()[0], file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Draw a model from ``fields.xdmf``, in the process that the module ``pictures`` starts.

    python -m turbine_fenicsx.postprocessing.scene < job.json

Where a graphics library is missing, VTK ends the process instead of raising, which is why nothing
else runs in it. The job names the file, the steps and pictures to draw and how; one dot on stdout
says that another picture or frame is done, the last line on stderr what went wrong.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from textwrap import wrap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import colours
from turbine_fenicsx.postprocessing.backdrop import Backdrop
from turbine_fenicsx.postprocessing.camera import look_at
from turbine_fenicsx.postprocessing.field_reader import FieldReader, ModeReader
from turbine_fenicsx.postprocessing.hot_spot import draw_hot_spot
from turbine_fenicsx.records.conventions import NACELLE, TOWER
from turbine_fenicsx.records.parts import Part, Parts

_MOST_SCALES = 3
"""With more bodies than this, all have the same scale of colours."""

_WIDTH = 28
"""Letters in a line of the title, left of the tower."""

_PLAIN, _RIGID = "#56B4E9", "#c9d0d8"


class Scene:
    """The model at one time after another.

    Args:
        job: ``fields``, ``parts`` (their text), ``titles`` of modes by their steps (none for the
            fields of a run), ``title`` of a run, ``smooth``, ``edges``, ``scale``, ``view``,
            ``size``. ``scalar`` is None for plain colours; ``coloured`` has patterns of the names
            of parts and bodies, none for all; ``limits`` of the colours may be None, see `colours`.
        steps: Numbers of the times that will be drawn.
    """

    def __init__(self, job: Mapping[str, Any], steps: Sequence[int]) -> None:
        import pyvista

        self._parts = Parts.from_text(job["parts"])
        self._reader: FieldReader
        kind = ModeReader if job["titles"] else FieldReader
        self._reader = kind(job["fields"], self._parts, job["scale"])
        self._job, self._size = job, tuple(job["size"])
        self._scalar = job["scalar"]
        names = self._reader.field_names()
        if self._scalar == colours.DEFAULT_FIELD:
            self._scalar = colours.STRESS if colours.STRESS in names else colours.DEFLECTION
        self._reader.deflects = self._scalar == colours.DEFLECTION
        if self._scalar not in (None, *names):
            shown = [name for name in names if not name.startswith("vtk")]
            raise InputError(f"there is no field '{self._scalar}', but {', '.join(shown)}")
        common = job["limits"] is not None
        self._groups = colour_parts(self._parts, self._scalar, job["coloured"], common)
        grids = (self._reader.grid(step) for step in steps)
        self._backdrop = Backdrop(self._parts)
        self._scales = self._look_through(grids)
        self._plotter = pyvista.Plotter(
            off_screen=True, window_size=self._size, lighting="light kit"
        )
        self._plotter.set_background("white")
        look_at(
            self._plotter.camera,
            self._backdrop.frame(),
            job["view"],
            self._size,
            bool(self._scales) and not job["titles"],
        )
        self._plotter.enable_anti_aliasing("ssaa")

    def draw(self, step: int, phase: float = 0.0) -> NDArray[np.uint8]:
        """The picture of one step, shape (height, width, 3); of a mode at one phase [rad]."""
        if isinstance(self._reader, ModeReader):
            self._reader.phase = phase
        plotter, grid = self._plotter, self._reader.grid(step)
        plotter.suppress_rendering = True  # until all is there, else it renders six times
        for title in list(plotter.scalar_bars.keys()):
            plotter.remove_scalar_bar(title, render=False)
        plotter.clear_actors()
        # the amplitude of a mode has no unit: its colours need no legend
        legends = set(self._scales) if self._job["titles"] else set()
        for part in self._parts.parts:
            surface = self._make_surface(grid, part)
            if surface is None:
                continue
            group = self._groups.get(part.number)
            if group is None or not self._scales:
                self._add_plain(surface, part)
            else:
                self._add_coloured(surface, part, group, group not in legends)
                legends.add(group)
        if isinstance(self._reader, ModeReader):
            self._add_ghost(self._reader.at_rest(step))
        self._backdrop.add_to(plotter, self._reader.bounds(grid, NACELLE))
        height = self._size[1]
        plotter.add_text(
            self._choose_words(step),
            position=(0.04 * height, (0.9 if self._job["titles"] else 0.05) * height),
            font_size=max(4, round(height / (60 if self._job["titles"] else 75))),
            color="black",
            font="arial",
            name="words",
        )
        plotter.suppress_rendering = False
        plotter.render()
        return np.asarray(plotter.screenshot(return_img=True))

    def _choose_words(self, step: int) -> str:
        """Text in the corner: the mode, or the title and the time."""
        if self._job["titles"]:
            return str(self._job["titles"][step])
        lines = wrap(self._job["title"].replace("$", r"\$"), _WIDTH)  # $ begins formulas of VTK
        words = "\n".join([*lines, f"t = {self._reader.times[step]:.2f} s"])
        if self._job["scale"] != 1.0:
            words += f"\ndeformation \u00d7 {self._job['scale']:g}"
        return words

    def _add_ghost(self, grid: Any) -> None:
        """The parts without the motion, pale."""
        for part in self._parts.parts:
            surface = self._make_surface(grid, part)
            if surface is not None:
                surface.clear_data()
                self._plotter.add_mesh(surface, color="#9aa7b4", opacity=0.3, ambient=0.5)

    def _look_through(self, grids: Iterable[Any]) -> dict[str, tuple[float, float]]:
        """Ends of the scale of each group; what the backdrop has to hold on the way."""
        values: dict[str, list[NDArray[np.float64]]] = {g: [] for g in self._groups.values()}
        for grid in grids:
            self._backdrop.include(grid, self._reader)
            if self._job["limits"] is None:
                for part in self._parts.parts:
                    surface = (
                        self._make_surface(grid, part) if part.number in self._groups else None
                    )
                    if surface is not None:
                        values[self._groups[part.number]].append(self._read_values(surface))
        if self._job["limits"] is not None:
            return {group: tuple(self._job["limits"]) for group in values}
        return {group: colours.scale_of(found) for group, found in values.items() if found}

    def _make_surface(self, grid: Any, part: Part) -> Any:
        """Surface of a part with the field on it."""
        return self._reader.surface(grid, part, self._job["smooth"])

    def _read_values(self, surface: Any) -> NDArray[np.float64]:
        """The field in the unit of its legend."""
        return colours.to_scalars(self._scalar, surface[self._scalar])

    def _add_plain(self, surface: Any, part: Part) -> None:
        """A part in one colour."""
        blade = part.stands_on is None or part.name.startswith("blade")
        surface.clear_data()
        self._plotter.add_mesh(
            surface,
            color=_PLAIN if blade else _RIGID,
            ambient=0.25,
            show_edges=bool(self._job["edges"] and part.stands_on is None),
            smooth_shading=True,
            split_sharp_edges=True,
            feature_angle=_SHARP_OF_TOWER if part.body == TOWER else _SHARP,
        )

    def _add_coloured(self, surface: Any, part: Part, group: str, legend: bool) -> None:
        """A part in colours, and the legend of its scale."""
        low, high = self._scales[group]
        title = colours.label(self._scalar, group)
        values = self._read_values(surface)
        kept = "point" if len(values) == surface.n_points else "cell"
        surface.clear_data()
        (surface.point_data if kept == "point" else surface.cell_data)[title] = values
        self._plotter.add_mesh(
            surface,
            scalars=title,
            preference=kept,
            cmap=colours.colour_map(),
            clim=(low, high),
            ambient=0.28,
            diffuse=0.8,
            show_edges=bool(self._job["edges"]),
            edge_color="#333333",
            line_width=0.6,
            smooth_shading=True,
            split_sharp_edges=True,
            feature_angle=_SHARP_OF_TOWER if part.body == TOWER else _SHARP,
            show_scalar_bar=legend,
            scalar_bar_args=self._place_legend(group, title) if legend else None,
        )

    def _place_legend(self, group: str, title: str) -> dict[str, Any]:
        """Place and looks of a legend; several stand on top of each other on the right."""
        k, n = list(self._scales).index(group), len(self._scales)
        height = 0.86 / n
        return {
            "title": title + "\n",
            "vertical": True,
            "position_x": 0.83,
            "position_y": 0.07 + (n - 1 - k) * height,
            "width": 0.06,
            "height": 0.92 * height if n > 1 else 0.6 * height,
            "font_family": "arial",
            "title_font_size": round(self._size[1] / 42),
            "label_font_size": round(self._size[1] / 45),
            "color": "black",
            "n_labels": 5,
            "fmt": "%.4g",
            "unconstrained_font_size": True,
        }


def colour_parts(
    parts: Parts, field: str | None, patterns: Sequence[str], common: bool
) -> dict[int, str]:
    """Which parts have colours, and which of them share a scale.

    Args:
        field: The field, None for none.
        patterns: What the name of a part or of its body must fit; none for all.

    Returns: Number of the part to its body if each body has a separate scale, else to nothing.
    """
    if field is None:
        return {}
    for pattern in patterns:
        if not any(_fits(part, [pattern]) for part in parts.parts):
            names = ", ".join(dict.fromkeys(n for p in parts.parts for n in (p.name, p.body)))
            raise InputError(f"there is no part '{pattern}', but {names}")
    of_flexible = field in colours.OF_FLEXIBLE_PARTS
    found = [
        part
        for part in parts.parts
        if (not patterns or _fits(part, patterns))
        and not (of_flexible and part.stands_on is not None)
    ]
    n_bodies = len({part.body for part in found})
    apart = of_flexible and not common and 1 < n_bodies <= _MOST_SCALES
    return {part.number: part.body if apart else "" for part in found}


_SHARP = 50.0
"""Edges at which surfaces turn by more than this stay edges in the shading [deg]."""

_SHARP_OF_TOWER = 80.0
"""A tower of six cells around is round; only its ends have edges."""


def _fits(part: Part, patterns: Sequence[str]) -> bool:
    """Whether the name of a part or of its body fits one of some patterns."""
    return any(fnmatchcase(name, p) for p in patterns for name in (part.name, part.body))


def _write_movie(
    path: str, fps: float, size: Sequence[int], frames: Iterable[NDArray[np.uint8]]
) -> Iterator[None]:
    """Write an MP4 frame by frame, yielding after each."""
    import imageio_ffmpeg

    writer = imageio_ffmpeg.write_frames(path, tuple(size), fps=fps, quality=8, macro_block_size=2)
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
            yield
    finally:
        writer.close()


def draw(job: Mapping[str, Any]) -> Iterator[None]:
    """Draw the pictures of a job, then its movie; yields after each picture and frame."""
    from PIL import Image

    if job["movie"]:
        import imageio_ffmpeg  # noqa: F401 (say at once if it is missing)
    if job["hot_spot"]:
        parts = Parts.from_text(job["parts"])
        reader = FieldReader(job["fields"], parts, job["scale"])
        for step, path in job["pictures"]:
            given = step, job["scalar"], job["title"], tuple(job["size"])
            Image.fromarray(draw_hot_spot(reader, parts, *given)).save(path, dpi=(300, 300))
            yield
        return
    movie = job["movie"] or {"steps": []}
    scene = Scene(job, [*(step for step, _ in job["pictures"]), *movie["steps"]])
    for step, path in job["pictures"]:
        Image.fromarray(scene.draw(step)).save(path, dpi=(300, 300))
        yield
    if job["movie"]:
        phases = movie.get("phases", np.zeros(len(movie["steps"])))
        frames = (scene.draw(k, phase) for k, phase in zip(movie["steps"], phases, strict=True))
        yield from _write_movie(movie["path"], movie["fps"], job["size"], frames)


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
    except (OSError, InputError) as problem:
        print((str(problem).strip() or repr(problem)).splitlines()[0], file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

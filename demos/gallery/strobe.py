"""Stroboscopic pictures: a model at several times in one picture, the last one in full colours."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from turbine_fenicsx.postprocessing.field_reader import FieldReader
from turbine_fenicsx.records.output_folder import read_field_parts
from turbine_fenicsx.records.parts import Parts

SIZE = (900, 675)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8c6bb1", "#7f7f7f")


@dataclass(frozen=True)
class Look:
    """How a model is looked at.

    Args:
        times: Which times are drawn, as parts of the whole, 0 to 1.
        view: Direction from the model to the observer.
        up: What points upwards.
        shift: How far each time is moved from the one before, to stand beside it [m].
        trails: Initial positions of points [m], or names of bodies: their paths are drawn.
    """

    times: Sequence[float] = (0.0, 0.25, 0.5, 0.75, 1.0)
    view: tuple[float, float, float] = (0.0, 0.0, 1.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    trails: Sequence[tuple[float, float, float] | str] = ()


def draw(fields: Path, png: Path, look: Look) -> None:
    """Draw a picture from the fields of a run."""
    import pyvista

    parts = read_field_parts(fields)
    reader = FieldReader(str(fields), parts)
    plotter = pyvista.Plotter(off_screen=True, window_size=(2400, 1800), lighting="light kit")
    plotter.set_background("white")
    last = len(reader.times) - 1
    steps = [round(t * last) for t in look.times]
    faint = np.linspace(0.2, 1.0, len(steps)) ** 1.4
    for n, step in enumerate(steps):
        grid = reader.grid(step)
        for k, part in enumerate(parts.parts):
            surface = reader.surface(grid, part, smooth=False)
            if surface is None:
                continue
            surface.clear_data()
            surface = surface.translate(n * np.asarray(look.shift), inplace=False)
            plotter.add_mesh(
                surface,
                color=COLOURS[k % len(COLOURS)],
                opacity=1.0 if any(look.shift) else float(faint[n]),
                ambient=0.3,
                smooth_shading=True,
                split_sharp_edges=True,
            )
    for trail in paths(reader, parts, look.trails, steps[-1]):
        plotter.add_mesh(pyvista.MultipleLines(trail), color="#444444", line_width=4)
    plotter.enable_parallel_projection()
    plotter.view_vector(look.view, viewup=look.up)
    plotter.reset_camera()
    plotter.enable_anti_aliasing("ssaa")
    cropped(np.asarray(plotter.screenshot(return_img=True))).quantize(256).save(png)
    plotter.close()


def cropped(picture: Any) -> Image.Image:
    """A picture without its white margins, in the proportions and the size of all."""
    rows, columns = np.nonzero(picture.min(axis=2) < 250)
    width, height = (1.08 * float(np.ptp(x) + 1) for x in (columns, rows))
    width = max(width, height * SIZE[0] / SIZE[1])
    height = width * SIZE[1] / SIZE[0]
    x, y = 0.5 * (columns.min() + columns.max()), 0.5 * (rows.min() + rows.max())
    box = (round(x - width / 2), round(y - height / 2), round(x + width / 2), round(y + height / 2))
    canvas = Image.new("RGB", (box[2] - box[0], box[3] - box[1]), "white")
    canvas.paste(Image.fromarray(picture), (-box[0], -box[1]))
    return canvas.resize(SIZE, Image.Resampling.LANCZOS)


def paths(reader: FieldReader, parts: Parts, trails: Sequence[Any], last: int) -> list[Any]:
    """Places of bodies, or of the nodes nearest to given points, up to a step, each (n, 3)."""
    found: list[Any] = [[] for _ in trails]
    nodes: list[int] = []
    for step in range(last + 1 if trails else 0):
        grid = reader.grid(step)
        points = np.asarray(grid.points, dtype=float)
        nodes = nodes or [
            -1 if isinstance(t, str) else int(np.linalg.norm(points - t, axis=1).argmin())
            for t in trails
        ]
        for k, trail in enumerate(trails):
            if isinstance(trail, str):
                (part,) = (p for p in parts.parts if p.name == trail)
                middle = np.asarray(reader.surface(grid, part, smooth=False).points).mean(axis=0)
                found[k].append(middle)
            else:
                found[k].append(points[nodes[k]])
    return [np.array(path) for path in found]

"""The part in which a field is largest: whole, and the place itself from near by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import colours
from turbine_fenicsx.postprocessing.field_reader import FieldReader
from turbine_fenicsx.records.parts import Part, Parts

NEAR = 0.1
"""Width of the lower picture relative to the length of the part."""

SHARE = 0.4
"""Height of the upper picture relative to both."""

CAPTION = "close-up,\ncut open in front"
"""Words in the lower picture."""

MARK = "#0b3d91"
"""Colour of the mark."""


@dataclass(frozen=True, eq=False)
class HotSpot:
    """Where a field is largest.

    Args:
        part: The part.
        point: The middle of the cell, shape (3,) [m].
        value: The field there.
        ends: Ends of the part along its length, shape (2, 3) [m]; what carries it is at the first.
        flat: Across the section there, where it is thinnest, to the side of the point, shape (3,).
        normal: Across the wall there, away from the middle of the section, shape (3,).
    """

    part: Part
    point: NDArray[np.float64]
    value: float
    ends: NDArray[np.float64]
    flat: NDArray[np.float64]
    normal: NDArray[np.float64]


def find_hot_spot(grid: Any, reader: FieldReader, parts: Parts, field: str) -> HotSpot:
    """The place where a field of cells is largest in a flexible part.

    Raises:
        InputError: if the cells have no such field.
    """
    if field not in grid.cell_data:
        raise InputError(f"there is no field {field!r} of cells")
    found = []
    for part in parts.parts:
        cells = reader.cells(part)
        if part.stands_on is None and len(cells):
            k = int(np.argmax(grid.cell_data[field][cells]))
            found.append((float(grid.cell_data[field][cells[k]]), part, cells, int(cells[k])))
    if not found:
        raise InputError("there is no flexible part")
    value, part, cells, cell = max(found, key=lambda each: each[0])
    piece = grid.extract_cells(cells)
    x, held = np.asarray(piece.points, dtype=float), np.asarray(piece.point_data["coupling"]) > 0
    middle = x.mean(axis=0)
    along = np.linalg.svd(x - middle, full_matrices=False)[2][0]
    if held.any() and (x[held].mean(axis=0) - middle) @ along > 0.0:
        along = -along
    wall = np.asarray(grid.extract_cells([cell]).points, dtype=float)
    point, s = wall.mean(axis=0), (x - middle) @ along
    section = x[np.abs(s - (point - middle) @ along) < 0.51 * np.ptp((wall - middle) @ along)]
    centre, ends = section.mean(axis=0), middle + np.outer([s.min(), s.max()], along)
    directions = [_find_thinnest(points, along) for points in (section, wall)]
    flat, normal = (d if (point - centre) @ d >= 0.0 else -d for d in directions)
    return HotSpot(part, point, value, ends, flat, normal)


def _find_thinnest(points: NDArray[np.float64], along: NDArray[np.float64]) -> NDArray[np.float64]:
    """Direction across an axis in which points differ least, shape (3,)."""
    across = points - points.mean(axis=0)
    across -= np.outer(across @ along, along)
    values, vectors = np.linalg.eigh(across.T @ across + np.outer(along, along) * np.sum(across**2))
    found: NDArray[np.float64] = vectors[:, int(np.argmin(values))]
    return found


def draw_hot_spot(
    reader: FieldReader, parts: Parts, step: int, field: str, text: str, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """The picture of one time, shape (height, width, 3).

    Args:
        text: Lines above it.
        size: Width and height [pixels].
    """
    import pyvista

    grid = reader.grid(step)
    spot = find_hot_spot(grid, reader, parts, field)
    plotter = pyvista.Plotter(
        off_screen=True,
        window_size=size,
        shape=(2, 1),
        row_weights=[SHARE, 1.0 - SHARE],
        lighting="light kit",
        border=False,
    )
    length = float(np.linalg.norm(spot.ends[1] - spot.ends[0]))
    piece = grid.extract_cells(reader.cells(spot.part))
    depth = (piece.cell_centers().points - spot.point) @ spot.normal
    cut = piece.extract_cells(depth < 1e-6 * length)  # without what is in front of the place
    for row, (shown, focus, width, towards) in enumerate(
        [
            (piece, spot.ends.mean(axis=0), 1.06 * length, spot.flat),
            (cut, spot.point, NEAR * length, spot.normal),
        ]
    ):
        plotter.subplot(row, 0)
        _add_part(plotter, shown, field, spot, size, close=row == 1)
        height = size[1] * (SHARE if row == 0 else 1.0 - SHARE)
        _look(plotter.camera, spot.ends, focus, towards, 0.5 * width * height / size[0])
    texts = [(text, (0.02, 0.72), 64), (CAPTION, (0.02, 0.04), 90)]
    for row, (words, place, lines) in enumerate(texts):
        plotter.subplot(row, 0)
        font = {"font_size": round(size[1] / lines), "color": "black"}
        plotter.add_text(words, place, viewport=True, **font)
    plotter.enable_anti_aliasing("ssaa")
    plotter.render()
    image: NDArray[np.uint8] = plotter.screenshot(return_img=True)
    plotter.close()
    return image


def _add_part(
    plotter: Any, piece: Any, field: str, spot: HotSpot, size: tuple[int, int], close: bool
) -> None:
    """Add cells in colours, and the mark.

    Args:
        close: Whether the edges of the mesh and the legend are shown.
    """
    title, surface = colours.label(field), piece.extract_surface()
    values = colours.to_scalars(field, surface[field])
    surface.clear_data()
    surface.cell_data[title] = values
    plotter.set_background("white")
    plotter.add_mesh(
        surface,
        scalars=title,
        cmap=colours.colour_map(),
        clim=(0.0, max(spot.value * colours.to_scalars(field, np.ones(1))[0], 1e-30)),
        ambient=0.4,
        diffuse=0.65,
        show_edges=close,
        edge_color="#333333",
        line_width=0.6,
        show_scalar_bar=close,
        scalar_bar_args=_place_legend(title, size),
    )
    plotter.add_point_labels(
        [spot.point],
        [f"{spot.value:.3g}"],
        font_size=round(size[1] / 36),
        point_size=size[1] / 60,
        point_color=MARK,
        text_color=MARK,
        render_points_as_spheres=True,
        always_visible=True,
        shape_opacity=0.6,
        margin=4,
    )


def _look(
    camera: Any,
    ends: NDArray[np.float64],
    focus: NDArray[np.float64],
    towards: NDArray[np.float64],
    half: float,
) -> None:
    """Look at a part from one side, what carries it on the left.

    Args:
        ends: Of the part, shape (2, 3) [m].
        focus: Middle of the picture, shape (3,) [m].
        towards: Direction to who looks, shape (3,).
        half: Half of the height that is in the picture [m].
    """
    depth = float(np.linalg.norm(ends[1] - ends[0]))
    camera.focal_point = focus
    camera.position = focus + 2.0 * depth * towards
    camera.up = np.cross(towards, (ends[1] - ends[0]) / depth)
    camera.enable_parallel_projection()
    camera.parallel_scale = half
    camera.clipping_range = (0.1 * depth, 4.0 * depth)


def _place_legend(title: str, size: tuple[int, int]) -> dict[str, Any]:
    """Place and looks of the legend, below."""
    return {
        "title": title,
        "vertical": False,
        "position_x": 0.3,
        "position_y": 0.02,
        "width": 0.4,
        "height": 0.12,
        "font_family": "arial",
        "title_font_size": round(size[1] / 42),
        "label_font_size": round(size[1] / 45),
        "color": "black",
        "n_labels": 5,
        "fmt": "%.3g",
        "unconstrained_font_size": True,
    }

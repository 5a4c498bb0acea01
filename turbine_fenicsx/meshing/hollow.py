"""Structured quadratic hexahedra of a hollow blade: a ring of wall cells, webs, a plate at the tip.

Under each web a strip of the ring is as wide as the web, and the cells of the web share its inner
nodes, so that all cells hang together by faces.

Lines along the span are closer at the root: a clamped tube bends its wall within some sqrt(R t) of
it, which long elements miss; that is all that they cost in bending. So the first elements are about
twice that long.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.block import BladeBlock, split_boundary
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow_ends import (
    HEXAHEDRON,
    TIP,
    Cells,
    add_tip_row,
    cells_of_grid,
    mean_of_cells,
    mesh_tip,
    mesh_web,
)
from turbine_fenicsx.meshing.hollow_lines import Columns, divide_sections
from turbine_fenicsx.meshing.hollow_section import Wall, build_wall
from turbine_fenicsx.meshing.hollow_shape import Contours, HollowShape
from turbine_fenicsx.meshing.quality import DEGENERATE, scaled_jacobian

_STEEPEST = 6.0  # the first element is at least this part of the mean
_REACH = 0.04  # part of the span over which elements grow to their full length
_CLOSEST = 0.4  # two lines stay apart by this part of the elements that were wanted between them
_TOLERANCE = 1e-6  # span fractions that differ by less are one
_BLUNT = 0.02  # a blade ends where its outline is this part of the longest one


def span_lines(shape: HollowShape, n_span: int) -> Array:
    """Return where the elements of a hollow blade meet along the span.

    Both ends of every web are lines; so are the other breaks of the shape where there are elements
    enough. A blade that runs out into a point ends just before it, without slivers.

    Args:
        n_span: Number of elements along the span.

    Returns:
        Rising span fractions from 0, shape (n_span + 1,) [-].
    """
    end = _blunt_end(shape)
    ends = sorted(
        {round(x / _TOLERANCE) * _TOLERANCE: x for w in shape.webs for x in (w.start, w.end)}
    )
    ends = [x for x in ends if _TOLERANCE < x < end - _TOLERANCE]
    fine = np.linspace(0.0, end, 4001)
    progress = _element_count(shape, fine, n_span)
    pinned = _pin_ends(np.interp(ends, fine, progress), ends, n_span)
    pinned = {0: 0.0, n_span: end} | pinned
    for at in shape.breaks:
        _pin_break(pinned, at, float(np.interp(at, fine, progress)), fine, progress)
    number = sorted(pinned)
    ideal = np.interp([pinned[k] for k in number], fine, progress)
    return np.interp(np.interp(np.arange(n_span + 1), number, ideal), progress, fine)


def _blunt_end(shape: HollowShape) -> float:
    """Span fraction where the blade ends: 1, or where its outline has become tiny."""
    s = np.linspace(0.0, 1.0, 2001)
    contour = shape.surface(s[:, None], np.linspace(0.0, 1.0, 33))
    perimeter = np.linalg.norm(np.diff(contour, axis=1), axis=2).sum(axis=1)
    wide = np.flatnonzero(perimeter >= _BLUNT * perimeter.max())
    return float(s[wide[-1]])


def _element_count(shape: HollowShape, s: Array, n_span: int) -> Array:
    """Number of elements between the root and span fractions s, not rounded, shape of s."""
    arcs = np.linspace(0.0, 1.0, 129)
    root = shape.surface(np.zeros(1), arcs)
    radius = np.linalg.norm(np.diff(root, axis=0), axis=1).sum() / (2.0 * np.pi)
    layer = np.sqrt(radius * float(np.mean(shape.wall(np.zeros(1), arcs)))) / shape.length
    steepness = np.clip(1.0 / (2.0 * layer * n_span), 1.0, _STEEPEST)
    count = s + (steepness - 1.0) * _REACH * (1.0 - np.exp(-s / _REACH))
    scaled: Array = n_span * count / count[-1]
    return scaled


def _pin_ends(progress: Array, ends: Sequence[float], n_span: int) -> dict[int, float]:
    """Give each end of a web the nearest line that is free."""
    if len(ends) > n_span - 1:
        raise MeshError(
            f"mesh.span = {n_span}: webs begin and end at {len(ends)} places inside the span, "
            f"which takes at least {len(ends) + 1} elements"
        )
    numbers: list[int] = []
    for i, count in enumerate(progress):
        lowest = numbers[-1] + 1 if numbers else 1
        numbers.append(max(lowest, min(round(count), n_span - len(ends) + i)))
    return dict(zip(numbers, ends, strict=True))


def _pin_break(
    pinned: dict[int, float], at: float, count: float, fine: Array, progress: Array
) -> None:
    """Move the nearest line to a break, unless that would make an element too short."""
    number = round(count)
    if number in pinned:
        return
    below = max(k for k in pinned if k < number)
    above = min(k for k in pinned if k > number)
    first, last = np.interp([pinned[below], pinned[above]], fine, progress)
    if count - first > _CLOSEST * (number - below) and last - count > _CLOSEST * (above - number):
        pinned[number] = at


@dataclass(frozen=True)
class HollowBlock(BladeBlock):
    """Nodes and quadratic hexahedra of a hollow blade, one cell through the wall.

    The columns of the Jacobian are the axes of the wall. The axes of each reference cell point
    along the span, around the section and through the wall outwards. Around means towards rising
    contour fractions, in a web from suction to pressure side; outwards means in a web towards the
    leading edge. In the plate of a closed tip they point from suction to pressure side, to the
    leading edge, and along the span.

    Attributes:
        parts: Names of panels, webs, and the plate of a closed tip.
        part: Index in ``parts`` of each cell, shape (n_cells,).
        span: First and last span fraction of each cell, shape (n_cells, 2) [-].
        arc: First and last contour fraction of each cell of a panel, and on the suction side of the
            tip; of a web, fractions of its height from suction to pressure side;
            shape (n_cells, 2) [-].
        wanted: Thickness of the wall that each cell stands for, shape (n_cells,) [m].
        thickness: Thickness that the cell has; it is smaller where walls would cross,
            shape (n_cells,) [m].
    """

    parts: tuple[str, ...]
    part: IntArray
    span: Array
    arc: Array
    wanted: Array
    thickness: Array

    @property
    def cell_data(self) -> dict[str, Array]:
        """The attributes of each cell, both ends of its ranges apart, shape (n_cells,) each."""
        return {
            "part": self.part.astype(float),
            "span_start": self.span[:, 0],
            "span_end": self.span[:, 1],
            "arc_start": self.arc[:, 0],
            "arc_end": self.arc[:, 1],
            "wanted": self.wanted,
            "thickness": self.thickness,
        }


_ATTEMPTS, _THINNER = 12, 0.7  # how often, and to what part, walls of inverted cells are thinned
_SAMPLES = np.array([0.125, 0.375, 0.625, 0.875])  # of a cell along and around


def mesh_hollow(shape: HollowShape, n_span: int, n_around: int) -> HollowBlock:
    """Mesh a hollow blade with one quadratic hexahedron through the wall.

    The skin of the block is the outer surface alone; inner faces and the end at the tip are in no
    group. A plate closes the tip if the shape says so and no web reaches it.

    Args:
        shape: The blade.
        n_span: Number of elements along the span.
        n_around: Number of elements around a section, those of the webs not counted.

    Returns:
        The mesh.

    Raises:
        MeshError: if there are too few elements for the webs, webs cross, or a cell is inverted.
    """
    lines = span_lines(shape, n_span)
    closed = shape.closed_tip and all(web.end < lines[-1] for web in shape.webs)
    if closed:
        lines = add_tip_row(shape, lines)
    contours = Contours.of(shape, _with_middles(lines))
    columns = divide_sections(contours, n_around)
    b = _with_middles(columns.b.T).T[:, :-1]
    inside = b.copy()
    inside[:, ::2] = columns.inside[:, :-1]
    ring = np.arange(3 * b.size).reshape(*b.shape, 3)
    ring = np.concatenate([ring, ring[:, :1]], axis=1)
    wall = _unfold(contours, b, inside, columns, ring)
    points = wall.nodes.reshape(-1, 3)
    thickness = np.hstack([wall.thickness, wall.thickness[:, :1]])
    groups = [_ring_cells(contours, columns, lines, ring, thickness)]

    length = float(np.linalg.norm(np.diff(columns.outline, axis=1), axis=2).sum(axis=1).mean())
    for web, (top, bottom) in enumerate(columns.strips):
        ends = ring[:, 2 * top : 2 * top + 3, 0], ring[:, 2 * bottom : 2 * bottom + 3, 0][:, ::-1]
        inner, cells = mesh_web(shape, web, lines, points, ends, length / n_around)
        points = np.concatenate([points, inner])
        groups.append(cells)
    parts = shape.panels + tuple(web.name for web in shape.webs)
    if closed:
        arcs = contours.to_arc(columns.b)[-1]
        inner, cells = mesh_tip(shape, len(parts), lines, arcs, ring, points)
        points, parts = np.concatenate([points, inner]), (*parts, TIP)
        groups.append(cells)
    block = _assemble(shape, parts, points, groups)
    _refuse_inverted(block, n_around)
    return block


def _unfold(contours: Contours, b: Array, inside: Array, columns: Columns, ring: IntArray) -> Wall:
    """The wall, thinner where its cells would be inverted: at narrow faces of trailing edges."""
    share, cells = np.ones(b.shape), cells_of_grid(ring)
    wall = build_wall(contours, b, inside, columns.outline)
    for _ in range(_ATTEMPTS):
        points = wall.nodes.reshape(-1, 3)
        quality = scaled_jacobian(points, cells.reshape(-1, 27), HEXAHEDRON)
        folded = np.unique(cells.reshape(-1, 27)[quality <= DEGENERATE] // 3)
        if not len(folded):
            break
        share.ravel()[folded] *= _THINNER
        wall = build_wall(contours, b, inside, columns.outline, share)
    return wall


def _refuse_inverted(block: HollowBlock, n_around: int) -> None:
    """Raise MeshError if a cell is inverted."""
    quality = scaled_jacobian(block.points, block.cells, block.reference)
    worst = int(np.argmin(quality))
    if not quality[worst] > DEGENERATE:
        first, last = block.span[worst]
        raise MeshError(
            f"mesh.around = {n_around}: {np.count_nonzero(~(quality > DEGENERATE))} cells of the "
            f"blade are inverted, the worst in the {block.parts[block.part[worst]]!r} between "
            f"stations {first:.4g} and {last:.4g} with a scaled Jacobian of {quality[worst]:.2g}; "
            "try other numbers of elements, or thinner walls"
        )


def _with_middles(values: Array) -> Array:
    """Values with the means of neighbours between them, along the first axis."""
    fine = np.empty((2 * len(values) - 1, *values.shape[1:]))
    fine[::2], fine[1::2] = values, (values[:-1] + values[1:]) / 2.0
    return fine


def _ring_cells(
    contours: Contours, columns: Columns, lines: Array, ring: IntArray, thickness: Array
) -> Cells:
    """Cells of the wall."""
    m, n = len(lines) - 1, len(columns.panel)
    arcs = contours.to_arc(columns.b)[1::2]
    span = np.stack([lines[:-1], lines[1:]], axis=1)
    arc = np.stack([arcs[:, :-1], arcs[:, 1:]], axis=2)
    s = span[:, :1] + np.diff(span, axis=1) * _SAMPLES
    a = arc[..., :1] + np.diff(arc, axis=2) * _SAMPLES
    samples = contours.shape.wall(s[:, None, :, None], a[:, :, None, :])
    return Cells(
        cells=cells_of_grid(ring).reshape(-1, 27),
        part=np.tile(columns.panel, m),
        span=np.repeat(span, n, axis=0),
        arc=arc.reshape(-1, 2),
        wanted=samples.mean(axis=(2, 3)).ravel(),
        thickness=mean_of_cells(thickness).ravel(),
    )


def _assemble(
    shape: HollowShape, parts: tuple[str, ...], points: Array, groups: list[Cells]
) -> HollowBlock:
    """Block of the cells of ring, webs and tip."""
    joined = Cells.join(groups)
    faces = HEXAHEDRON.faces
    lattice = HEXAHEDRON.lattice[faces]
    outer = faces[(lattice[..., 2] == 2).all(axis=1)][0]
    first = faces[(lattice[..., 0] == 0).all(axis=1)][0]
    skin = groups[0].cells[:, outer]
    root, _ = split_boundary(points, joined.cells[:, first], shape.hub_radius)
    return HollowBlock(
        reference=HEXAHEDRON,
        points=points,
        cells=joined.cells,
        root=root,
        skin=skin,
        parts=parts,
        part=joined.part,
        span=joined.span,
        arc=joined.arc,
        wanted=joined.wanted,
        thickness=joined.thickness,
    )

"""Structured quadratic hexahedra of a hollow blade: a ring of wall cells, webs, a plate at the tip.

Under each web a strip of the ring is as wide as the web, and the cells of the web share its inner
nodes, so that all cells hang together by faces.
"""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.block import split_boundary
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow_block import HollowBlock
from turbine_fenicsx.meshing.hollow_cells import HEXAHEDRON, Cells, cells_of_grid, mean_of_cells
from turbine_fenicsx.meshing.hollow_columns import Columns, divide_sections
from turbine_fenicsx.meshing.hollow_contour import Contours
from turbine_fenicsx.meshing.hollow_section import Wall, build_wall
from turbine_fenicsx.meshing.hollow_shape import HollowShape
from turbine_fenicsx.meshing.hollow_span import span_lines
from turbine_fenicsx.meshing.hollow_tip import TIP, add_tip_row, mesh_tip
from turbine_fenicsx.meshing.hollow_webs import mesh_web
from turbine_fenicsx.meshing.quality import DEGENERATE, scaled_jacobian

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

"""Shells of eight nodes along the middle of the walls of a blade.

Each has its own layers and the axes along which they lie: along the span,
around the section, outwards. Webs stand straight between nodes of the shell. A blade is anything
that has the methods of `layup.Blade` that are called here.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

DEEPEST = 0.3
"""Greatest depth of the middle of a wall near the trailing edge, over the blade's thickness."""

GAP = 0.5
"""Part of the chord from which that holds."""


@dataclass(frozen=True)
class Shells:
    """A mesh.

    Attributes:
        stations: Span fractions of the rows of nodes at the ends of cells, shape (m + 1,).
        nodes: Shape (n, 3) [m].
        cells: Nodes of each, counted from 0, shape (k, 8).
        plies: Materials and thicknesses of each cell, from outside inwards.
        along: Direction of the span in each cell, shape (k, 3).
        across: Direction around the section, shape (k, 3).
        rows: Nodes of the skin in each row of nodes, with the lengths that they stand for [m].
        whole: All nodes in each row of nodes, those between the ends of cells too.
        frames: Points of the axis [m] and axes of the section of each of these.
        mass: Of the shells [kg].
    """

    stations: np.ndarray
    nodes: np.ndarray
    cells: np.ndarray
    plies: list
    along: np.ndarray
    across: np.ndarray
    rows: list
    whole: list
    frames: list
    mass: float

    @property
    def axis(self):
        """Points of the axis at the stations, shape (m + 1, 3) [m]."""
        return np.array([origin for origin, _ in self.frames[::2]])


def make_shells(blade, rows, around, high=5, face=1):
    """Mesh a blade.

    Args:
        blade: The blade.
        rows: Number of rows of cells along the span.
        around: Number of cells around the section, about; each panel has one at least.
        high: Number of cells over the height of a web.
        face: Number of cells of the trailing edge's face.
    """
    growing = _Growing(blade, np.linspace(0.0, 1.0, 2 * rows + 1))
    lines = _share(blade, around)
    growing.add_skin(lines, face)
    for web in range(len(blade.webs)):
        growing.add_web(web, lines, high)
    s, nodes, cells = growing.s, np.array(growing.nodes), np.array(growing.cells)
    x = nodes[cells]
    along, across = x[:, 5] - x[:, 7], x[:, 6] - x[:, 4]
    area = np.linalg.norm(np.cross(along, across), axis=1)
    rho = [sum(t * blade.materials[m]["rho"] for m, t in stack) for stack in growing.plies]
    skin = [_with_lengths(nodes, numbers) for numbers in growing.skin[::2]]
    frames = [blade.axes(at) for at in s]
    mass = float(area @ rho)
    made = growing.plies, along, across, skin, growing.whole, frames, mass
    return Shells(s[::2], nodes, cells, *made)


class _Growing:
    """Nodes and cells that come one after the other.

    Places are counted along the span and around the section, two for each cell.
    """

    def __init__(self, blade, s):
        self.blade, self.s = blade, s
        self.nodes, self.cells, self.plies, self.number = [], [], [], {}
        self.whole, self.skin = [[] for _ in s], []

    def add_skin(self, lines, face):
        """Rows of the shell."""
        count = int(lines[:, 1].sum())
        loop = 2 * (count + face)
        arcs = np.array([_arcs(self.blade, s, lines, face) for s in self.s])
        ends = [
            _middle(self.blade, s, row, 2 * count)
            for s, row in zip(self.s[::2], arcs[::2], strict=True)
        ]
        for i in range(len(self.s)):
            # cells are straight along the span: where a face opens quickly, curved ones would fold
            points = 0.5 * (ends[i // 2] + ends[(i + 1) // 2])
            for j in range(0, loop, 1 + i % 2):
                self.number[i, j] = self._node(i, points[j])
            self.skin.append([self.number[i, j] for j in range(0, loop, 1 + i % 2)])
        for i in range(0, len(self.s) - 1, 2):
            for j in range(0, loop, 2):
                plies = self.blade.plies(self.s[i + 1], arcs[i + 1][j + 1])
                self._cell(self.number, i, j, (j + 2) % loop, plies)

    def add_web(self, web, lines, high):
        """Rows of a web, where it has layers."""
        first, last, _ = self.blade.webs[web]
        rows = [
            i
            for i in range(0, len(self.s) - 1, 2)
            if first <= self.s[i] + 1e-9 <= self.s[i + 2] <= last + 1e-9
            and self.blade.web_plies(self.s[i + 1], web)
        ]
        feet = [_foot(lines, web, end) for end in (0, 1)]
        at = {}
        for i in range(rows[0], rows[-1] + 3) if rows else ():
            ends = [self.number[i, foot] for foot in feet]
            at[i, 0], at[i, 2 * high] = ends
            for h in range(1 + i % 2, 2 * high, 1 + i % 2):
                part = h / (2.0 * high)
                point = (1.0 - part) * self.nodes[ends[0]] + part * self.nodes[ends[1]]
                at[i, h] = self._node(i, point)
        for i in rows:
            for h in range(0, 2 * high, 2):
                self._cell(at, i, h, h + 2, self.blade.web_plies(self.s[i + 1], web))

    def _node(self, i, point):
        self.nodes.append(point)
        self.whole[i].append(len(self.nodes) - 1)
        return len(self.nodes) - 1

    def _cell(self, number, i, j, k, plies):
        corner = [(i, j), (i + 2, j), (i + 2, k), (i, k)]
        middle = [(i + 1, j), (i + 2, j + 1), (i + 1, k), (i, j + 1)]
        self.cells.append([number[place] for place in corner + middle])
        self.plies.append(plies)


def _share(blade, around):
    """Where cells begin and end: number of a panel, cells, feet at the panel's parts, as rows.

    Panels are cut where webs stand.
    """
    at = blade.panels(0.4)
    pieces = []
    for panel in range(len(at) - 1):
        feet = sorted(
            (float(np.mean(places[k][2])), web, k)
            for web, (_, _, places) in enumerate(blade.webs)
            for k in (0, 1)
            if places[k][0] == panel
        )
        ends = [0.0, *(f[0] for f in feet), 1.0]
        for n, (a, b) in enumerate(pairwise(ends)):
            length = (b - a) * (at[panel + 1] - at[panel])
            cells = max(1, round(length * around))
            before = feet[n - 1][1:] if n else (-1, -1)
            pieces.append((panel, cells, *before))
    return np.array(pieces)


def _foot(lines, web, end):
    """Number of the line of nodes on which an edge of a web stands."""
    k = next(k for k, row in enumerate(lines) if tuple(row[2:]) == (web, end))
    return 2 * int(lines[:k, 1].sum())


def _arcs(blade, s, lines, face):
    """Arc of each line of nodes at s; those on the face are beyond the last corner."""
    at = blade.panels(s)
    starts = [at[0]]
    for panel, _, web, end in lines[1:]:
        if web < 0:
            starts.append(at[panel])
        else:
            _, grid, part = blade.webs[web][2][end]
            starts.append(at[panel] + np.interp(s, grid, part) * (at[panel + 1] - at[panel]))
    starts.append(at[-1])
    pieces = [
        np.linspace(a, b, 2 * n, endpoint=False)
        for a, b, n in zip(starts[:-1], starts[1:], lines[:, 1], strict=True)
    ]
    return np.concatenate([*pieces, np.linspace(at[-1], 1.0 + at[0], 2 * face, endpoint=False)])


def _middle(blade, s, arcs, corner):
    """Nodes of a row: points of the outline, moved inwards by half the wall, (n, 3) [m]."""
    outline, at = blade.outline(s)
    closed = np.vstack([outline, outline[:1]])
    along = np.append(at, 1.0 + at[0])
    points = np.column_stack([np.interp(arcs, along, closed[:, k]) for k in (0, 1)])
    tangent = np.gradient(outline, at, axis=0)
    t = np.column_stack([np.interp(arcs, at, tangent[:, k]) for k in (0, 1)])
    # nodes on the face stand between its corners
    t[corner + 1 :] = 0.0
    inward = np.column_stack([t[:, 1], -t[:, 0]])
    inward /= np.maximum(np.linalg.norm(inward, axis=1), 1e-9)[:, None]
    walls = np.array(
        [sum(x for _, x in blade.plies(s, arcs[j + 1])) for j in range(0, len(arcs), 2)]
    )
    depth = np.repeat(0.5 * walls, 2)
    depth[::2] = 0.25 * (walls + np.roll(walls, 1))
    depth *= blade.inset / blade.chord(s)
    depth[[0, corner]] = 0.5 * walls[[0, corner // 2 - 1]] * blade.inset / blade.chord(s)
    if blade.inset:
        depth = np.minimum(depth, _room(outline, points))
    points = points + depth[:, None] * inward
    corners = points[corner], points[0]
    part = np.linspace(0.0, 1.0, len(arcs) - corner, endpoint=False)[:, None]
    points[corner:] = (1.0 - part) * corners[0] + part * corners[1]
    return blade.place(s, points)


def _room(outline, points):
    """Greatest depth of the middle of a wall at points, over the chord."""
    nose = outline[:, 1].argmin()
    sides = [
        np.interp(points[:, 1], outline[: nose + 1][::-1, 1], outline[: nose + 1][::-1, 0]),
        np.interp(points[:, 1], outline[nose:, 1], outline[nose:, 0]),
    ]
    return np.where(points[:, 1] > GAP, DEEPEST * (sides[0] - sides[1]), np.inf)


def _with_lengths(nodes, numbers):
    x = nodes[numbers]
    step = np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1)
    return np.array(numbers), 0.5 * (step + np.roll(step, 1))

"""From the nodes of a body to the motion of sections, and from their loads back to the nodes.

Node a of the mesh has the weight w_a = A_a N(z_a) at a station, with the skin area A_a of the node
and the hat function N of the station along the axis. With their sum W, and the arms R_a of the
nodes from the centre of the station in the mesh, the sums

    H_0 x = sum w_a x_a/W,      H_j x = sum w_a R_aj x_a

are constant rows over the nodes of the body, points or vectors, and with B_j = H_j x, A the
rotation nearest to B, and U = A^T B

    x_i = H_0 x,    v_i = H_0 x',    omega_i = J^-1 sum_j A_j x H_j x',    J = tr(U) 1 - B A^T.

The forces on the nodes are the transpose of that,

    H_0^T F + sum_j H_j^T (J^-1 M) x A_j.

So the power is F.v_i + M.omega_i. If the body turns with w, omega_i = J^-1 sum_j A_j x (w x B_j)
is w, so that the resultants are F and M about x_i. All three hold to round-off.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

from mpi4py import MPI

import numpy as np
import numpy.typing as npt
from scipy import sparse

from turbine_fenicsx.forces.section_loads import SectionLoads, SectionMotion, StationLine
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import skew_rows
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.body_nodes import BodyNodes
from turbine_fenicsx.system.mesh_areas import find_areas, positions_of
from turbine_fenicsx.system.section_turns import compile_section_turns

SLENDEREST = 1e-6
"""Smallest moment of inertia of a section, relative to the largest, below which it is a line."""

SHRINKAGE = 0.9
"""Factor of the number of stations, if nodes are too far apart for them."""

Single = npt.NDArray[np.float32]
"""An array in single precision."""


class Line(NamedTuple):
    """The stations of a line.

    Attributes:
        copy: Number of the copy of the body.
        nodes: Those of the nodes of the transfer that have a weight; a slice for dense rows.
        rows: H_0, H_1, H_2, H_3 of each station over these, shape (4 stations, k).
        back: The transpose of the rows.
        stations: Their places among all.
    """

    copy: int
    nodes: IntArray | slice
    rows: Array | sparse.csr_matrix
    back: Array | sparse.csr_matrix
    stations: slice


class SectionTransfer:
    """Rows of stations. Collective, as are all methods but `forces`.

    Stations that are closer than the nodes of the mesh lie between wider sections, and their rows
    are linear between the rows of these, which keeps all that is said above.

    Args:
        model: The body.
        loads: The stations on it.

    Attributes:
        nodes: Owned nodes that have a weight, shape (k,).
    """

    def __init__(self, model: BodyNodes, loads: SectionLoads) -> None:
        self._comm, self._turns = model.comm, compile_section_turns(model.comm)
        found = [_find_rows(model, loads.name, line) for line in loads.lines]
        rows, *others = zip(*found, strict=True)
        counts, moments, self._initial = map(np.concatenate, others)
        check_stations(loads, counts, moments)
        used = [
            _find_nodes(model, line.copy, of_line)
            for line, of_line in zip(loads.lines, rows, strict=True)
        ]
        self.nodes: IntArray = np.unique(np.concatenate(used))
        ends, dense = np.cumsum([line.size for line in loads.lines]), model.dense_block > 0
        self._lines = [
            _make_line(line.copy, np.searchsorted(self.nodes, own), of_line[:, own], end, dense)
            for line, own, of_line, end in zip(loads.lines, used, rows, ends, strict=True)
        ]
        turns = [model.body.placements[line.copy].frame()[0] for line in loads.lines]
        sizes = [line.size for line in loads.lines]
        self._turn_back = np.repeat(np.array(turns), sizes, axis=0).swapaxes(1, 2)

    def motion(self, x: Array, v: Array) -> SectionMotion:
        """How the sections move.

        Args:
            x: Values of the nodes, shape (k, 3) [m].
            v: Their rates, shape (k, 3) [m/s].
        """
        both, sums = np.concatenate([x, v], axis=1), np.empty((len(self._initial), 4, 6))
        for line in self._lines:
            sums[line.stations] = (line.rows @ both[line.nodes]).reshape(-1, 4, 6)
        sums = sum_over_ranks(self._comm, sums)
        self._axes, self._inverse, omega = self._turns.find(sums)
        return SectionMotion(
            sums[:, 0, :3], self._axes @ self._turn_back, sums[:, 0, 3:], omega, self._initial
        )

    def forces(self, F: Array, M: Array) -> Array:
        """Forces on the nodes for loads on the sections of the last motion, shape (k, 3) [N].

        Args:
            F: Forces, shape (n, 3) [N].
            M: Moments about the centres, shape (n, 3) [N m].
        """
        on_rows = self._turns.find_rows(F, M, self._axes, self._inverse)
        f = np.zeros((len(self.nodes), 3))
        for line in self._lines:
            f[line.nodes] += line.back @ on_rows[line.stations].reshape(-1, 3)
        return f

    def add_slopes(self, slopes: Array, out: Array) -> None:
        """Add the derivatives of the forces, of those of the loads at the last motion.

        With P_i, which takes increments of the nodes to those of section i, this is the sum of
        P_i^T Q_i P_i for each copy, of a small body. It is found in single precision: tangents
        need no more.

        Args:
            slopes: Q, shape (stations, 6, 6), see `BoundSectionLoads.find_slopes`.
            out: For each copy a block of its nodes, which this rank owns, shape (copies, 3 n, 3 n).
        """
        single = np.float32
        # J^-1 sum_j A_j x H_j
        turns = np.stack([skew_rows(self._axes[:, :, j]) for j in range(3)], axis=3)
        turns = np.einsum("nab,nbcj->nacj", self._inverse, turns).astype(single)
        slopes = slopes.astype(single)
        for line, (H, P) in zip(self._lines, self._motions, strict=True):
            spins = turns[line.stations].reshape(-1, 9, 3) @ H
            P[:, 3:] = spins.reshape(-1, 3, 3, H.shape[2]).swapaxes(2, 3)
            k = 3 * H.shape[2]
            moved = (slopes[line.stations] @ P.reshape(-1, 6, k)).reshape(-1, k)
            out[line.copy] += P.reshape(-1, k).T @ moved

    @cached_property
    def _motions(self) -> list[tuple[Single, Single]]:
        """Rows H_j of each line, and P_i without rotations."""
        found = []
        for line in self._lines:
            H = line.rows.reshape(-1, 4, line.rows.shape[1]).astype(np.float32)
            P = np.zeros((len(H), 6, H.shape[2], 3), dtype=np.float32)
            for i in range(3):
                P[:, i, :, i] = H[:, 0]
            found.append((H[:, 1:], P))
        return found


def _find_rows(
    model: BodyNodes, name: str, line: StationLine
) -> tuple[sparse.csr_matrix, Array, Array, Array]:
    """Rows of a line, shape (4 stations, n_owned), numbers of nodes, sum w R R^T, and centres."""
    R, t = model.body.placements[line.copy].frame()
    areas, X = find_areas(model.space, name, line.facets), positions_of(model.space)
    stations = np.asarray(line.stations, dtype=float)

    def measure(wider: StationLine) -> tuple[StationSums, tuple[IntArray, IntArray, Array]]:
        shares = share_out(wider, t + X @ R.T, areas)
        return sum_stations(model.comm, wider.size, X, shares), shares

    sums, shares = own = measure(line)
    number = line.size
    while number > 2 and np.any(find_flat(sums.counts, sums.moments)):
        # stations that are closer than the nodes lie between wider ones
        number = max(2, int(SHRINKAGE * number))
        wider = np.linspace(stations[0], stations[-1], number)
        sums, shares = measure(replace(line, stations=wider))
    if np.any(find_flat(sums.counts, sums.moments)):
        sums, shares = own
        number = line.size
    rows = _make_rows(model, line.copy, sums, shares)
    counts, _, centres, moments = sums
    if number < line.size:
        share = np.array([np.interp(stations, wider, e) for e in np.eye(number)]).T
        rows = sparse.kron(share, np.eye(4), "csr") @ rows
        moments, centres = (np.tensordot(share, x, 1) for x in (moments, centres))
        counts = np.full(line.size, counts.min())
    return rows, counts, moments, t + centres @ R.T


def _make_rows(
    model: BodyNodes, copy: int, sums: StationSums, shares: tuple[IntArray, IntArray, Array]
) -> sparse.csr_matrix:
    """Rows H_0, H_1, H_2, H_3 of stations over the owned nodes of a body. Collective."""
    nodes, station, w = shares
    arms = positions_of(model.space)[nodes] - sums.centres[station]
    values = w[:, None] * np.column_stack([1.0 / sums.total[station], arms])
    first = model.space.dofmap.index_map.local_range[0]
    found = model.comm.allgather((first + nodes, station, values))
    nodes, station, values = map(np.concatenate, zip(*found, strict=True))
    every, column = np.unique(nodes, return_inverse=True)
    places = (4 * station[:, None] + np.arange(4)).ravel(), np.repeat(column, 4)
    shape = (4 * len(sums.counts), len(every))
    return model.rows(copy, every, sparse.csr_matrix((values.ravel(), places), shape=shape))


def _find_nodes(model: BodyNodes, copy: int, rows: sparse.csr_matrix) -> IntArray:
    """Owned nodes with a weight; all of its copy of a body whose nodes all move each other."""
    n = model.dense_block // 3
    if n:
        return np.arange(copy * n, copy * n + n)[: model.n_owned]
    nodes: IntArray = np.unique(rows.nonzero()[1])
    return nodes


def _make_line(copy: int, nodes: IntArray, rows: sparse.csr_matrix, end: int, dense: bool) -> Line:
    """The stations of a line that ends before a number."""
    stations = slice(end - rows.shape[0] // 4, end)
    if dense:
        first = int(nodes[0]) if nodes.size else 0
        array = rows.toarray()
        return Line(copy, slice(first, first + nodes.size), array, array.T, stations)
    return Line(copy, nodes, rows, rows.T.tocsr(), stations)


def check_stations(loads: SectionLoads, counts: Array, moments: Array) -> None:
    """Raise a ModelError for a station that `find_flat` finds.

    Args:
        counts: Number of nodes of each, shape (n,).
        moments: Sums w r r^T of the arms of these from their centre, shape (n, 3, 3).
    """
    flat = find_flat(counts, moments)
    if np.any(flat):
        k = int(np.argmax(flat))
        for line in loads.lines:
            if k < line.size:
                break
            k -= line.size
        place = np.asarray(line.stations, dtype=float)[k]
        raise ModelError(
            f"station {k + 1} of {loads.name!r} at {place:g} m has no three nodes of the skin "
            "that are not on a line: take fewer stations, or a finer mesh"
        )


def find_flat(counts: Array, moments: Array) -> npt.NDArray[np.bool_]:
    """Which stations are empty or have all nodes on a line; arguments as of `check_stations`."""
    few: npt.NDArray[np.bool_] = counts < 3.0
    if np.any(few):
        return few
    spread = np.linalg.eigvalsh(moments)
    thin: npt.NDArray[np.bool_] = spread[:, 1] <= SLENDEREST * spread[:, 2]
    return thin


class StationSums(NamedTuple):
    """Sums over the nodes of stations.

    Attributes:
        counts: Numbers of nodes, shape (n,).
        total: W, sum of the weights, shape (n,).
        centres: Shape (n, 3) [m].
        moments: sum w r r^T of the arms r from the centres, shape (n, 3, 3).
    """

    counts: Array
    total: Array
    centres: Array
    moments: Array


def sum_stations(
    comm: MPI.Intracomm,
    size: int,
    X: Array,
    shares: tuple[IntArray, IntArray, Array],
) -> StationSums:
    """Sums over the nodes of stations. Collective.

    Args:
        size: Number of stations.
        X: Positions of the owned nodes, shape (n_owned, 3) [m].
    """
    nodes, stations, weights = shares
    sum_nodes = sparse.csr_matrix((weights, (stations, nodes)), shape=(size, len(X)))
    counts = np.bincount(stations, minlength=size).astype(float)
    # weights, X and X X^T beside 1
    of_weights = [np.ones((len(X), 1)), X, (X[:, :, None] * X[:, None]).reshape(-1, 9)]
    sums = np.column_stack([counts, sum_nodes @ np.hstack(of_weights)])
    sums = sum_over_ranks(comm, sums)
    W = np.maximum(sums[:, 1], np.finfo(float).tiny)
    centres = sums[:, 2:5] / W[:, None]
    outer = centres[:, :, None] * centres[:, None] * W[:, None, None]
    moments = sums[:, 5:14].reshape(-1, 3, 3) - outer
    return StationSums(sums[:, 0], W, centres, moments)


def share_out(
    line: StationLine, positions: Array, areas: Array
) -> tuple[IntArray, IntArray, Array]:
    """Nodes, stations and weights of all pairs in which a node has a part of a station.

    Args:
        positions: Initial positions of the nodes, shape (n_owned, 3) [m].
        areas: Skin area of each node, shape (n_owned,) [m^2].
    """
    nodes, stations = np.flatnonzero(areas), np.asarray(line.stations, dtype=float)
    z = np.clip(line.distances(positions[nodes]), stations[0], stations[-1])
    left = np.clip(np.searchsorted(stations, z, side="right") - 1, 0, max(line.size - 2, 0))
    beside = np.minimum(left + 1, line.size - 1)
    length = np.where(beside > left, stations[beside] - stations[left], np.inf)
    right = (z - stations[left]) / length
    share = np.concatenate([1.0 - right, right])
    kept = share > 0.0
    station = np.concatenate([left, beside])
    return np.tile(nodes, 2)[kept], station[kept], (np.tile(areas[nodes], 2) * share)[kept]

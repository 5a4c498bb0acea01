"""From the nodes of a skin to the motion of sections, and from their loads back to the nodes.

With the weights w_ai = A_a N_i(z_a) of node a at station i, A_a the skin area of the node and N_i
the hat function of the station along the axis, and sums over all nodes,

    x_i = sum w x_a / W,    r_a = x_a - x_i,    J = sum w (r.r 1 - r r),
    v_i = sum w v_a / W,    omega_i = J^-1 sum w r_a x v_a,

and the forces on the nodes are the transpose of that,

    f_a = w (F/W + (J^-1 M) x r_a),

so that sum f = F, sum r x f = M and sum f . v = F . v_i + M . omega_i, whatever F and M are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from mpi4py import MPI

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_matrix

from turbine_fenicsx.forces.section_loads import SectionLoads, SectionMotion, StationLine
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.foundation.types import Array, IntArray

SLENDEREST = 1e-6
"""Smallest moment of inertia of a section, relative to the largest, below which it is a line."""

UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Entries of a symmetric tensor."""


class SectionTransfer:
    """Weights of the nodes of a skin at stations. Collective.

    Args:
        positions: Initial positions of the owned nodes, shape (n_owned, 3) [m].
        areas: For each line the skin area of each node, zero off its skin, shape (n_owned,) [m^2].

    Attributes:
        nodes: Owned nodes that have a weight, shape (k,).
        stations: Number of stations.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        positions: Array,
        areas: Sequence[Array],
        loads: SectionLoads,
    ) -> None:
        self._comm, self.stations = comm, sum(line.size for line in loads.lines)
        parts, first = [], 0
        for line, area in zip(loads.lines, areas, strict=True):
            parts.append(share_out(line, positions, area, first))
            first += line.size
        node, station, weight = (np.concatenate(part) for part in zip(*parts, strict=True))
        self.nodes, pair = np.unique(node, return_inverse=True)
        X = positions[self.nodes]
        # all pairs of a node and a station, station after station; components are rows
        order = np.argsort(station, kind="stable")
        self._pair, self._station, self._w = pair[order], station[order], weight[order]
        self._scatter = csr_matrix(
            (self._w, (self._pair, np.arange(pair.size))), (self.nodes.size, pair.size)
        )
        self._present, self._starts = np.unique(self._station, return_index=True)
        self._W = np.maximum(self._sum(self._w[None])[:, 0], np.finfo(float).tiny)
        X_pairs = _take(X, self._pair)
        self._check(loads, X_pairs)
        self._initial = self._centre = self._centres(X_pairs)
        self._R = X_pairs - _take(self._centre, self._station)
        self._rows = np.empty((30, pair.size))

    def set_positions(self, x: Array) -> None:
        """Set positions from which those in a step do not differ much. Collective.

        Sums about the centres there, and not about the origin, lose no digits far from it.

        Args:
            x: Positions of the nodes, shape (k, 3) [m].
        """
        self._centre = self._centres(_take(x, self._pair))

    def motion(self, x: Array, v: Array) -> SectionMotion:
        """How the sections move. Collective.

        Args:
            x: Positions of the nodes, shape (k, 3) [m].
            v: Velocities of the nodes, shape (k, 3) [m/s].
        """
        y = _take(x, self._pair) - _take(self._centre, self._station)
        v = _take(v, self._pair)
        wy, rows = self._rows[:3], self._rows
        np.multiply(self._w, y, out=wy)
        np.multiply(self._w, v, out=rows[3:6])
        for row, (i, j) in enumerate(UPPER, start=6):
            np.multiply(wy[i], y[j], out=rows[row])
        for first, other in ((12, v), (21, self._R)):
            for i in range(3):
                np.multiply(wy[i], other, out=rows[first + 3 * i : first + 3 * i + 3])
        sums, W = self._sum(rows), self._W[:, None]
        y_mean, v_mean = sums[:, :3] / W, sums[:, 3:6] / W
        # sums about the centres: sum w r r = sum w y y - W y_i y_i, and so on
        S = np.empty((self.stations, 3, 3))
        for row, (i, j) in enumerate(UPPER, start=6):
            S[:, i, j] = S[:, j, i] = sums[:, row] - self._W * y_mean[:, i] * y_mean[:, j]
        rv = sums[:, 12:21].reshape(-1, 3, 3) - W[:, None] * y_mean[:, :, None] * v_mean[:, None]
        spin = np.stack([rv[:, i, j] - rv[:, j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
        # J = tr(S) 1 - S
        J = np.trace(S, axis1=1, axis2=2)[:, None, None] * np.eye(3) - S
        self._inverse = np.linalg.inv(J)
        self._r = y - _take(y_mean, self._station)
        return SectionMotion(
            self._centre + y_mean,
            nearest_rotation(sums[:, 21:].reshape(-1, 3, 3)),
            v_mean,
            np.einsum("ijk,ik->ij", self._inverse, spin),
            self._initial,
        )

    def forces(self, F: Array, M: Array) -> Array:
        """Forces on the nodes for loads on the sections of the last motion, shape (k, 3) [N].

        Args:
            F: Forces, shape (n, 3) [N].
            M: Moments about the centres, shape (n, 3) [N m].
        """
        parts = _take(F / self._W[:, None], self._station)
        turn = np.einsum("ijk,ik->ij", self._inverse, M)
        t, r = _take(turn, self._station), self._r
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            parts[i] += t[j] * r[k] - t[k] * r[j]
        return np.stack([self._scatter @ part for part in parts], axis=1)

    def _centres(self, x: Array) -> Array:
        """Weighted means of positions of the pairs, shape (n, 3) [m]. Collective."""
        centres: Array = self._sum(self._w * x) / self._W[:, None]
        return centres

    def _sum(self, rows: Array) -> Array:
        """Sums over the pairs of each station on all ranks, shape (n, rows). Collective."""
        sums = np.zeros((self.stations, len(rows)))
        if self._present.size:
            sums[self._present] = np.add.reduceat(rows, self._starts, axis=1).T
        return sum_over_ranks(self._comm, sums)

    def _check(self, loads: SectionLoads, X: Array) -> None:
        """Raise a ModelError for a station that is empty or whose nodes are on a line."""
        count = np.bincount(self._station, minlength=self.stations).astype(float)
        r = X - _take(self._centres(X), self._station)
        outer = (self._w * r[:, None] * r[None]).reshape(9, -1)
        moments = self._sum(outer).reshape(-1, 3, 3)
        check_stations(loads, sum_over_ranks(self._comm, count), moments)


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
        others: sum w f of further columns f, shape (n, columns).
    """

    counts: Array
    total: Array
    centres: Array
    moments: Array
    others: Array


def sum_stations(
    comm: MPI.Intracomm,
    size: int,
    X: Array,
    shares: tuple[IntArray, IntArray, Array],
    columns: Sequence[Array] = (),
) -> StationSums:
    """Sums over the nodes of stations. Collective.

    Args:
        size: Number of stations.
        X: Positions of the owned nodes, shape (n_owned, 3) [m].
        columns: Further values at the nodes, shapes (n_owned, k).
    """
    nodes, stations, weights = shares
    sum_nodes = csr_matrix((weights, (stations, nodes)), shape=(size, len(X)))
    counts = np.bincount(stations, minlength=size).astype(float)
    # weights, X and X X^T beside 1
    of_weights = [np.ones((len(X), 1)), X, (X[:, :, None] * X[:, None]).reshape(-1, 9)]
    sums = np.column_stack([counts, sum_nodes @ np.hstack([*of_weights, *columns])])
    sums = sum_over_ranks(comm, sums)
    W = np.maximum(sums[:, 1], np.finfo(float).tiny)
    centres = sums[:, 2:5] / W[:, None]
    outer = centres[:, :, None] * centres[:, None] * W[:, None, None]
    moments = sums[:, 5:14].reshape(-1, 3, 3) - outer
    return StationSums(sums[:, 0], W, centres, moments, sums[:, 14:])


def share_out(
    line: StationLine, positions: Array, areas: Array, first: int
) -> tuple[IntArray, IntArray, Array]:
    """Nodes, stations and weights of all pairs in which a node has a part of a station.

    Args:
        positions: Initial positions of the nodes, shape (n_owned, 3) [m].
        areas: Skin area of each node, shape (n_owned,) [m^2].
        first: Number of the first station.
    """
    nodes, stations = np.flatnonzero(areas), np.asarray(line.stations, dtype=float)
    z = np.clip(line.distances(positions[nodes]), stations[0], stations[-1])
    left = np.clip(np.searchsorted(stations, z, side="right") - 1, 0, max(line.size - 2, 0))
    beside = np.minimum(left + 1, line.size - 1)
    length = np.where(beside > left, stations[beside] - stations[left], np.inf)
    right = (z - stations[left]) / length
    share = np.concatenate([1.0 - right, right])
    kept = share > 0.0
    station = first + np.concatenate([left, beside])
    return np.tile(nodes, 2)[kept], station[kept], (np.tile(areas[nodes], 2) * share)[kept]


def _take(vectors: Array, index: IntArray) -> Array:
    """Chosen vectors as columns, shape (3, m), each component in one piece of memory."""
    return np.take(np.ascontiguousarray(vectors.T), index, axis=1)

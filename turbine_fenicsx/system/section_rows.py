"""From the vectors of a reduced body to the motion of sections, and from their loads back.

With the weights w_a of the nodes of the mesh at a station (see `section_transfer`), W their sum,
and the arms R_a of the nodes from the centre of the station in the mesh, the rows

    H_0 = sum w_a F(X_a)/W,      H_j = sum w_a R_aj F(X_a)

are constant, and with B_j = H_j z, A the rotation nearest to B, and U = A^T B

    x_i = H_0 z,    v_i = H_0 z',    omega_i = J^-1 sum_j A_j x H_j z',    J = tr(U) 1 - B A^T.

The forces on the vectors are the transpose of that,

    H_0^T F + sum_j H_j^T (J^-1 M) x A_j.

So the power is F.v_i + M.omega_i. If all vectors turn with w, omega_i = J^-1 sum_j A_j x (w x B_j)
is w, so that the resultants are F and M about x_i. All three hold to round-off.
"""

from __future__ import annotations

from dataclasses import replace

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.reduced_body import ReducedBody
from turbine_fenicsx.forces.section_loads import SectionLoads, SectionMotion, StationLine
from turbine_fenicsx.foundation.parallel import from_rank0
from turbine_fenicsx.foundation.rotations import cross_rows, nearest_rotation, skew_rows
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.section_transfer import (
    check_stations,
    find_flat,
    share_out,
    sum_stations,
)

Single = npt.NDArray[np.float32]
"""An array in single precision."""

SHRINKAGE = 0.9
"""Factor of the number of stations, if nodes are too far apart for them."""


class SectionRows:
    """Rows of the stations of all copies, whose vectors rank 0 owns. Collective.

    Stations that are closer than the nodes of the mesh lie between wider sections, and their rows
    are linear between the rows of these, which keeps all that is said above.

    Args:
        functions: F at the nodes of the mesh that this rank owns, shape (n_owned, n).
    """

    def __init__(
        self, body: ReducedBody, full: FlexibleModel, functions: Array, loads: SectionLoads
    ) -> None:
        self._comm: MPI.Intracomm = full.comm
        self._copies, self._n = len(body.placements), functions.shape[1]
        found = [self._find_rows(body, full, functions, loads.name, line) for line in loads.lines]
        rows, *others = zip(*found, strict=True)
        counts, moments, self._initial = map(np.concatenate, others)
        check_stations(loads, counts, moments)
        ends = np.cumsum([line.size for line in loads.lines])
        self._lines = [
            (line.copy, own, slice(end - line.size, end))
            for line, own, end in zip(loads.lines, rows, ends, strict=True)
        ]
        self._motions = [self._start_motions(own) for own in rows]
        turns = [np.asarray(body.placements[line.copy].rotation) for line in loads.lines]
        sizes = [line.size for line in loads.lines]
        self._turn_back = np.repeat(np.array(turns, dtype=float), sizes, axis=0).swapaxes(1, 2)

    def _find_rows(
        self,
        body: ReducedBody,
        full: FlexibleModel,
        functions: Array,
        name: str,
        line: StationLine,
    ) -> tuple[Array, Array, Array, Array]:
        """Rows of a line, shape (4 stations, n), numbers of nodes, sum w R R^T, and centres."""
        place, areas = body.placements[line.copy], full.find_areas(name, line.facets)
        R, t = (np.asarray(x, dtype=float) for x in (place.rotation, place.position))
        placed = t + full.positions @ R.T

        def measure(wider: StationLine) -> tuple[Array, Array, Array, Array]:
            shares = share_out(wider, placed, areas, 0)
            return self._sum_up(wider.size, full.positions, functions, shares)

        rows, counts, moments, centres = own = measure(line)
        stations = np.asarray(line.stations, dtype=float)
        number = line.size
        while number > 2 and np.any(find_flat(counts, moments)):
            # stations that are closer than the nodes lie between wider ones
            number = max(2, int(SHRINKAGE * number))
            wider = np.linspace(stations[0], stations[-1], number)
            rows, counts, moments, centres = measure(replace(line, stations=wider))
        if np.any(find_flat(counts, moments)):
            rows, counts, moments, centres = own
        elif number < line.size:
            share = np.array([np.interp(stations, wider, e) for e in np.eye(number)]).T
            rows, moments, centres = (np.tensordot(share, x, 1) for x in (rows, moments, centres))
            counts = np.full(line.size, counts.min())
        return rows.reshape(-1, self._n), counts, moments, t + centres @ R.T

    def _start_motions(self, rows: Array) -> tuple[Single, Single]:
        """Rows H_j of a line, and P_i without rotations, in single precision."""
        H = rows.reshape(-1, 4, self._n).astype(np.float32)
        P = np.zeros((len(H), 6, self._n, 3), dtype=np.float32)
        for i in range(3):
            P[:, i, :, i] = H[:, 0]
        return H[:, 1:], P

    def _sum_up(
        self, size: int, X: Array, functions: Array, shares: tuple[IntArray, IntArray, Array]
    ) -> tuple[Array, Array, Array, Array]:
        """Sums over the nodes of stations: rows, numbers of nodes, sum w R R^T, and centres."""
        # F beside 1 and each component of X
        columns = [functions, *(x[:, None] * functions for x in X.T)]
        sums = sum_stations(self._comm, size, X, shares, columns)
        rows = sums.others.reshape(size, 4, self._n)
        rows[:, 1:] -= sums.centres[:, :, None] * rows[:, :1]
        rows[:, 0] /= sums.total[:, None]
        return rows, sums.counts, sums.moments, sums.centres

    def set_positions(self, x: Array) -> None:
        """Nothing: sums are those of arms, and lose no digits far from the origin."""

    def motion(self, x: Array, v: Array) -> SectionMotion:
        """How the sections move. Collective.

        Args:
            x: Vectors of all copies on rank 0, nothing elsewhere, shape (copies n or 0, 3) [m, -].
        """
        both = np.zeros((self._copies, self._n, 6))
        if len(x):
            both[..., :3], both[..., 3:] = x.reshape(-1, self._n, 3), v.reshape(-1, self._n, 3)
        from_rank0(self._comm, both)
        sums = np.concatenate([rows @ both[copy] for copy, rows, _ in self._lines]).reshape(
            -1, 4, 6
        )
        B, rates = sums[:, 1:, :3].swapaxes(1, 2), sums[:, 1:, 3:]
        self._axes = A = nearest_rotation(B)
        A_T = A.swapaxes(1, 2)
        J = np.einsum("nij,nij->n", A, B)[:, None, None] * np.eye(3) - B @ A_T
        self._inverse = np.linalg.inv(J)
        D = A @ rates
        spin = np.stack([D[:, i, j] - D[:, j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
        return SectionMotion(
            sums[:, 0, :3],
            A @ self._turn_back,
            sums[:, 0, 3:],
            (self._inverse @ spin[:, :, None])[:, :, 0],
            self._initial,
        )

    def spread_slopes(self, slopes: Array) -> Array:
        """Derivatives of the forces on the vectors, of those of the loads at the last motion.

        They are found in single precision: tangents need no more.

        With P_i, which takes increments of the vectors to those of section i, this is the sum of
        P_i^T Q_i P_i for each copy.

        Args:
            slopes: Q, shape (stations, 6, 6), see `BoundSectionLoads.find_slopes`.

        Returns:
            Shape (copies, 3 n, 3 n).
        """
        k, single = 3 * self._n, np.float32
        found = np.zeros((self._copies, k, k))
        # J^-1 sum_j A_j x H_j
        turns = np.stack([skew_rows(self._axes[:, :, j]) for j in range(3)], axis=3)
        turns = np.einsum("nab,nbcj->nacj", self._inverse, turns).astype(single)
        slopes = slopes.astype(single)
        for (copy, _, of_line), (H, P) in zip(self._lines, self._motions, strict=True):
            spins = turns[of_line].reshape(-1, 9, 3) @ H
            P[:, 3:] = spins.reshape(-1, 3, 3, self._n).swapaxes(2, 3)
            moved = (slopes[of_line] @ P.reshape(-1, 6, k)).reshape(-1, k)
            found[copy] += P.reshape(-1, k).T @ moved
        return found

    def forces(self, F: Array, M: Array) -> Array:
        """Forces on the vectors for loads on the sections of the last motion.

        Args:
            F: Forces, shape (n, 3) [N].
            M: Moments about the centres, shape (n, 3) [N m].

        Returns:
            On rank 0 those of all vectors, nothing elsewhere, shape (copies n or 0, 3) [N].
        """
        if self._comm.rank:
            return np.zeros((0, 3))
        turn, on_rows = (self._inverse @ M[:, :, None])[:, :, 0], np.empty((len(F), 4, 3))
        on_rows[:, 0] = F
        for j in range(3):
            on_rows[:, 1 + j] = cross_rows(turn, self._axes[:, :, j])
        f = np.zeros((self._copies, self._n, 3))
        for copy, rows, of_line in self._lines:
            f[copy] += rows.T @ on_rows[of_line].reshape(-1, 3)
        return f.reshape(-1, 3)

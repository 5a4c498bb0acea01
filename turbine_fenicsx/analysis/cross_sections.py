"""The motion of a slender piece of a flexible body, section by section.

Each node a belongs in parts N_i(z_a), which add up to one, to the two stations that it lies
between. With w_ai = m_a N_i(z_a) and the arms r_ai from the middle of station i, the motion that
fits the displacements d_a of the nodes best is

    d_i = sum_a w_ai d_a / W_i,            W_i = sum_a w_ai,
    phi_i = sum_a w_ai (r_ai x d_a)_z / J_i,   J_i = sum_a w_ai (x_ai^2 + y_ai^2).
"""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.modal_sums import Piece
from turbine_fenicsx.analysis.piece_nodes import PieceNodes
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

STATIONS = 13
"""As many that a mode has its sign changes between them, and a coarse mesh has nodes at each."""


class CrossSections:
    """Stations along a piece.

    Args:
        axes: Its axes x, y, z in that state as rows, z along its length, shape (3, 3).
        along: The direction of z in the initial configuration, shape (3,).

    Attributes:
        nodes: The nodes.
        positions: Where they are in that state, shape (n, 3) [m].
        stations: Where the middles of the stations are along the axis z, shape (stations,) [m].

    Note:
        Collective, also `motion`.
    """

    def __init__(
        self, system: MultibodySystem, state: State, piece: Piece, axes: Array, along: Array
    ) -> None:
        self._comm, self._axes = system.comm, axes
        self.nodes = PieceNodes(system, piece)
        X, mass = self.nodes.positions, self.nodes.masses
        self.positions = X + self.nodes.displacements(state.u[piece.body])
        z = X @ along
        low, high = self._find_ends(z)
        place = (z - low) / (high - low) * (STATIONS - 1)
        weights = np.clip(1.0 - np.abs(place - np.arange(STATIONS)[:, None]), 0.0, 1.0) * mass
        W = sum_over_ranks(self._comm, weights.sum(axis=1))
        occupied = W > 1e-9 * W.sum()
        self._weights, W = weights[occupied], W[occupied]
        local = self.positions @ axes.T
        middles = sum_over_ranks(self._comm, self._weights @ local) / W[:, None]
        arms = local - middles[:, None, :]
        self._arms = self._weights[:, :, None] * arms
        self.stations: Array = middles[:, 2]
        J = np.einsum("ia,iac,iac->i", self._weights, arms[:, :, :2], arms[:, :, :2])
        self._masses = np.column_stack([W, W, W, sum_over_ranks(self._comm, J)])

    def motion(self, displacements: Array) -> Array:
        """Displacement along x, y, z and rotation about z at each station.

        They are scaled by the roots of mass and moment of inertia of the station, so that their
        squares are parts of the modal mass.

        Args:
            displacements: Of the nodes, shape (n, 3) [m].

        Returns:
            Shape (stations, 4).
        """
        d = displacements @ self._axes.T
        turned = self._arms[:, :, 0] @ d[:, 1] - self._arms[:, :, 1] @ d[:, 0]
        sums = np.column_stack([self._weights @ d, turned])
        found: Array = sum_over_ranks(self._comm, sums) / np.sqrt(self._masses)
        return found

    @property
    def roots(self) -> Array:
        """Divisors of `motion` that give metres and radians, shape (stations, 4)."""
        found: Array = np.sqrt(self._masses)
        return found

    def _find_ends(self, z: Array) -> tuple[float, float]:
        """Least and greatest z of all ranks."""
        ends = np.array([np.max(-z, initial=-np.inf), np.max(z, initial=-np.inf)])
        found = np.empty_like(ends)
        self._comm.Allreduce(ends, found, op=MPI.MAX)
        return -float(found[0]), float(found[1])

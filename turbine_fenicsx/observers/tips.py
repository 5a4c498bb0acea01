"""Deflection of points of flexible bodies relative to a rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.flexible_body import FlexibleBody
from turbine_fenicsx.observers.history import Channel
from turbine_fenicsx.observers.shared_sum import SharedSum
from turbine_fenicsx.rigid_body import RigidBody
from turbine_fenicsx.rotations import Array
from turbine_fenicsx.simulation import Snapshot
from turbine_fenicsx.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Tip:
    """A point to follow.

    Args:
        name: Column ``tip_deflection_NAME_[m]``.
        body: Flexible body; its node nearest to the point is followed.
        point: Initial position [m], shape (3,).
        carrier: Rigid body whose frame the deflection is measured in.
        axes: Axes of the components, fixed to the carrier; their initial directions as rows,
            shape (3, 3). The directors of the carrier if None.
    """

    name: str
    body: FlexibleBody
    point: npt.ArrayLike
    carrier: RigidBody
    axes: npt.ArrayLike | None = None


class Tips:
    """Deflections R^T (x - phi) - xi of points in the frames of their carriers.

    Args:
        system: The system.
        tips: The points.
        sums: Where the sums over the ranks are made; its own if None.

    Note:
        Collective.
    """

    def __init__(
        self, system: MultibodySystem, tips: Sequence[Tip], sums: SharedSum | None = None
    ) -> None:
        """Find the nodes and the ranks that own them."""
        comm = system.comm
        self.tips = tuple(tips)
        self._mine: list[tuple[int, int, slice, slice, Array, Array, Array]] = []
        for k, tip in enumerate(self.tips):
            index = system.flexible_bodies.index(tip.body)
            block = system.flexible_blocks[index]
            distance = np.linalg.norm(block.positions - np.asarray(tip.point), axis=1)
            node = int(np.argmin(distance)) if distance.size else -1
            mine = (float(distance[node]) if distance.size else np.inf, comm.rank)
            if comm.allreduce(mine, op=MPI.MINLOC)[1] == comm.rank:
                first, X = system.first_coordinate[tip.carrier], block.positions[node]
                axes = np.eye(3)
                if tip.axes is not None:
                    axes = np.asarray(tip.axes, float) @ np.asarray(tip.carrier.directors, float)
                dofs, q = slice(3 * node, 3 * node + 3), slice(first, first + 12)
                self._mine.append((k, index, dofs, q, X, tip.carrier.body_coordinates(X), axes))
        self._sum = (sums or SharedSum(comm)).add(self._local)

    def at(self, snapshot: Snapshot) -> Array:
        """Deflections at a snapshot [m], shape (n, 3), equal on all ranks. Collective."""
        return self._sum(snapshot)

    def _local(self, snapshot: Snapshot) -> Array:
        """Deflections of the nodes of this rank, zero for the others."""
        deflections = np.zeros((len(self.tips), 3))
        state = snapshot.state
        for k, index, dofs, coordinates, X, xi, axes in self._mine:
            phi, *directors = state.q[coordinates].reshape(4, 3)
            x = X + state.u[index].array_r[dofs]
            deflections[k] = axes @ (np.array(directors) @ (x - phi) - xi)
        return deflections


def tip_channel(tips: Tips) -> Channel:
    """Lengths of the deflections."""
    columns = tuple(f"tip_deflection_{tip.name}_[m]" for tip in tips.tips)
    return Channel(columns, lambda s: np.linalg.norm(tips.at(s), axis=1).tolist())


def stress_channel(system: MultibodySystem) -> Channel:
    """Largest norm of the Cauchy stress at any cell centre. Collective."""

    def values(s: Snapshot) -> list[float]:
        norms = (
            np.max(block.cauchy_stress_norm(u), initial=0.0)
            for block, u in zip(system.flexible_blocks, s.state.u, strict=True)
        )
        return [float(system.comm.allreduce(max(norms, default=0.0), op=MPI.MAX))]

    return Channel(("max_stress_[Pa]",), values)

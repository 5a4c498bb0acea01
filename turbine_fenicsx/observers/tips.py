"""Deflection of points of flexible bodies relative to a rigid body."""

from __future__ import annotations

from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.flexible_body import FlexibleBody
from turbine_fenicsx.observers.history import Channel
from turbine_fenicsx.rigid_body import RigidBody
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
    """

    name: str
    body: FlexibleBody
    point: npt.ArrayLike
    carrier: RigidBody


def tip_channel(system: MultibodySystem, tips: list[Tip]) -> Channel:
    """Lengths |R^T (x - phi) - xi| of the deflections in the frames of the carriers.

    Args:
        system: The system.
        tips: The points.

    Note:
        Collective, also the evaluation.
    """
    comm = system.comm
    nodes = []
    for tip in tips:
        block = system.flexible_blocks[system.flexible_bodies.index(tip.body)]
        distance = np.linalg.norm(block.positions - np.asarray(tip.point), axis=1)
        nearest = int(np.argmin(distance)) if distance.size else -1
        mine = (float(distance[nearest]) if distance.size else np.inf, comm.rank)
        owner = comm.allreduce(mine, op=MPI.MINLOC)[1]
        nodes.append((block, nearest if comm.rank == owner else -1))

    def values(s: Snapshot) -> list[float]:
        deflections = np.zeros(len(tips))
        coordinates = system.coordinates_of(s.state.q)
        for k, (tip, (block, node)) in enumerate(zip(tips, nodes, strict=True)):
            if node >= 0:
                X = block.positions[node]
                u = s.state.u[system.flexible_blocks.index(block)].array_r[3 * node : 3 * node + 3]
                phi, *directors = coordinates[tip.carrier].reshape(4, 3)
                xi = np.array(directors) @ (X + u - phi)
                deflections[k] = np.linalg.norm(xi - tip.carrier.body_coordinates(X))
        return list(comm.allreduce(deflections))

    return Channel(tuple(f"tip_deflection_{t.name}_[m]" for t in tips), values)


def stress_channel(system: MultibodySystem) -> Channel:
    """Largest norm of the Cauchy stress at any cell centre. Collective."""

    def values(s: Snapshot) -> list[float]:
        norms = (
            np.max(block.cauchy_stress_norm(u), initial=0.0)
            for block, u in zip(system.flexible_blocks, s.state.u, strict=True)
        )
        return [float(system.comm.allreduce(max(norms, default=0.0), op=MPI.MAX))]

    return Channel(("max_stress_[Pa]",), values)

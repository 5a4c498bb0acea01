"""How far sections of slender bodies have turned, seen from what carries the body.

With weights w_a and arms R_a of the nodes around a place, B = sum w_a x_a R_a^T is constant for a
body at rest, symmetric, and turns with the body. So the rotation of a section is the one nearest to
B, as for loads on sections.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import (
    check_among_parts,
    check_directions,
    check_vectors,
)
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.rotations import nearest_rotation
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.probe import Probe, find_model
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

MIN_NODES = 12
"""Minimum number of nodes of a section; it is made wider where there are fewer."""


@dataclass(frozen=True, eq=False)
class Section:
    """A section of a body.

    Args:
        origin: A point of its axis in the initial configuration, shape (3,) [m].
        axis: Direction of the axis, shape (3,).
        distance: Along the axis from the origin [m].
        half_width: Nodes so near count, those in the middle most [m].
        carrier: Rigid body that it is seen from; None is the ground.
        copy: Number of the copy of a reduced body.
    """

    name: str
    body: DeformableBody
    _: KW_ONLY
    origin: npt.ArrayLike
    axis: npt.ArrayLike
    distance: float
    half_width: float
    carrier: RigidBody | None = None
    copy: int = 0

    def __post_init__(self) -> None:
        check_vectors(self.name, origin=self.origin)
        check_directions(self.name, axis=self.axis)


class SectionTurns:
    """Rotations of sections about their axes. Collective."""

    def __init__(self, system: MultibodySystem, sections: Sequence[Section]) -> None:
        self.sections, sums = tuple(sections), []
        self._carriers: list[slice | None] = []
        for section in self.sections:
            whose = f"section {section.name!r}"
            model = find_model(system, section.body, whose)
            if section.carrier is not None:
                check_among_parts("body", section.carrier, system.rigid_bodies, whose)
            first = None if section.carrier is None else system.first_coordinate[section.carrier]
            self._carriers.append(None if first is None else slice(first + 3, first + 12))
            space, (R, t) = model.space, section.body.placements[section.copy].frame()
            X = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
            nodes, _, arms = find_arms(section, t + np.concatenate(system.comm.allgather(X)) @ R.T)
            sums.append((section.body, model.rows(section.copy, nodes, arms.T)))
        self._probe = Probe(system, sums)

    def at(self, snapshot: Snapshot) -> Array:
        """Angles about the axes at a snapshot, shape (n,) [rad], equal on all ranks. Collective."""
        angles = np.zeros(len(self.sections))
        turns = self.find_rotations(snapshot.state)
        for k, (section, turn) in enumerate(zip(self.sections, turns, strict=True)):
            axis = np.asarray(section.axis, dtype=float)
            *v, w = Rotation.from_matrix(turn).as_quat()
            angle = 2.0 * np.arctan2(v @ axis / np.linalg.norm(axis), w)
            angles[k] = (angle + np.pi) % (2.0 * np.pi) - np.pi
        return angles

    def find_rotations(self, state: State) -> Array:
        """Rotations seen from the carriers, in the initial directions of e1, e2, e3, (n, 3, 3)."""
        # B^T = sum w_a R_a x_a^T
        B_T = self._probe.values(state).reshape(-1, 3, 3)
        turns = nearest_rotation(B_T.swapaxes(1, 2))
        for k, (section, carrier) in enumerate(zip(self.sections, self._carriers, strict=True)):
            if carrier is not None:
                assert section.carrier is not None
                directors = state.q[carrier].reshape(3, 3)
                turns[k] = np.asarray(section.carrier.directors) @ directors @ turns[k]
        return turns


def find_arms(section: Section, X: Array) -> tuple[npt.NDArray[np.int64], Array, Array]:
    """Nodes of a section, their weights, which add up to 1, and these times arms, (k, 3).

    Args:
        X: Positions of all nodes of the mesh, where the copy stands, shape (n, 3) [m].
    """
    if len(X) <= MIN_NODES:
        raise ModelError(f"section {section.name!r}: {section.body.name!r} has too few nodes")
    axis = np.asarray(section.axis, dtype=float)
    along = (X - np.asarray(section.origin, dtype=float)) @ (axis / np.linalg.norm(axis))
    distances = np.abs(along - section.distance)
    width = max(section.half_width, 1.001 * float(np.partition(distances, MIN_NODES)[MIN_NODES]))
    weights = np.maximum(1.0 - distances / width, 0.0)
    nodes = np.flatnonzero(weights)
    w = weights[nodes, None] / weights.sum()
    return nodes, w[:, 0], w * (X[nodes] - np.sum(w * X[nodes], axis=0))

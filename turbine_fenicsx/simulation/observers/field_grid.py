"""The grid of the field output: cells of all flexible bodies and surfaces of rigid ones.

Each cell knows what carries its body, from the ground through joints and couplings.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import partial

from petsc4py import PETSc

import numpy as np

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.bodies.rigid_surface import RigidSurface, inertia_box
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.field_files import open_series
from turbine_fenicsx.records.grid_series import ROOM, GridSeries
from turbine_fenicsx.records.parts import Part, Parts
from turbine_fenicsx.simulation.observers.body_grid import BodyGrid
from turbine_fenicsx.system.system import MultibodySystem


def find_carriers(system: MultibodySystem) -> tuple[dict[RigidBody, int], dict[int, int]]:
    """Supports of rigid bodies, and couplings that carry flexible bodies.

    The ground stands on nothing, nor does the first body of what hangs together without touching
    the ground. From there joints are followed before couplings, so that a flexible body in a loop
    is carried by rigid ones.

    Args:
        system: The system. Its couplings count from 1.

    Returns:
        For each rigid body the number of the coupling by which a flexible body carries it, 0 for
        none. For each coupling that carries a flexible body the number that its rigid body, or the
        ground, stands on.
    """
    stands_on: dict[RigidBody | None, int] = {None: 0}
    roots: dict[int, int] = {}
    carried: set[DeformableBody] = set()
    bodies = iter(system.rigid_bodies)
    while True:
        _follow_joints(system, stands_on)
        couplings = list(enumerate(system.couplings, start=1))
        new = [(k, c) for k, c in couplings if c.rigid in stands_on and c.flexible not in carried]
        roots |= {k: stands_on[c.rigid] for k, c in new}
        carried |= {c.flexible for _, c in new}
        heads = [(k, c) for k, c in couplings if c.flexible in carried and c.rigid not in stands_on]
        stands_on |= {c.rigid: k for k, c in reversed(heads)}
        if not heads and not new:
            free = next((b for b in bodies if b not in stands_on), None)
            if free is None:
                return {b: stands_on[b] for b in system.rigid_bodies}, roots
            stands_on[free] = 0


def _follow_joints(system: MultibodySystem, stands_on: dict[RigidBody | None, int]) -> None:
    """Add all rigid bodies that joints connect with those that are known."""
    waiting = list(system.joints)
    while True:
        found = [j for j in waiting if (j.bodies[0] in stands_on) != (j.bodies[1] in stands_on)]
        if not found:
            return
        for joint in found:
            a, b = joint.bodies
            known = a if a in stands_on else b
            stands_on.setdefault(b if known is a else a, stands_on[known])


class FieldGrid:
    """Points and cells of a system as they go to a file of fields.

    Points are the vertices of the flexible bodies, then on rank 0 those of the surfaces.

    Args:
        surfaces: Surfaces of rigid bodies, written by rank 0; if None, each is drawn as the
            homogeneous box of its mass and Euler values.
        parts: Number of the part of each local cell (ghosts included), one array for each copy
            of each flexible body; if None, each of them is one part, with the next free numbers.
        names: Names of the numbered parts that are not called like their bodies.

    Attributes:
        bodies: Vertices and cells of each copy of each flexible body.
        n_faces: Number of faces of surfaces on this rank.
        positions: Initial positions of the points of this rank, shape (n, 3) [m].
    """

    def __init__(
        self,
        system: MultibodySystem,
        surfaces: Sequence[RigidSurface] | None = None,
        parts: Sequence[Array] | None = None,
        names: Mapping[int, str] | None = None,
    ) -> None:
        self._system, self.comm = system, system.comm
        comm = self.comm
        if surfaces is None:
            bodies = [body for body in system.rigid_bodies if body.mass > 0.0]
            surfaces = [inertia_box(body, k) for k, body in enumerate(bodies)]
        self.bodies = [
            BodyGrid(system, k, copy)
            for k, body in enumerate(system.flexible_bodies)
            for copy in range(len(body.placements))
        ]
        if parts is None:
            free = 1 + max((surface.part for surface in surfaces), default=-1)
            parts = [np.full(b.n_cells, free + k) for k, b in enumerate(self.bodies)]
        if len(parts) != len(self.bodies):
            raise ModelError(
                f"{len(parts)} arrays of parts for {len(self.bodies)} flexible bodies and copies"
            )
        cell_parts = [p[: b.n_cells] for p, b in zip(parts, self.bodies, strict=True)]
        self._about = _describe(system, surfaces, cell_parts, names or {})
        self._surfaces = tuple(surfaces) if comm.rank == 0 else ()
        counts = [b.n_points for b in self.bodies] + [sum(len(s.points) for s in self._surfaces)]
        all_counts = np.array(comm.allgather(counts))
        starts = np.cumsum(all_counts.ravel()).reshape(all_counts.shape) - all_counts
        cells = []
        for k, body in enumerate(self.bodies):
            cells.append((body.kind, body.cells(comm, starts[:, k])))
        first = int(starts[comm.rank, -1])
        quadrilaterals = [np.zeros((0, 4), np.int64)]
        for surface in self._surfaces:
            quadrilaterals.append(first + surface.quadrilaterals)
            cell_parts.append(np.full(len(surface.quadrilaterals), surface.part))
            first += len(surface.points)
        cells.append(("quadrilateral", np.concatenate(quadrilaterals)))
        self.n_faces = len(cells[-1][1])
        places = [b.positions for b in self.bodies] + [s.points for s in self._surfaces]
        self.positions: Array = np.concatenate([np.zeros((0, 3)), *places])
        held = [body.couplings() for body in self.bodies]
        self._open = partial(
            open_series,
            comm,
            cells=cells,
            n_points=sum(counts),
            point_data={"coupling": np.concatenate([*held, np.zeros(counts[-1], np.int32)])},
            cell_data={"part": np.concatenate([np.zeros(0), *cell_parts]).astype(np.int32)},
        )

    def open(
        self,
        path: str | os.PathLike[str],
        append: float | None = None,
        information: Mapping[str, str] | None = None,
        room: int = ROOM,
    ) -> GridSeries:
        """A series on this grid, see `open_series`. Collective."""
        about = {"parts": self._about.to_text(), **(information or {})}
        return self._open(path=path, append=append, information=about, room=room)

    def motion(self, q: Array, u: Sequence[PETSc.Vec]) -> Array:
        """Displacements or velocities of the points of this rank, shape (n, 3). Collective.

        Args:
            q: Of the coordinates of the rigid bodies, shape (12 bodies,).
            u: Of the displacement of each flexible body.
        """
        moved = [body.motion(u[body.number]) for body in self.bodies]
        coordinates = self._system.coordinates_of(q)
        for surface in self._surfaces:
            xi = surface.body.body_coordinates(surface.points)
            weights = np.column_stack([np.ones(len(xi)), xi])
            moved.append(weights @ coordinates[surface.body].reshape(4, 3))
        return np.concatenate([np.zeros((0, 3)), *moved])

    def displacement(self, q: Array, u: Sequence[PETSc.Vec]) -> Array:
        """From the initial positions of the points of this rank, shape (n, 3) [m]. Collective.

        Args:
            q: Coordinates of the rigid bodies, shape (12 bodies,).
        """
        starts = [body.coordinates for body in self._system.rigid_bodies]
        return self.motion(q - np.concatenate([np.zeros(0), *starts]), u)


def _describe(
    system: MultibodySystem,
    surfaces: Sequence[RigidSurface],
    cell_parts: Sequence[Array],
    names: Mapping[int, str],
) -> Parts:
    """Names of all parts and what carries them. Collective."""
    stands_on, roots = find_carriers(system)
    found = {}
    for surface in surfaces:
        name, number = surface.body.name, surface.part
        found[number] = Part(number, names.get(number, name), name, stands_on[surface.body])
    copies = [body for body in system.flexible_bodies for _ in body.placements]
    for body, mine in zip(copies, cell_parts, strict=True):
        for number in sorted(set().union(*system.comm.allgather(set(mine.astype(int).tolist())))):
            found[number] = Part(number, names.get(number, body.name), body.name)
    return Parts(tuple(found.values()), roots)

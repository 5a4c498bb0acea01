"""The same blade as a hollow solid of laminates, one hexahedron through the wall."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from turbine_fenicsx import Coupling, FlexibleBody, Gravity, MultibodySystem, cell_field
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import tabulate_walls
from turbine_fenicsx.meshing import load_arrays, mesh_hollow
from turbine_fenicsx.meshing.model import MeshArrays

GRAVITY = 9.81  # [m/s^2]
AXES = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""x, y, z of windIO in the axes of the mesh: span, to the leading edge, to the suction side."""


@dataclass(frozen=True)
class Solid:
    """A clamped blade.

    Attributes:
        comm: Communicator.
        blade: The blade of the windIO file.
        block: Its mesh.
        laminates: Plies of each cell of the mesh.
        body: The flexible body.
        root: Its facets at the root.
        skin: Those of its skin.
    """

    comm: Any
    blade: Any
    block: Any
    laminates: list
    body: FlexibleBody
    root: Any
    skin: Any

    def system(self, direction=None):
        """The clamped blade, under its weight along x, y or z of the file, or without weight."""
        parts: list[Any] = [self.body, Coupling("clamp", self.body, self.root, None)]
        if direction is not None:
            parts.append(Gravity(tuple(GRAVITY * AXES[direction])))
        return MultibodySystem(self.comm, parts)

    def tip_displacement(self, system, state):
        """Mean displacement of the nodes at the tip, along x, y and z of the file, shape (3,)."""
        X, u = system.flexible_models[0].positions, state.u[0].array_r.reshape(-1, 3)
        end = self.block.points[:, 0].max()
        tip = X[:, 0] > end - 1e-6
        total = self.comm.allreduce(np.append(u[tip].sum(axis=0), np.count_nonzero(tip)))
        return AXES @ (total[:3] / total[3])


def make_solid(comm, blade, elements, moments=False):
    """Mesh a blade of a windIO file with so many elements along and around."""
    block = mesh_hollow(blade, *elements)
    facets = np.concatenate([block.root, block.skin])
    arrays = MeshArrays(
        block.reference,
        block.points,
        block.cells,
        np.ones(len(block.cells), dtype=np.int64),
        facets,
        np.repeat([1, 2], [len(block.root), len(block.skin)]),
        {"blade": 1},
        {"root": 1, "skin": 2},
    )
    loaded = load_arrays(comm, lambda: arrays, "blade")
    laminates = [
        blade.layup(block.parts[part], tuple(span), tuple(arc))
        for part, span, arc in zip(block.part, block.span, block.arc, strict=True)
    ]
    table = tabulate_walls(laminates, block.thickness, moments)[loaded.original_cells]
    law = Laminate.from_table(loaded.mesh, table)
    body = FlexibleBody("blade", loaded.mesh, law, cell_field(loaded.mesh, table.density), 2)
    return Solid(comm, blade, block, laminates, body, *map(loaded.facets, ("root", "skin")))

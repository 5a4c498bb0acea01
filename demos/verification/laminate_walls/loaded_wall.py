"""A wall of laminate that is clamped at one end and loaded at the other."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from published import load

from turbine_fenicsx import Coupling, FlexibleBody, MultibodySystem, cell_field, equilibrium
from turbine_fenicsx.materials.laminate import Laminate
from turbine_fenicsx.materials.laminate_theory import tabulate_walls
from turbine_fenicsx.system.ply_stresses import PlyStresses


@dataclass(frozen=True, eq=False)
class EndLoad:
    """A traction on the end that is a function of the initial position, in UFL."""

    name: str
    flexible: FlexibleBody
    facets: Any
    size: float
    field: Callable[[Any], Any]

    def function(self, time):
        """Factor over the time."""
        return 1.0

    def traction(self, at):
        """Traction [N/m^2] as a UFL vector at a `SurfacePoint`."""
        return at.factor * at.parameter(self.size) * self.field(at.X)


class LoadedWall:
    """A wall that is clamped at s = 0 and in equilibrium with a traction at s = 1.

    Args:
        comm: Communicator.
        arrays: Its mesh, of `mesh.wall_arrays`.
        plies: Of the cells, one laminate for all, or one for each row of the mesh.
        thickness: Of the wall in the mesh [m], a number or one for each row.
        size: Factor of the traction [N/m^2].
        field: The traction as a function of the initial position, in UFL.
        moments: As for `tabulate_walls`.
        law: More arguments of `Laminate`.

    Attributes:
        number: Row in the mesh of each cell that this rank owns.
        positions: Initial positions of its nodes, shape (nodes, 3) [m].
        u: Their displacements, of the same shape.
        strains: Inner and outer strains (e11, e22, 2 e12) of its cells at the points where the
            plies are looked at, each of shape (cells, points, 3).
    """

    def __init__(self, comm, arrays, plies, thickness, size, field, moments=False, **law):
        loaded, self.number = load("laminate_walls", "mesh").load_wall(comm, arrays)
        self.comm, cells = comm, loaded.mesh
        all_plies = [plies] * len(arrays.cells) if hasattr(plies[0], "angle") else plies
        mine = [all_plies[c] for c in self.number]
        walls = np.broadcast_to(thickness, len(arrays.cells))[self.number]
        table = tabulate_walls(mine, walls, moments)
        fields = (cell_field(cells, table.in_plane), cell_field(cells, table.through))
        body = FlexibleBody("wall", cells, Laminate(*fields, **law), 1.0, degree=2)
        traction = EndLoad("load", body, loaded.facets("tip"), size, field)
        root = Coupling("root", body, loaded.facets("root"), None)
        system = MultibodySystem(comm, [body, root, traction])
        state = equilibrium(system)
        found = PlyStresses(system, body, mine)
        found.update(state)
        self.strains = found.inner, found.outer
        self.positions = system.flexible_models[0].positions
        self.u = state.u[0].array_r.reshape(-1, 3).copy()

    def mean(self, values, chosen):
        """Mean over all ranks of values of nodes or cells, of those that are chosen."""
        total = self.comm.allreduce(np.sum(values[chosen], axis=0))
        return total / self.comm.allreduce(np.count_nonzero(chosen))

    def mean_at(self, x, values):
        """Mean over all ranks of values of nodes, of those at one x."""
        return self.mean(values, np.isclose(self.positions[:, 0], x))

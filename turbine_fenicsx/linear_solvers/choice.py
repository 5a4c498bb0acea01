"""Which linear solver "auto" stands for."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.machine import machine_memory
from turbine_fenicsx.linear_solvers.memory import choose_by_memory
from turbine_fenicsx.linear_solvers.substructures import WIDEST, find_shared_nodes
from turbine_fenicsx.meshing.size import MeshSize
from turbine_fenicsx.system.flexible_model import FlexibleModel
from turbine_fenicsx.system.system import MultibodySystem


def choose_solver(name: str, system: MultibodySystem) -> str:
    """Resolve "auto" by the memory that a factor needs and that the machines have. Collective.

    Args:
        name: A key of `LINEAR_SOLVERS`, or "auto".
        system: The system.
    """
    if name != "auto":
        return name
    models, ranks = system.flexible_models, system.comm.size
    meshes, available = [_count(model) for model in models], machine_memory(system.comm)
    found = choose_by_memory(meshes, ranks, False, available)
    if found == "iterative":
        largest = models[int(np.argmax([mesh.nodes for mesh in meshes]))]
        found = choose_by_memory(meshes, ranks, _has_equal_parts(largest), available)
    return found


def _count(model: FlexibleModel) -> MeshSize:
    """Numbers of the mesh of a body, on all ranks."""
    mesh = model.body.mesh
    mesh.topology.create_entities(0)
    cells, vertices = (int(mesh.topology.index_map(d).size_global) for d in (3, 0))
    nodes = int(model.space.dofmap.index_map.size_global)
    return MeshSize(_compat.cell_name(mesh), cells, vertices, nodes)


def _has_equal_parts(model: FlexibleModel) -> bool:
    """Whether each rank has several unconnected parts, of as many nodes each. Collective.

    What surrounds them must be small enough for `Substructures`, too.
    """
    mesh, n = model.body.mesh, len(model.local_positions)
    cells = _compat.dofs_of_cells(model.space)[: mesh.topology.index_map(3).size_local]
    edges = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    graph = csr_matrix((np.ones(cells.size), edges), (n, n))
    label = connected_components(graph, directed=False)[1]
    parts = np.unique(label[np.unique(cells)], return_counts=True)[1]
    S = 3.0 * (n - model.n_owned + np.count_nonzero(find_shared_nodes(model)))
    alike = parts.size > 1 and bool(np.all(parts == parts[0]))
    narrow = S**2 <= WIDEST * 3.0 * model.n_owned * parts.size
    return bool(mesh.comm.allreduce(alike and narrow, op=MPI.LAND))

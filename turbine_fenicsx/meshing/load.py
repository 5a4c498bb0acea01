"""Load a .msh file as a distributed DOLFINx mesh with named groups.

Equal are components with as many cells. All are cut alike, and a rank gets the same part of each.
So its parts are congruent where the components are, and what is found for one of them, such as a
factor, serves for all.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.cells import ReferenceCell
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.read import read_msh

if TYPE_CHECKING:
    from dolfinx.mesh import Mesh

THINNEST = 6
"""Minimum number of layers of cells of each equal part on a rank, and never fewer than there are
ranks. With more ranks the interfaces that all of them solve for grow, and the parts between become
thinner."""

UNEVEN = 1.1
"""Maximum ratio of the cells of the largest part to their mean."""


def share_equal_components(points: Array, cells: IntArray, ranks: int) -> NDArray[np.int32] | None:
    """The rank of each cell; None if the mesh is not of equal components, or these too short.

    A component is cut into slabs: layers of cells, counted from one of its ends, are never cut, so
    that ranks meet in whole cross-sections of a slender body.

    Args:
        points: Coordinates of the nodes, shape (n, 3) [m].
        cells: Nodes of each cell, shape (m, nodes per cell).
        ranks: Number of ranks.
    """
    found = _find_layers(points, cells)
    if found is None:
        return None
    component, layers = found
    owners = np.empty(len(cells), dtype=np.int32)
    for k in range(component.max() + 1):
        slabs = _cut(layers[component == k], ranks)
        if slabs is None:
            return None
        owners[component == k] = slabs
    return owners


def _find_layers(points: Array, cells: IntArray) -> tuple[IntArray, IntArray] | None:
    """The component of each cell and its layer there; None if components are not equal."""
    starts = np.arange(0, cells.size + 1, cells.shape[1])
    nodes_of = csr_matrix((np.ones(cells.size, np.int8), cells.ravel(), starts))
    cells_of = nodes_of.T.tocsr()
    # as a graph: each cell is tied to its nodes by way of its first one
    ties = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    graph = csr_matrix((np.ones(cells.size, np.int8), ties), (len(points),) * 2)
    component = np.unique(
        connected_components(graph, directed=False)[1][cells[:, 0]], return_inverse=True
    )[1]
    sizes = np.bincount(component)
    if sizes.size == 1 or np.any(sizes != sizes[0]):
        return None
    return component, _number_layers(points[cells].mean(axis=1), component, nodes_of, cells_of)


def list_ranks(
    cells: IntArray, owners: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Ranks of each cell and of its neighbours, its own first, and where those of each start.

    Args:
        cells: Nodes of each cell, shape (m, nodes per cell).
        owners: Rank of each cell, shape (m,).
    """
    (m, width), n = cells.shape, np.max(cells, initial=0) + 1
    nodes_of = csr_matrix((np.ones(m * width), cells.ravel(), np.arange(m + 1) * width), (m, n))
    is_owner = csr_matrix((np.ones(m), owners, np.arange(m + 1)), (m, owners.max(initial=0) + 1))
    near = nodes_of @ (nodes_of.T @ is_owner)
    row = np.repeat(np.arange(m), np.diff(near.indptr))
    own_first = np.lexsort((near.indices != owners[row], row))
    return near.indices[own_first].astype(np.int32), near.indptr.astype(np.int32)


def _number_layers(
    centres: Array, component: IntArray, nodes_of: csr_matrix, cells_of: csr_matrix
) -> IntArray:
    """The layer of each cell, counted from an end of its component.

    The last cells to be reached from the one farthest from the middle are the whole other end.
    """
    by_component = np.argsort(component, kind="stable")
    parts = np.split(by_component, np.cumsum(np.bincount(component))[:-1])
    outermost = [_find_outermost(centres, part) for part in parts]
    steps = _count_steps(np.array(outermost), nodes_of, cells_of)
    ends = [part[steps[part] == steps[part].max()] for part in parts]
    return _count_steps(np.concatenate(ends), nodes_of, cells_of)


def _find_outermost(centres: Array, part: IntArray) -> int:
    """The cell of a component farthest from its middle; of equals that nearest to all components.

    Without the second rule round-off would decide which end of a prismatic component comes first.
    """
    distance = np.linalg.norm(centres[part] - centres[part].mean(axis=0), axis=1)
    equals = part[distance >= (1.0 - 1e-6) * distance.max()]
    inwards = np.linalg.norm(centres[equals] - centres.mean(axis=0), axis=1)
    return int(equals[np.argmin(inwards)])


def _count_steps(first: IntArray, nodes_of: csr_matrix, cells_of: csr_matrix) -> IntArray:
    """Steps from cell to cell with a common node from the first ones to each cell."""
    steps = np.full(nodes_of.shape[0], -1)
    steps[first] = 0
    reached = first
    while reached.size:
        near = np.unique(cells_of[np.unique(nodes_of[reached].indices)].indices)
        near = near[steps[near] < 0]
        steps[near] = steps[reached[0]] + 1
        reached = near
    return steps


def _cut(layers: IntArray, ranks: int) -> IntArray | None:
    """The rank of each cell of a component by its layer, None where that would be uneven."""
    ends = np.cumsum(np.bincount(layers))
    cuts = np.searchsorted((ends[:-1] + ends[1:]) / 2, ends[-1] * np.arange(1, ranks) / ranks)
    bounds = np.concatenate([[-1], cuts, [ends.size - 1]])
    owners: IntArray = np.searchsorted(cuts, layers, side="left")
    largest = np.max(np.bincount(owners, minlength=ranks))
    if np.min(np.diff(bounds)) < max(THINNEST, ranks) or largest * ranks > UNEVEN * layers.size:
        return None
    return owners


@dataclass(frozen=True)
class LoadedMesh:
    """A distributed mesh with the named groups of its file.

    Attributes:
        cell_tags: Number of the physical volume of each cell (mesh tags).
        facet_tags: Number of the physical surface of each grouped face (mesh tags).
        report: Numbers of nodes and cells, volumes and worst quality of the whole mesh.
        cell_data: What is known of each cell that this rank owns by name, shape (n,) each.
    """

    mesh: Mesh
    cell_tags: Any
    facet_tags: Any
    cell_names: dict[str, int]
    facet_names: dict[str, int]
    report: MeshReport
    cell_data: dict[str, Array] = field(default_factory=dict)

    @property
    def original_cells(self) -> NDArray[np.int64]:
        """Row in the arrays the mesh was made of for each cell that this rank owns."""
        topology = self.mesh.topology
        owned = topology.index_map(topology.dim).size_local
        return np.asarray(topology.original_cell_index[:owned], dtype=np.int64)

    def cells(self, name: str) -> NDArray[np.int32]:
        """Local cells of a physical volume, for example ``"blade_1"``, shape (n,)."""
        return _find_entities("physical volume", self.cell_tags, self.cell_names, name)

    def facets(self, name: str) -> NDArray[np.int32]:
        """Local facets of a physical surface, for example ``"root_1"``, shape (n,)."""
        return _find_entities("physical surface", self.facet_tags, self.facet_names, name)


def _find_entities(kind: str, tags: Any, numbers: dict[str, int], name: str) -> NDArray[np.int32]:
    """Local numbers of what is in a group."""
    if name not in numbers:
        known = ", ".join(numbers) or "none"
        raise MeshError(f"the mesh has no {kind} {name!r}; it has {known}")
    return np.asarray(tags.find(numbers[name]), dtype=np.int32)


def load_msh(
    comm: MPI.Intracomm,
    path: str | os.PathLike[str],
    volumes: Sequence[str] = (),
    surfaces: Sequence[str] = (),
    check: Callable[[MeshArrays], Sequence[str]] | None = None,
) -> LoadedMesh:
    """Read a mesh on rank 0 and distribute it once over all ranks.

    Only what is in a physical group becomes part of the mesh.

    Args:
        comm: Communicator of the mesh.
        path: A .msh file of any MSH version that the installed gmsh reads.
        volumes: Names of physical volumes that must exist.
        surfaces: Names of physical surfaces that must exist.
        check: Finds what else is wrong with the mesh, one sentence each; called on rank 0.

    Returns:
        The mesh with its groups.

    Raises:
        MeshError: on every rank, if the file is missing, is no mesh of hexahedra or tetrahedra,
            lacks a group, has inverted cells or does not pass the check; one sentence for each.

    Note:
        Collective over ``comm``.
    """
    return load_arrays(
        comm, lambda: read_msh(Path(path), volumes, surfaces), f"mesh file '{path}'", check
    )


def load_arrays(
    comm: MPI.Intracomm,
    make: Callable[[], MeshArrays],
    name: str,
    check: Callable[[MeshArrays], Sequence[str]] | None = None,
) -> LoadedMesh:
    """Make a mesh on rank 0 and distribute it once over all ranks.

    Args:
        comm: Communicator of the mesh.
        make: Makes it; called on rank 0.
        name: What it is called in errors.
        check: As in `load_msh`.

    Returns:
        The mesh with its groups.

    Raises:
        MeshError: on every rank, if the mesh has inverted cells or does not pass the check, one
            sentence for each; and whatever ``make`` raises.

    Note:
        Collective over ``comm``.
    """
    kept: list[MeshArrays] = []  # the arrays stay on rank 0, only what follows is sent to all

    def examine() -> tuple[
        ReferenceCell, dict[str, int], dict[str, int], MeshReport, dict[str, Array]
    ]:
        arrays = make()
        report = arrays.examine()
        mistakes = [*report.mistakes, *(check(arrays) if check else ())]
        if mistakes:
            raise MeshError("\n".join(f"{name}: {mistake}" for mistake in mistakes))
        kept.append(arrays)
        return arrays.reference, arrays.volumes, arrays.surfaces, report, arrays.cell_data

    reference, cell_names, facet_names, report, data = on_rank0(comm, examine)
    arrays = kept[0] if kept else MeshArrays.empty(reference)
    mesh, cell_tags, facet_tags = _distribute(comm, arrays)
    loaded = LoadedMesh(mesh, cell_tags, facet_tags, cell_names, facet_names, report)
    rows = loaded.original_cells
    return replace(loaded, cell_data={name: values[rows] for name, values in data.items()})


def _distribute(comm: MPI.Intracomm, arrays: MeshArrays) -> tuple[Any, Any, Any]:
    """Turn the arrays of all ranks into a distributed mesh with cell and facet tags."""
    # imported here, so that a mesh can be described and built without loading DOLFINx
    from turbine_fenicsx._compat import mesh_of_arrays, tags_of_entities

    reference = arrays.reference
    ranks = _share_out(comm, arrays)
    cell = reference.cell, reference.degree
    mesh = mesh_of_arrays(comm, *cell, arrays.points, arrays.cells, ranks)
    tags = [
        tags_of_entities(mesh, entity, nodes, groups.astype(np.int32))
        for entity, nodes, groups in (
            (reference.cell, arrays.cells, arrays.cell_groups),
            (reference.facet, arrays.facets, arrays.facet_groups),
        )
    ]
    return mesh, tags[0], tags[1]


def _share_out(comm: MPI.Intracomm, arrays: MeshArrays) -> Any:
    """`list_ranks` of the cells that this rank has; None on all ranks if DOLFINx decides."""
    from turbine_fenicsx.meshing.load import list_ranks, share_equal_components

    if comm.size == 1:
        return None
    found: list[NDArray[np.int32] | None] = [np.empty(0, dtype=np.int32)]

    def share() -> bool:
        found[0] = share_equal_components(arrays.points, arrays.cells, comm.size)
        return found[0] is not None

    decided = on_rank0(comm, share)
    return list_ranks(arrays.cells, found[0]) if decided and found[0] is not None else None

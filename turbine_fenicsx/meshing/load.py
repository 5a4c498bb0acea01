"""Load a .msh file as a distributed DOLFINx mesh with named groups."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.meshing.cells import ReferenceCell
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.read import read_msh

if TYPE_CHECKING:  # meshes can be looked at without DOLFINx
    from dolfinx.mesh import Mesh


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
    from turbine_fenicsx.meshing.parts import list_ranks, share_equal_components

    if comm.size == 1:
        return None
    found: list[NDArray[np.int32] | None] = [np.empty(0, dtype=np.int32)]

    def share() -> bool:
        found[0] = share_equal_components(arrays.points, arrays.cells, comm.size)
        return found[0] is not None

    decided = on_rank0(comm, share)
    return list_ranks(arrays.cells, found[0]) if decided and found[0] is not None else None

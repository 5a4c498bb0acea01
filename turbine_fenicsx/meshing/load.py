"""From a .msh file, our own or the user's, to a distributed DOLFINx mesh with named groups."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.read import read_msh
from turbine_fenicsx.meshing.session import gmsh_session, interrupts_kept
from turbine_fenicsx.parallel import on_rank0


@dataclass(frozen=True)
class LoadedMesh:
    """A distributed mesh with the named groups of its file.

    Attributes:
        mesh: The mesh (``dolfinx.mesh.Mesh``).
        cell_tags: Number of the physical volume of each cell (mesh tags).
        facet_tags: Number of the physical surface of each grouped face (mesh tags).
        cell_names: Numbers in ``cell_tags`` by name.
        facet_names: Numbers in ``facet_tags`` by name.
        report: Numbers of nodes and cells, volumes and worst quality of the whole mesh.
    """

    mesh: Any
    cell_tags: Any
    facet_tags: Any
    cell_names: dict[str, int]
    facet_names: dict[str, int]
    report: MeshReport


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
    kept: list[MeshArrays] = []  # the arrays stay on rank 0, only what follows is sent to all

    def read() -> tuple[dict[str, int], dict[str, int], MeshReport]:
        arrays = read_msh(Path(path), volumes, surfaces)
        report = arrays.examine()
        mistakes = [*report.mistakes, *(check(arrays) if check else ())]
        if mistakes:
            raise MeshError("\n".join(f"mesh file '{path}': {mistake}" for mistake in mistakes))
        kept.append(arrays)
        return arrays.volumes, arrays.surfaces, report

    cell_names, facet_names, report = on_rank0(comm, read)
    mesh, cell_tags, facet_tags = _distribute(comm, kept)
    return LoadedMesh(mesh, cell_tags, facet_tags, cell_names, facet_names, report)


def _distribute(comm: MPI.Intracomm, kept: list[MeshArrays]) -> tuple[Any, Any, Any]:
    """Turn the arrays of rank 0 into a distributed mesh with cell and facet tags."""
    # imported here, so that a mesh can be described and built without loading DOLFINx
    from turbine_fenicsx._compat import gmsh_model_to_mesh

    if not kept:
        with interrupts_kept():  # DOLFINx imports gmsh
            return gmsh_model_to_mesh(None, comm)
    with gmsh_session() as gmsh:
        kept[0].add_to(gmsh.model)
        return gmsh_model_to_mesh(gmsh.model, comm)

"""Read a .msh file into arrays, with one sentence for every mistake in it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.files import open_regular
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing.block import face_keys
from turbine_fenicsx.meshing.cell_data import pick_cell_data
from turbine_fenicsx.meshing.cells import REFERENCE_CELLS, ReferenceCell
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.gmsh_process import Group, MshContent, read_content
from turbine_fenicsx.meshing.model import MeshArrays

FARTHEST = 1e7
"""No node of a mesh is farther away [m]."""


def read_msh(path: Path, volumes: Sequence[str], surfaces: Sequence[str]) -> MeshArrays:
    """Read the physical volumes and surfaces of a file, on the calling rank only.

    Args:
        path: A .msh file.
        volumes: Names of physical volumes that must exist.
        surfaces: Names of physical surfaces that must exist.

    Returns:
        The mesh; nodes that no cell uses are dropped, the others keep their order.

    Raises:
        MeshError: with one sentence about what is wrong with the file.
    """
    check_header(path)
    try:
        content = read_content(path)
        solids, shells, names = content.solids, content.shells, content.names
        if not content.has_cells:
            raise MeshError(
                "it holds no volume elements"
                + (f", its highest dimension is {content.highest}" if content.highest >= 0 else "")
            )
        _require(solids, shells, volumes, surfaces)
        reference = _choose_reference(solids, names)
        cells, cell_groups = _join(solids, reference.gmsh_type, "volume", names)
        facets, facet_groups = _join(shells, reference.gmsh_facet_type, "surface", names)
        used, cells = np.unique(cells, return_inverse=True)
        cells = cells.reshape(-1, len(reference.nodes))
        facets = _renumber(facets.reshape(-1, reference.faces.shape[1]), used)
        is_face = np.isin(
            face_keys(np.maximum(facets, 0), reference),
            face_keys(cells[:, reference.faces].reshape(-1, facets.shape[1]), reference),
        )
        stray = np.count_nonzero(~is_face | (facets < 0).any(axis=1))
        if stray:
            raise MeshError(f"{stray} elements of its physical surfaces are not faces of any cell")
        points = _read_points(content, used)
    except MeshError as error:
        raise MeshError(f"mesh file '{path}': {error}") from error
    kind = reference.gmsh_type
    elements = np.concatenate([group.elements[kind] for group in solids])
    return MeshArrays(
        reference=reference,
        points=points,
        cells=cells,
        cell_groups=cell_groups,
        facets=facets,
        facet_groups=facet_groups,
        volumes={group.name: group.tag for group in solids},
        surfaces={group.name: group.tag for group in shells},
        cell_data=pick_cell_data(content.cell_data, elements),
    )


def check_header(path: Path) -> None:
    """Raise MeshError unless the file exists and begins like an MSH file.

    Anything else gmsh would run as a script.
    """
    try:
        with open_regular(path) as file:
            start = file.read(64)
    except OSError as error:
        raise MeshError(f"cannot read the mesh file {str(path)!r}: {error.strerror}") from error
    if path.suffix != ".msh" or not start.startswith((b"$MeshFormat", b"$Comments")):
        raise MeshError(f"'{path}' is not a mesh in gmsh's .msh format")


def _require(
    solids: list[Group], shells: list[Group], volumes: Sequence[str], surfaces: Sequence[str]
) -> None:
    """Raise MeshError if a group is missing or two have the same name."""
    missing, found = [], []
    for groups, required, kind in ((solids, volumes, "volume"), (shells, surfaces, "surface")):
        names = [group.name for group in groups]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise MeshError(f"it has more than one physical {kind} called {_quote(twice)}")
        lacking = [name for name in required if name not in names]
        if lacking:
            missing.append(f"the physical {_count_names(kind, lacking)}")
        found.append(f"the {_count_names(kind, sorted(names))}" if names else f"no {kind}")
    if not solids and not missing:
        missing.append("a physical volume")
    if missing:
        raise MeshError(f"it lacks {' and '.join(missing)}; it has {' and '.join(found)}")


def _choose_reference(solids: list[Group], names: dict[int, str]) -> ReferenceCell:
    """Return the element type of all cells, or raise MeshError if there is more than one."""
    kinds = sorted({kind for group in solids for kind in group.elements})
    supported = {reference.gmsh_type: reference for reference in REFERENCE_CELLS}
    if len(kinds) == 1 and kinds[0] in supported:
        return supported[kinds[0]]
    raise MeshError(
        f"its volume elements are {_quote(names[kind] for kind in kinds)}; all must be of one "
        "type: tetrahedra with 4 or 10 or hexahedra with 8 or 27 nodes"
    )


def _join(
    groups: list[Group], kind: int, what: str, names: dict[int, str]
) -> tuple[IntArray, IntArray]:
    """Return the nodes of all elements in one row and the group of each element."""
    for group in groups:
        wrong = [names[other] for other in group.elements if other != kind]
        if wrong:
            raise MeshError(
                f"its physical {what} '{group.name}' holds {_quote(wrong)}, which are not faces "
                "of its volume elements"
            )
    none = np.empty(0, dtype=np.int64)
    elements = np.concatenate([none, *(group.elements[kind] for group in groups)])
    tags = [np.full(len(group.elements[kind]), group.tag) for group in groups]
    _, first = np.unique(elements, return_index=True)
    if len(first) < len(elements):
        labels = np.concatenate([none, *(np.full_like(t, i) for i, t in enumerate(tags))])
        doubled = np.setdiff1d(np.arange(len(elements)), first)
        shared = np.isin(elements, elements[doubled])
        both = sorted(groups[i].name for i in np.unique(labels[shared]))
        raise MeshError(
            f"its physical {what}s {_quote(both)} share {len(doubled)} elements; an element may "
            f"be in one physical {what} only"
        )
    nodes = np.concatenate([none, *(group.nodes[kind] for group in groups)])
    return nodes, np.concatenate([none, *tags])


def _read_points(content: MshContent, used: IntArray) -> Array:
    """Return the coordinates of the nodes in the sorted array ``used``."""
    order = np.argsort(content.tags)
    rows = np.searchsorted(content.tags, used, sorter=order)
    rows = order[np.minimum(rows, len(order) - 1)]
    lacking = np.count_nonzero(content.tags[rows] != used)
    if lacking:
        raise MeshError(f"{lacking} nodes of its cells are not in it")
    points: Array = content.points[rows]
    wild = np.flatnonzero(~(np.abs(points) <= FARTHEST).all(axis=1))
    if len(wild):
        raise MeshError(
            f"{len(wild)} of its nodes have coordinates that are not finite or beyond "
            f"{FARTHEST:g} m, the first is node {used[wild[0]]}"
        )
    return points


def _renumber(nodes: IntArray, used: IntArray) -> IntArray:
    """Return the positions of nodes in the sorted array ``used``, -1 for those not in it."""
    position = np.minimum(np.searchsorted(used, nodes), len(used) - 1)
    return np.where(used[position] == nodes, position, -1)


def _count_names(kind: str, names: list[str]) -> str:
    """Return "volume 'a'" or "volumes 'a', 'b'"."""
    return f"{kind}{'s' if len(names) > 1 else ''} {_quote(names)}"


def _quote(names: Any) -> str:
    """Return names in quotes, separated by commas."""
    return ", ".join(f"'{name}'" for name in names)

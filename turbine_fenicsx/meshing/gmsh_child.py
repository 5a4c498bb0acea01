"""Program that reads a .msh file with gmsh and writes its groups to a .npz file.

Damaged files crash gmsh, so the process that wants the mesh starts this one, see `gmsh_process`.
It imports nothing of the package, to start fast and to leave MPI alone.

    python gmsh_child.py MESH.msh GROUPS.npz
"""

import json
import os
import resource
import sys
from typing import Any

import numpy as np

NO_GMSH = 3
"""Exit code where gmsh cannot be loaded; 1 for all else, with the reason on stderr."""


def read_groups(gmsh: Any, path: str) -> dict[str, Any]:
    """Read the physical volumes and surfaces of a file.

    Args:
        gmsh: The module, initialised, with an empty model.

    Returns:
        ``tags`` and ``coordinates`` of all nodes. ``info``, a JSON text: the highest dimension of
        the model, whether it has volume elements, the names of element types and of views with a
        number for each element. For each group with elements it has dimension, tag, name and
        element types. For group i and type k the arrays ``elements_i_k`` and ``nodes_i_k``; for
        view i ``view_tags_i`` and ``view_values_i``.
    """
    gmsh.merge(path)
    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    arrays: dict[str, Any] = {"tags": tags.astype(np.int64), "coordinates": coordinates}
    groups: list[tuple[int, int, str, list[int]]] = []
    names = {}
    for dimension, tag in (*gmsh.model.getPhysicalGroups(3), *gmsh.model.getPhysicalGroups(2)):
        found: dict[int, list[tuple[Any, Any]]] = {}
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
            for kind, *numbers in zip(*mesh.getElements(dimension, entity), strict=True):
                found.setdefault(int(kind), []).append(tuple(numbers))
        if not found:
            continue
        for kind, parts in found.items():
            names[kind] = mesh.getElementProperties(kind)[0]
            for what, some in zip(("elements", "nodes"), zip(*parts, strict=True), strict=True):
                arrays[f"{what}_{len(groups)}_{kind}"] = np.concatenate(some).astype(np.int64)
        name = gmsh.model.getPhysicalName(dimension, tag) or f"unnamed_{tag}"
        groups.append((dimension, int(tag), name, sorted(found)))
    views: list[str] = []
    for view in gmsh.view.getTags():
        name = gmsh.option.getString(f"View[{gmsh.view.getIndex(view)}].Name")
        kind, tags, values, _, components = gmsh.view.getHomogeneousModelData(view, 0)
        if kind == "ElementData" and components == 1:
            arrays[f"view_tags_{len(views)}"] = np.asarray(tags, dtype=np.int64)
            arrays[f"view_values_{len(views)}"] = np.asarray(values, dtype=float)
            views.append(name)
    info = {
        "views": views,
        "highest": next((d for d in (3, 2, 1, 0) if len(mesh.getElementTypes(d))), -1),
        "has_cells": any(len(kinds) > 0 for kinds in mesh.getElements(3)[:1]),
        "names": names,
        "groups": groups,
    }
    return {**arrays, "info": json.dumps(info)}


def main(path: str, groups: str) -> int:
    """Read one file and write the other; nothing that gmsh asks for exceeds the computer."""
    try:
        import gmsh
    except (ImportError, OSError) as error:  # OSError: the module without its shared library
        print(error, file=sys.stderr)
        return NO_GMSH
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = memory if hard == resource.RLIM_INFINITY else min(memory, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    try:
        np.savez(groups, **read_groups(gmsh, path))
    except MemoryError:
        print("its mesh does not fit into the memory", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"cannot write its groups to {groups!r}: {error.strerror}", file=sys.stderr)
        return 1
    except Exception as error:  # gmsh raises nothing more specific
        print(f"gmsh reports: {str(error).strip() or 'unknown error'}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    code = main(*sys.argv[1:])
    sys.stderr.flush()
    os._exit(code)  # the system tidies up faster than gmsh

"""The mesh of a whole rotor: copies of one blade, written to a file of gmsh's MSH format."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from uuid import uuid4

import numpy as np

from turbine_fenicsx.meshing import hexahedra, tetrahedra
from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.block import BladeBlock
from turbine_fenicsx.meshing.cell_data import write_cell_data
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.hollow import mesh_hollow
from turbine_fenicsx.meshing.hollow_shape import EllipticShape
from turbine_fenicsx.meshing.model import MeshArrays
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.quality import MeshReport
from turbine_fenicsx.meshing.session import gmsh_session

_MSH_OPTIONS = {
    "Mesh.MshFileVersion": 4.1,
    "Mesh.Binary": 0,
    "Mesh.SaveAll": 0,
    "PostProcessing.SaveMesh": 0,
}


def build_rotor(
    blade: BladeGeometry, layout: RotorLayout, options: MeshOptions, path: str | os.PathLike[str]
) -> MeshReport:
    """Mesh the blades of a rotor and write them to a file.

    Call it on one rank only. All blades have the same mesh, turned into their place. The physical
    volumes are called ``blade_1``, ``blade_2``, ..., the surface of each at the hub ``root_1``, ...
    and the rest of its surface, tip included, ``skin_1``, ...

    Args:
        blade: Shape of a blade.
        layout: Positions of the blades.
        options: Cell type, geometry degree and fineness.
        path: File to write, with the ending .msh; an existing file is replaced at the end.

    Returns:
        Numbers of nodes and cells, volumes and worst quality.

    Raises:
        ModelError: if two blades overlap.
        MeshError: if gmsh fails, the file cannot be written, or a cell is inverted.
    """
    return write_rotor(lambda: mesh_rotor(blade, layout, options), path)


def write_rotor(make: Callable[[], MeshArrays], path: str | os.PathLike[str]) -> MeshReport:
    """Mesh the blades of a rotor and write them to a file, see `build_rotor`."""
    target = Path(path)
    _check_writable(target)
    arrays = make()
    report = arrays.examine()
    if report.bad_cells:
        raise MeshError(
            f"{report.bad_cells} of {report.cells} cells came out inverted or degenerate; choose "
            "other numbers of elements"
        )
    write_msh(arrays, target)
    return report


def mesh_rotor(blade: BladeGeometry, layout: RotorLayout, options: MeshOptions) -> MeshArrays:
    """Mesh the blades of a rotor.

    The arguments are those of `build_rotor`.

    Returns:
        The mesh with groups numbered like the blades: volume k is blade_k, surface 2k-1 is root_k
        and surface 2k is skin_k.
    """
    layout.check_clearance(blade.hub_radius, max(blade.chord[0], blade.thickness[0]) / 2)
    return place_blades(_mesh_blade(blade, options), layout)


def place_blades(block: BladeBlock, layout: RotorLayout) -> MeshArrays:
    """Copies of one blade, each turned into its place; cells and nodes blade after blade.

    Args:
        block: The blade.
        layout: Positions of the blades.

    Returns:
        The mesh with groups numbered as in `mesh_rotor`.
    """
    n = layout.n_blades
    facets = np.concatenate([block.root, block.skin])
    is_skin = np.repeat([0, 1], [len(block.root), len(block.skin)])
    shift = [k * len(block.points) for k in range(n)]
    return MeshArrays(
        reference=block.reference,
        points=np.concatenate([layout.place(block.points, k + 1) for k in range(n)]),
        cells=np.concatenate([block.cells + s for s in shift]),
        cell_groups=np.repeat(np.arange(1, n + 1), len(block.cells)),
        facets=np.concatenate([facets + s for s in shift]),
        facet_groups=np.concatenate([2 * k + 1 + is_skin for k in range(n)]),
        volumes={name: k + 1 for k, name in enumerate(layout.volume_groups)},
        surfaces={name: k + 1 for k, name in enumerate(layout.surface_groups)},
        cell_data={name: np.tile(values, n) for name, values in block.cell_data.items()},
    )


def write_msh(arrays: MeshArrays, path: Path) -> None:
    """Write a mesh to an MSH 4.1 file; a file of that name exists complete or not at all.

    Args:
        arrays: The mesh.
        path: The file, with the ending .msh.

    Raises:
        MeshError: if gmsh fails or the file cannot be written.
    """
    _check_writable(path)
    temporary = path.with_name(f".{path.stem}.{uuid4().hex[:8]}.msh")
    try:
        with gmsh_session(_MSH_OPTIONS) as gmsh:
            arrays.add_to(gmsh.model)
            gmsh.write(str(temporary))
            write_cell_data(gmsh, arrays, str(temporary))
        os.replace(temporary, path)
    except OSError as error:
        raise MeshError(f"cannot write the mesh to '{path}': {error.strerror}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _mesh_blade(blade: BladeGeometry, options: MeshOptions) -> BladeBlock:
    """Mesh one blade in its own frame."""
    if blade.wall is not None:
        return mesh_hollow(EllipticShape(blade), options.span, options.around)
    degree = options.geometry_degree
    if options.cell == "hexahedron":
        block = hexahedra.mesh_blade(blade, options.hexahedra(blade), degree)
    else:
        block = tetrahedra.mesh_blade(blade, options.edge_lengths(blade), degree)
    return replace(block, points=blade.turn(block.points))


def _check_writable(path: Path) -> None:
    """Raise MeshError unless a mesh file may be created at this path."""
    if path.suffix != ".msh":
        raise MeshError(f"cannot write the mesh to '{path}': the name must end with .msh")
    if not path.parent.is_dir():
        raise MeshError(f"cannot write the mesh to '{path}': no such directory")
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise MeshError(f"cannot write the mesh to '{path}': permission denied")

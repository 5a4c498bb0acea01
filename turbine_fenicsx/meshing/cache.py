"""Cache of meshes, found by a hash of everything they depend on."""

import hashlib
import json
import os
from dataclasses import asdict
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.rotor import build_rotor
from turbine_fenicsx.meshing.session import gmsh_version

# To be raised by one with every change of the mesh that the same parameters give.
GENERATOR_VERSION = 1


def cache_mesh(
    comm: MPI.Intracomm,
    blade: BladeGeometry,
    layout: RotorLayout,
    options: MeshOptions,
    directory: str | os.PathLike[str] | None = None,
) -> Path:
    """Return the file with the mesh of a rotor, which is built only if it does not exist yet.

    Args:
        comm: Communicator; rank 0 builds and the others wait.
        blade: Shape of a blade.
        layout: Positions of the blades.
        options: Cell type, geometry degree and fineness.
        directory: Where to keep meshes; by default `cache_directory`.

    Returns:
        The file.

    Raises:
        MeshError: on every rank, if the mesh cannot be built or written.

    Note:
        Collective over ``comm``.
    """

    def find_or_build() -> Path:
        folder = Path(directory) if directory is not None else cache_directory()
        path = folder / f"{mesh_hash(blade, layout, options)}.msh"
        if not path.is_file():
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise MeshError(
                    f"cannot create the mesh cache '{folder}': {error.strerror}"
                ) from error
            build_rotor(blade, layout, options, path)
        return path

    return on_rank0(comm, find_or_build)


def cache_directory() -> Path:
    """Return ``$XDG_CACHE_HOME/turbine_fenicsx/meshes``, with ``~/.cache`` if that is not set."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "turbine_fenicsx" / "meshes"


def mesh_hash(blade: BladeGeometry, layout: RotorLayout, options: MeshOptions) -> str:
    """Return a name made of everything that the mesh of a rotor depends on.

    These are all parameters, the version of gmsh and `GENERATOR_VERSION`.
    """
    key = {
        "blade": asdict(blade),
        "layout": asdict(layout),
        "options": asdict(options),
        "gmsh": gmsh_version(),
        "generator": GENERATOR_VERSION,
    }
    text = json.dumps(key, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]

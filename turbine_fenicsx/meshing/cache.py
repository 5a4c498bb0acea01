"""Cache of meshes, found by a hash of everything they depend on; damaged ones are built anew.

The last lines of each file hold a checksum of all before, as a comment of the MSH format.
"""

import hashlib
import json
import logging
import os
from dataclasses import asdict
from pathlib import Path
from uuid import uuid4

from mpi4py import MPI

from turbine_fenicsx.foundation.files import sync_file, sync_folder
from turbine_fenicsx.foundation.own_folder import describe_stranger
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.meshing.blade import BladeGeometry, RotorLayout
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.options import MeshOptions
from turbine_fenicsx.meshing.rotor import build_rotor
from turbine_fenicsx.meshing.session import gmsh_version

# To be raised by one with every change of the mesh that the same parameters give.
GENERATOR_VERSION = 2

log = logging.getLogger(__name__)


def cache_mesh(
    comm: MPI.Intracomm,
    blade: BladeGeometry,
    layout: RotorLayout,
    options: MeshOptions,
    directory: str | os.PathLike[str] | None = None,
) -> Path:
    """Return the file with the mesh of a rotor, which is built only if it is not there or damaged.

    Args:
        comm: Communicator; rank 0 builds and the others wait.
        blade: Shape of a blade.
        layout: Positions of the blades.
        options: Cell type, geometry degree and fineness.
        directory: Where to keep meshes; by default `cache_directory`.

    Returns:
        The file.

    Raises:
        MeshError: on every rank, if the mesh cannot be built or written, or others may write to
            the folder.

    Note:
        Collective over ``comm``.
    """

    def find_or_build() -> Path:
        folder = Path(directory) if directory is not None else cache_directory()
        path = folder / f"{mesh_hash(blade, layout, options)}.msh"
        for place in (folder, path):
            wrong = describe_stranger(place)
            if wrong:
                raise MeshError(
                    f"the cache of meshes '{place}' {wrong}; or set XDG_CACHE_HOME to a folder of "
                    "your own"
                )
        if not path.is_file() or not _is_whole(path):
            _build(blade, layout, options, path)
        return path

    return on_rank0(comm, find_or_build)


def _build(blade: BladeGeometry, layout: RotorLayout, options: MeshOptions, path: Path) -> None:
    """Build a mesh and let it take its place with its checksum once it is on the disk."""
    if path.is_file():
        log.warning("the mesh %s of the cache is damaged; it is built anew", path)
    temporary = path.with_name(f".{uuid4().hex}.msh")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MeshError(
            f"cannot create the mesh cache '{path.parent}': {error.strerror}"
        ) from error
    try:
        build_rotor(blade, layout, options, temporary)
        with temporary.open("r+b") as file:
            file.write(_seal(file.read()))
        sync_file(temporary)
        os.replace(temporary, path)
        sync_folder(path.parent)
    except OSError as error:
        raise MeshError(f"cannot write the mesh to '{path}': {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _is_whole(path: Path) -> bool:
    """Whether a mesh of the cache is what was written."""
    try:
        content = path.read_bytes()
    except OSError:
        return False
    length = len(_seal(b""))
    return content[-length:] == _seal(content[:-length])


def _seal(content: bytes) -> bytes:
    """A comment of the MSH format with the checksum of a file, to end it."""
    return f"$Comments\nsha256 {hashlib.sha256(content).hexdigest()}\n$EndComments\n".encode()


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

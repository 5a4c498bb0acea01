"""Read a file with gmsh in a separate process, because damaged files crash it."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.interrupts import end_immediately
from turbine_fenicsx.foundation.mpi_environment import environment_without_mpi
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.meshing import gmsh_child
from turbine_fenicsx.meshing.errors import MeshError
from turbine_fenicsx.meshing.session import how_to_install

PATIENCE = 120.0
"""Time in which gmsh must have read a small file [s]."""

SLOWEST = 1e5
"""Large files may take longer, with so much read in a second [bytes/s]; 20 MB/s are common."""


@dataclass(frozen=True)
class Group:
    """A physical group of a file: elements of one or more types.

    Attributes:
        elements: gmsh's number of each element by element type.
        nodes: gmsh's numbers of the nodes of each element by element type.
    """

    name: str
    tag: int
    elements: dict[int, IntArray]
    nodes: dict[int, IntArray]


@dataclass(frozen=True)
class MshContent:
    """Contents of a .msh file.

    Attributes:
        tags: gmsh's number of each node, shape (n,).
        points: Coordinates of the nodes, shape (n, 3) [m].
        highest: Highest dimension of an entity; -1 if there is none.
        has_cells: Whether there are volume elements, in a group or not.
        cell_data: Numbers of elements and a value of each, by name of the data.
    """

    tags: IntArray
    points: Array
    solids: list[Group]
    shells: list[Group]
    names: dict[int, str]
    highest: int
    has_cells: bool
    cell_data: dict[str, tuple[IntArray, Array]]


def read_content(path: Path) -> MshContent:
    """Read a file on the calling rank only.

    Files that lie beside it, which gmsh would run as scripts, are out of its sight.

    Args:
        path: A file that begins like an MSH file; anything else gmsh would run as a script.
    """
    with tempfile.TemporaryDirectory(prefix="turbine_fenicsx_") as folder:
        Path(folder, "mesh.msh").symlink_to(path.resolve())
        _run(folder, PATIENCE + path.stat().st_size / SLOWEST)
        with np.load(Path(folder, "groups.npz")) as arrays:
            return _unpack(dict(arrays))


def _run(folder: str, seconds: float) -> None:
    """Run the child in its folder to its end."""
    environment = environment_without_mpi()
    environment["PYTHONPATH"] = os.pathsep.join(map(os.path.abspath, sys.path))
    command = [sys.executable, "-P", str(gmsh_child.__file__), "mesh.msh", "groups.npz"]
    with (
        end_immediately(),
        subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        ) as child,
    ):
        try:
            _, errors = child.communicate(timeout=seconds)
        except BaseException as error:
            child.kill()
            child.wait()
            if isinstance(error, subprocess.TimeoutExpired):
                raise MeshError(f"gmsh has not read it within {seconds:.0f} s") from None
            raise
    text = errors.decode(errors="replace").strip()
    if child.returncode == gmsh_child.NO_GMSH:
        raise MeshError(how_to_install(text))
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        raise MeshError(
            f"gmsh crashes when it reads it ({name}): it is damaged, or too large for the memory"
        )
    if child.returncode:
        raise MeshError(text.splitlines()[-1] if text else "gmsh cannot read it")


def _unpack(arrays: dict[str, npt.NDArray[Any]]) -> MshContent:
    """The arrays of the child in order."""
    info = json.loads(str(arrays["info"]))
    groups: dict[int, list[Group]] = {3: [], 2: []}
    for i, (dimension, tag, name, kinds) in enumerate(info["groups"]):
        elements, nodes = (
            {kind: arrays[f"{what}_{i}_{kind}"] for kind in kinds} for what in ("elements", "nodes")
        )
        groups[dimension].append(Group(name, tag, elements, nodes))
    return MshContent(
        arrays["tags"],
        arrays["coordinates"].reshape(-1, 3),
        groups[3],
        groups[2],
        {int(kind): name for kind, name in info["names"].items()},
        info["highest"],
        info["has_cells"],
        {
            name: (arrays[f"view_tags_{i}"], arrays[f"view_values_{i}"])
            for i, name in enumerate(info["views"])
        },
    )

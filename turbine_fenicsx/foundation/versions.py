"""Versions of the software behind a result; works where half of it is missing."""

from __future__ import annotations

import os
import platform
import sys
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from turbine_fenicsx._version import __version__

PACKAGES = (
    *("fenics-dolfinx", "dolfinx-solver-real", "fenics-ufl", "fenics-ffcx"),
    *("numpy", "gmsh", "petsc4py", "mpi4py"),
)


def list_versions() -> dict[str, str]:
    """Versions of everything that matters for a result, as far as it is installed."""
    found = {"turbine_fenicsx": __version__, "python": platform.python_version()}
    with suppress(ImportError):
        from mpi4py import MPI
        from petsc4py import PETSc

        found["petsc"] = ".".join(map(str, PETSc.Sys.getVersion()))
        found["mpi"] = MPI.Get_library_version().split(",")[0].split("\n")[0].strip("\x00 ")
    for package in PACKAGES:
        with suppress(PackageNotFoundError):
            found[package] = version(package)
    if find_spec("dolfinx"):
        found["stack"] = name_stack()
    return found


def dolfinx_folder() -> str:
    """Where this python finds DOLFINx; empty if it does not."""
    found = find_spec("dolfinx")
    return os.path.dirname(found.origin or "") if found else ""


def name_stack() -> str:
    """Who built the DOLFINx, PETSc and MPI in use: "PyPI", "Debian", "conda" or "own build"."""
    if find_spec("dolfinx_solver"):
        return "PyPI"
    if "/dist-packages" in dolfinx_folder():
        return "Debian"
    return "conda" if Path(sys.prefix, "conda-meta").is_dir() else "own build"


def how_to_install(reason: object) -> str:
    """One sentence for who has no DOLFINx."""
    if sys.version_info >= (3, 12):
        command = f"`{sys.executable} -m pip install dolfinx-solver-real` brings it"
    else:
        command = "`pip install dolfinx-solver-real` brings it to Python 3.12 or newer"
    return (
        f"DOLFINx cannot be used by {sys.executable} ({reason}): {command}, on Debian "
        "`make setup` in the project"
    )

"""A basis in one file, which belongs to one mesh and material."""

from __future__ import annotations

import os
import zipfile
from contextlib import suppress
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.bodies.beam_basis import BeamBasis
from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.foundation.array_file import read_arrays, write_arrays
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.reduction.elasticity import Law
from turbine_fenicsx.reduction.fingerprint import describe_cells, find_difference, find_other_nodes

VERSION = 2
"""Version of the file."""

KINDS: tuple[type[ReducedBasis], ...] = (BeamBasis, ReducedBasis)
"""Kinds of bases; a file holds the arrays of the first one whose arrays are all there."""


def write_basis(path: str | os.PathLike[str], basis: ReducedBasis) -> None:
    """Write a basis to a file, whole or not at all; an old or damaged one is replaced.

    Several ranks have the same basis: let one of them write.

    Args:
        path: The file, ``.npz``; its folder exists.
        basis: The basis.

    Raises:
        InputError: for another ending, or a file with other arrays.
        FileError: if it cannot be written.
    """
    name = os.fspath(path)
    if not name.endswith(".npz"):
        raise InputError(f"cannot write a basis to {name!r}: expected a name that ends with .npz")
    with suppress(OSError, zipfile.BadZipFile), zipfile.ZipFile(path) as archive:
        there = {member.removesuffix(".npy") for member in archive.namelist()}
        if not {"version", "functions"} <= there:  # those of earlier versions may be replaced
            raise InputError(f"{name!r} holds other arrays, which a basis does not replace")
    arrays = {name: getattr(basis, name) for name in _name_arrays(type(basis))}
    write_arrays(path, {"version": np.array(VERSION), **arrays})


def read_basis(path: str | os.PathLike[str], body: FlexibleBody | Carrier) -> ReducedBasis:
    """Read the basis of a body from a file.

    Args:
        path: A file of `write_basis`.
        body: The body, with the mesh and material that the basis was made of, or the carrier of a
            beam.

    Raises:
        InputError: for a file that is not a basis, or that of another mesh, material or density, on
            all ranks.
        FileError: if it cannot be read, on all ranks.

    Note:
        Collective.
    """
    name, comm = os.fspath(path), body.mesh.comm
    arrays = on_rank0(comm, lambda: _read_arrays(name))
    basis = _make(name, arrays)
    space = _compat.vector_space(body.mesh, body.degree)
    nodes = space.dofmap.index_map.size_global
    if isinstance(basis, BeamBasis) != isinstance(body, Carrier):
        kind = "a beam" if isinstance(basis, BeamBasis) else "a body of a material"
        difference = f"but of {kind}"
    elif isinstance(body, Carrier):
        difference = find_other_nodes(basis, body.mesh.comm, space)
    else:
        difference = find_difference(basis, describe_cells(body, Law(body)), nodes)
    if difference:
        raise InputError(
            f"{name!r} is not a basis of {body.name!r}, {difference}: reduce the body anew"
        )
    return basis


class BasisSizes(NamedTuple):
    """Sizes of a basis in a file.

    Attributes:
        nodes: Number of nodes of the mesh.
        functions: Number of functions besides those of the interfaces.
        strains: Number of strain coordinates.
    """

    nodes: int
    functions: int
    strains: int


def read_sizes(path: str | os.PathLike[str]) -> BasisSizes:
    """Sizes of a basis in a file, without its body; on one rank."""
    name = os.fspath(path)
    basis = _make(name, _read_arrays(name))
    return BasisSizes(len(basis.points), basis.size, basis.strain_factor.shape[1])


def _name_arrays(kind: type[ReducedBasis]) -> tuple[str, ...]:
    """Arrays of the file of a kind of basis, besides the version."""
    return tuple(field.name for field in fields(kind))


def _make(name: str, arrays: dict[str, Any]) -> ReducedBasis:
    """The basis of the arrays of a file."""
    kind = next(kind for kind in KINDS if set(_name_arrays(kind)) <= set(arrays))
    try:
        return kind(**arrays)
    except ModelError as error:
        raise InputError(f"{name!r} is damaged: {error}") from None


def _read_arrays(path: str) -> dict[str, Any]:
    """The arrays of a file."""
    what = "a basis of a reduced body"
    arrays = read_arrays(path, what)
    version = arrays.get("version")
    if version is not None and version.shape == () and version != VERSION:
        raise InputError(
            f"{path!r} is a basis of version {version}, and this is version {VERSION}: "
            "reduce the body anew"
        )
    expected = next((names for k in KINDS if set(names := _name_arrays(k)) <= set(arrays)), ())
    numbers = all(arrays[name].dtype.kind in "biuf" for name in expected)
    if version is None or not expected or not numbers:
        raise InputError(f"{path!r} is not {what}, or damaged")
    return {name: arrays[name] for name in expected}

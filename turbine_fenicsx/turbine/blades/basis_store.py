"""Where bases of reduced bodies are kept: the file of a case, or a folder beside it."""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.files import name_file_in_errors
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.reduction.basis_file import VERSION, read_basis, write_basis
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.tables.reduction import FOLDER

log = logging.getLogger(__name__)


def take_basis(
    path: Path | None, body: FlexibleBody, make: Callable[[], ReducedBasis]
) -> ReducedBasis:
    """A basis from a file if it is there and fits; else one that is made and kept there.

    Args:
        path: The file; None for nowhere.

    Note:
        Collective.
    """
    if on_rank0(body.mesh.comm, lambda: path is not None and path.is_file()):
        assert path is not None
        try:
            return read_basis(path, body)
        except (InputError, FileError) as error:
            log.info("%s; it is replaced", error)
    return keep_basis(path, body, make)


def keep_basis(
    path: Path | None, body: FlexibleBody, make: Callable[[], ReducedBasis]
) -> ReducedBasis:
    """Make a basis and keep it in a file; arguments as of `take_basis`. Collective."""
    comm = body.mesh.comm
    if path is not None:
        on_rank0(comm, partial(_make_folder, path.parent))
    basis = make()
    if path is not None:
        on_rank0(comm, partial(write_basis, path, basis))
        log.info("the basis is kept in %s", path)
    return basis


def name_file(
    case: Case, folder: str | None, body: str, depends_on: Mapping[str, Any]
) -> Path | None:
    """File for a basis of a case; None if there can be none. Called on rank 0.

    Args:
        folder: Where it is kept; None for the folder ``bases`` beside the case.
        depends_on: Everything that the basis depends on, as numbers, texts and tables.
    """
    if folder is None and case.folder is None:
        return None
    kept = Path(folder) if folder is not None else Path(case.folder or ".") / FOLDER
    nearest = kept if kept.exists() else kept.parent
    if not (nearest.is_dir() and os.access(nearest, os.W_OK)):
        log.warning("bases cannot be kept in %s, which is no folder that may be written", kept)
        return None
    text = json.dumps([VERSION, depends_on], sort_keys=True)
    return kept / f"{body}-{hashlib.sha256(text.encode()).hexdigest()[:12]}.npz"


def _make_folder(folder: Path) -> None:
    """Make a folder, unless it is there."""
    with name_file_in_errors("write", folder):
        folder.mkdir(exist_ok=True)

"""The basis of the blades of a case: from a file, from a folder of bases, or made."""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.case.files import hash_files
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.reduction.basis_file import VERSION, read_basis, write_basis
from turbine_fenicsx.reduction.load_path import LoadPath
from turbine_fenicsx.reduction.reduce_body import reduce_body
from turbine_fenicsx.turbine.blades.clamped_blade import ClampedBlade
from turbine_fenicsx.turbine.blades.operating_points import (
    TRAINING,
    OperatingLoads,
    OperatingPoint,
    RatedOperation,
)
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.tables import Tables

log = logging.getLogger(__name__)

FOLDER = "bases"
"""Folder beside the case file in which bases are kept."""

STATIONS = 60
"""Aerodynamic stations along the blade at its operating points."""


def find_basis(case: Case, blade: ClampedBlade) -> ReducedBasis:
    """The basis of the blades of a case. Collective.

    Args:
        case: A case with reduced blades.
        blade: One of the blades.

    Raises:
        InputError: if the file of the case is not a basis of these blades.
        FileError: if it cannot be read.
    """
    comm, file = blade.body.mesh.comm, case.blade.reduction.file
    if file is not None:
        return read_basis(file, blade.body)
    path = on_rank0(comm, lambda: name_basis(case))
    if on_rank0(comm, lambda: path is not None and path.is_file()):
        assert path is not None
        try:
            return read_basis(path, blade.body)
        except (InputError, FileError) as error:
            log.info("%s; it is made anew", error)
    return make_basis(case, blade, path)


def make_basis(case: Case, blade: ClampedBlade, path: Path | None) -> ReducedBasis:
    """Make the basis of the blades of a case. Collective.

    Args:
        case: The case.
        blade: One of the blades.
        path: Where the basis is kept, and its finished load paths beside it; None for nowhere.

    Raises:
        FileError: if it cannot be written.
    """
    comm, r = blade.body.mesh.comm, case.blade.reduction
    paths = None if path is None else path.with_suffix(".paths.npz")
    loads = list_loads(case, blade, TRAINING)
    log.info("making the basis of the blades, %s", describe_training(loads))
    basis = reduce_body(
        blade.system, blade.body, r.modes, r.functions, r.strains, loads, keep=paths
    )
    if path is not None and paths is not None:
        on_rank0(comm, partial(write_basis, path, basis))
        on_rank0(comm, partial(paths.unlink, missing_ok=True))
        log.info("the basis is kept in %s", path)
    return basis


def name_basis(case: Case) -> Path | None:
    """File for the basis of a case in a folder beside it; None if there can be none.

    All that the basis depends on is in the name: shape, layup and mesh of the blades, the files
    that these come from, and the numbers of its table.
    """
    if case.folder is None:
        return None
    folder = case.folder / FOLDER
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        log.warning("bases cannot be kept in %s: %s", folder, error.strerror)
        return None
    if not os.access(folder, os.W_OK):
        log.warning("bases cannot be kept in %s: permission denied", folder)
        return None
    return folder / f"blade-{hash_blade(case)}.npz"


def hash_blade(case: Tables) -> str:
    """Hash of everything in a case that the basis of its blades depends on."""
    data = case.model_dump(
        mode="json",
        include={
            "turbine": {"file"},
            "blade": True,
            "mesh": True,
            "material": True,
            "aero": {"file"},
        },
    )
    for key in ("damping", "model"):
        del data["blade"][key]
    del data["blade"]["reduction"]["file"]
    files = hash_files(data, Tables)
    for table in ("turbine", "mesh", "aero"):  # by content
        data[table]["file"] = data[table]["file"] is not None
    text = json.dumps([VERSION, data, files], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def list_loads(
    case: Case, blade: ClampedBlade, points: Sequence[OperatingPoint]
) -> list[LoadPath] | None:
    """Load paths of the blades at operating points of their turbine. Collective.

    Args:
        case: The case.
        blade: One of the blades.
        points: The operating points.

    Returns:
        None if no file says how the turbine is run; then `reduce_body` takes smooth loads.
    """
    comm = blade.body.mesh.comm
    rated = on_rank0(comm, lambda: _find_rated(case))
    if rated is None:
        return None
    aero = on_rank0(comm, lambda: load_aero_blade(case, STATIONS))
    return OperatingLoads(blade.system, blade.body, aero, rated).list_paths(points)


def describe_training(loads: Sequence[LoadPath] | None) -> str:
    """The loads that a basis is made from, in words."""
    if loads is None:
        return "from smooth loads along the span"
    return f"from {len(loads)} operating points"


def _find_rated(case: Case) -> RatedOperation | None:
    """How the turbine of a file is run; None if it does not say, or has no polars."""
    if case.turbine.file is None:
        return None
    c = load_turbine(case.turbine.file).control
    if c is None or not (c.rated_speed and c.rated_power and c.tip_speed_ratio):
        return None
    try:
        load_aero_blade(case, STATIONS)
    except InputError:
        return None
    return RatedOperation(
        c.least_speed or 0.0,
        c.rated_speed,
        c.rated_power,
        c.tip_speed_ratio,
        c.fine_pitch or 0.0,
    )

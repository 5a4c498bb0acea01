"""The basis of the blades of a case: from a file, from a folder of bases, or made."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.reduced_body import ReducedBasis
from turbine_fenicsx.case.files import hash_files
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.reduction.basis_file import read_basis
from turbine_fenicsx.reduction.load_path import LoadPath
from turbine_fenicsx.reduction.reduce_body import reduce_body
from turbine_fenicsx.turbine.blades.basis_store import keep_basis, name_file, take_basis
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

RECIPE = 4
"""Version of how a basis is made; others are not taken from the folder of bases."""

STATIONS = 60
"""Aerodynamic stations along the blade at its operating points."""


def find_basis(case: Case, blade: ClampedBlade[FlexibleBody]) -> ReducedBasis:
    """The basis of the blades of a case. Collective."""
    comm, file = blade.body.mesh.comm, case.blade.reduction.file
    if file is not None:
        return read_basis(file, blade.body)
    path = on_rank0(comm, lambda: name_basis(case))
    return take_basis(path, blade.body, partial(_make, case, blade))


def make_basis(case: Case, blade: ClampedBlade[FlexibleBody], path: Path) -> ReducedBasis:
    """Make the basis of the blades of a case, and keep it in a file. Collective."""
    return keep_basis(path, blade.body, partial(_make, case, blade))


def _make(case: Case, blade: ClampedBlade[FlexibleBody]) -> ReducedBasis:
    """Make the basis."""
    r, loads = case.blade.reduction, list_loads(case, blade, TRAINING)
    log.info("making the basis of the blades, %s", describe_training(loads))
    return reduce_body(blade.system, blade.body, r.modes, r.functions, r.strains, loads)


def name_basis(case: Case) -> Path | None:
    """File for the basis of a case in a folder beside it; None if there can be none.

    All that the basis depends on is in the name: shape, layup and mesh of the blades, the files
    that these come from, and the numbers of its table.
    """
    return name_file(case, case.blade.reduction.folder, "blade", describe_blade(case))


def describe_blade(case: Tables) -> dict[str, Any]:
    """Everything in a case that the basis of its blades depends on."""
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
    for key in ("damping", "model", "beam"):
        del data["blade"][key]
    for key in ("file", "folder"):
        del data["blade"]["reduction"][key]
    files = hash_files(data, Tables)
    for table in ("turbine", "mesh", "aero"):  # by content
        data[table]["file"] = data[table]["file"] is not None
    return data | {"files": files, "recipe": RECIPE}


def list_loads(
    case: Case, blade: ClampedBlade[FlexibleBody], points: Sequence[OperatingPoint]
) -> list[LoadPath] | None:
    """Load paths of the blades at operating points of their turbine. Collective.

    Returns:
        None if no file says how the turbine is run; then `reduce_body` takes smooth loads.
    """
    comm = blade.body.mesh.comm
    rated = on_rank0(comm, lambda: find_rated(case))
    if rated is None:
        return None
    aero = on_rank0(comm, lambda: load_aero_blade(case, STATIONS))
    return OperatingLoads(blade.system, blade.body, blade.skin, aero, rated).list_paths(points)


def describe_training(loads: Sequence[LoadPath] | None) -> str:
    """The loads that a basis is made from, in words."""
    if loads is None:
        return "from smooth loads along the span"
    return f"from {len(loads)} operating points"


def find_rated(case: Case) -> RatedOperation | None:
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

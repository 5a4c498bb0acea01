"""Fatigue of the materials of a windIO file, with what a case says about them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.materials.adhesive_bond import Adhesive
from turbine_fenicsx.materials.ply import Strengths
from turbine_fenicsx.materials.ply_fatigue import PlyFatigue, find_usual_slope
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.life import LifeCase, LifeMaterialCase
from turbine_fenicsx.windio import WindIOMaterial


@dataclass(frozen=True)
class FileFatigue:
    """Fatigue of materials.

    Args:
        materials: Those that count, by their names.
        notes: Sentences on what does not count, and on slopes that the file lacks.
    """

    materials: Mapping[str, PlyFatigue]
    notes: tuple[str, ...]


def find_fatigue_of_file(case: Case, used: Collection[str]) -> FileFatigue:
    """Fatigue of the materials of ``turbine.file`` by the table ``life``.

    Args:
        used: Names of the materials of the blades.

    Raises:
        InputError: for a material with fibres that has no strength along them, or if none counts.
    """
    assert case.turbine.file is not None
    known = load_turbine(case.turbine.file).materials
    found: dict[str, PlyFatigue] = {}
    notes: list[str] = []
    for name in sorted(used):
        own = case.life.material.get(name, LifeMaterialCase())
        fatigue = _find_fatigue(name, known[name], own, case.life, notes)
        if fatigue is not None:
            found[name] = fatigue
    if not found:
        raise InputError("no material of the blades counts: " + "; ".join(notes))
    return FileFatigue(found, tuple(notes))


def _find_fatigue(
    name: str, given: WindIOMaterial, own: LifeMaterialCase, life: LifeCase, notes: list[str]
) -> PlyFatigue | None:
    """Fatigue of a material; None if it does not count, which a note says."""
    key = f"life.material.{name}"
    usual = find_usual_slope(given.ply)
    slope = own.slope or given.fatigue_exponent or usual
    strengths = _change_strengths(given.ply.strengths, own)
    along, across, shear = (
        all(map(isfinite, pair))
        for pair in (
            *zip(strengths.tension[:2], strengths.compression[:2], strict=True),
            (strengths.shear[0],),
        )
    )
    if usual is not None and not along:
        raise InputError(
            f"material {name!r} has no strengths along its fibres: give {key}.tension and "
            f"{key}.compression, of two numbers each"
        )
    if slope is None or not (along or across or shear):
        lacks = "strengths" if slope else "slope of an S-N curve"
        notes.append(f"{name} does not count: it has no {lacks}, see {key}")
        return None
    missing = [
        word for word, there in (("across the fibre", across), ("in shear", shear)) if not there
    ]
    if missing:
        notes.append(f"{name} does not count {' and '.join(missing)}: no strength, see {key}")
    if own.slope is None and given.fatigue_exponent is None:
        notes.append(f"{name} has slope {slope:g}, as plies of its family: the file has none")
    first = own.first or given.fatigue_strength
    factors = life.diagram, life.strength_factor, life.fatigue_factor
    return PlyFatigue(slope, strengths, first, *factors)


def find_adhesive(case: Case) -> tuple[Adhesive, PlyFatigue] | None:
    """The adhesive of the table ``life.adhesive`` and how it fails; None without one.

    Raises:
        InputError: if neither the case nor the file has a modulus or strength.
    """
    own, life = case.life.adhesive, case.life
    if own.thickness is None or own.width is None:
        return None
    of_file = _read_adhesive(case)

    def need(key: str) -> float:
        value: float | None = getattr(own, key) or of_file.get(key)
        if value is None or not isfinite(value):
            raise InputError(
                f"the bonds have no {key.replace('_', ' ')}: give life.adhesive.{key}, or name a "
                "material of turbine.file that has it with life.adhesive.name"
            )
        return value

    peel, shear = need("tension"), need("shear")
    compression = own.compression or of_file.get("compression", inf)
    limits = Strengths(
        (inf, peel, inf), (inf, compression if isfinite(compression) else peel, inf), (shear,) * 3
    )
    slope = own.slope or of_file.get("slope", ADHESIVE)
    factors = life.diagram, life.strength_factor, life.fatigue_factor
    fatigue = PlyFatigue(slope, limits, None, *factors)
    return Adhesive(own.thickness, own.width, need("young"), need("shear_modulus")), fatigue


ADHESIVE = 10.0
"""Slope of adhesives whose file and case have none, that of laminates with epoxy."""


def _read_adhesive(case: Case) -> dict[str, float]:
    """Numbers of the adhesive by the keys of ``life.adhesive``, as far as the file has it."""
    assert case.turbine.file is not None
    known, name = load_turbine(case.turbine.file).materials, case.life.adhesive.name.lower()
    file = next((x for key, x in known.items() if key.lower() == name), None)
    if file is None:
        return {}
    ply, slope = file.ply, file.fatigue_exponent
    found = {
        "young": ply.young[0],
        "shear_modulus": ply.shear[0],
        "tension": ply.strengths.tension[0],
        "compression": ply.strengths.compression[0],
        "shear": ply.strengths.shear[0],
    }
    return found if slope is None else {**found, "slope": slope}


def _change_strengths(strengths: Strengths, own: LifeMaterialCase) -> Strengths:
    """Strengths with those of the case in their places."""
    changes: dict[str, Any] = {
        side: (*getattr(own, side), getattr(strengths, side)[2])
        for side in ("tension", "compression")
        if getattr(own, side) is not None
    }
    if own.shear is not None:
        changes["shear"] = (own.shear, *strengths.shear[1:])
    return Strengths(**{**vars(strengths), **changes})

"""Materials of a windIO file as plies."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.orthotropic import Triple
from turbine_fenicsx.materials.ply import PlyMaterial, Strengths
from turbine_fenicsx.windio.entry import Entry


@dataclass(frozen=True)
class WindIOMaterial:
    """A material with what the file says about its fatigue.

    Args:
        fatigue_exponent: The exponent m of S = A N^(-1/m), the only or first one; None where the
            file has none [-].
        fatigue_strength: The stress A of the same formula; None where the file has none [Pa].
    """

    ply: PlyMaterial
    fatigue_exponent: float | None = None
    fatigue_strength: float | None = None


def read_materials(materials: Entry) -> dict[str, WindIOMaterial]:
    """All materials of a file by their names."""
    return {entry["name"].text(): _read_material(entry) for entry in materials.entries()}


def _read_material(entry: Entry) -> WindIOMaterial:
    name = entry["name"].text()
    young, poisson = _triple(entry["E"]), _triple(entry["nu"])
    if "G" in entry:
        shear = _triple(entry["G"])
    elif entry["orth"].number():
        entry.fail("has no 'G', which an orthotropic material needs")
    else:
        G = young[0] / (2.0 * (1.0 + poisson[0])) if poisson[0] > -1.0 else 0.0
        shear = (G, G, G)
    strengths = Strengths(*(_strengths(entry, key) for key in ("Xt", "Xc", "S")))
    try:
        ply = PlyMaterial(name, entry["rho"].number(), young, shear, poisson, strengths)
    except ModelError as error:
        entry.fail(f"is no stable material: {error}")
    return WindIOMaterial(ply, _first(entry, "m"), _first(entry, "A"))


def _triple(entry: Entry) -> Triple:
    """One number for all directions, or three."""
    if isinstance(entry.value, list):
        one, two, three = entry.numbers(3).tolist()
        return one, two, three
    value = entry.number()
    return value, value, value


def _strengths(entry: Entry, key: str) -> Triple:
    """Strengths of a key; those that are zero or missing are unknown, which is infinite here."""
    if key not in entry:
        return inf, inf, inf
    values = _triple(entry[key])
    if min(values) < 0.0:
        entry[key].fail(f"must not be negative, got {min(values):g}")
    one, two, three = (value or inf for value in values)
    return one, two, three


def _first(entry: Entry, key: str) -> float | None:
    """The only or first number of a key, None if that is zero or missing."""
    if key not in entry:
        return None
    values = entry[key].numbers().tolist() if isinstance(entry[key].value, list) else None
    if values == []:
        return None
    value = values[0] if values else entry[key].number()
    if value < 0.0:
        entry[key].fail(f"must not be negative, got {value:g}")
    return value or None

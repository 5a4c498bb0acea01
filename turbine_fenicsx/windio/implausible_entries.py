"""Numbers of a windIO file whose size no turbine has: their unit is probably another one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from turbine_fenicsx.foundation.plausible import Plausible
from turbine_fenicsx.windio.entry import Entry

_ANGLE = Plausible(0.3, 20.0)
_TWIST = Plausible(1.0, 50.0, whole=True)

USUAL: dict[str, tuple[str, Plausible]] = {
    "assembly.hub_height": ("m", Plausible(5.0, 400.0)),
    "assembly.rotor_diameter": ("m", Plausible(1.0, 500.0)),
    "assembly.rated_power": ("W", Plausible(1e3, 1e8)),
    "materials[].rho": ("kg/m^3", Plausible(20.0, 2e4)),
    "materials[].E": ("Pa", Plausible(1e5, 2e12)),
    "materials[].G": ("Pa", Plausible(3e4, 1e12)),
    "materials[].Xt": ("Pa", Plausible(1e4, 1e11)),
    "materials[].Xc": ("Pa", Plausible(1e4, 1e11)),
    "components.blade.outer_shape.chord.values": ("m", Plausible(0.05, 20.0, whole=True)),
    "components.blade.outer_shape.twist.values": ("deg", _TWIST),
    "components.blade.structure.layers[].thickness.values": (
        "m",
        Plausible(2e-5, 0.4, whole=True),
    ),
    "components.blade.structure.layers[].fiber_orientation.values": (
        "deg",
        Plausible(2.0, 360.0, whole=True),
    ),
    "components.hub.diameter": ("m", Plausible(0.2, 20.0)),
    "components.hub.cone_angle": ("deg", _ANGLE),
    "components.hub.elastic_properties.mass": ("kg", Plausible(10.0, 2e6)),
    "components.drivetrain.outer_shape.uptilt": ("deg", _ANGLE),
    "components.drivetrain.outer_shape.overhang": ("m", Plausible(0.2, 40.0)),
    "components.drivetrain.outer_shape.distance_tt_hub": ("m", Plausible(0.1, 20.0)),
    "components.drivetrain.elastic_properties.mass": ("kg", Plausible(100.0, 5e6)),
    "components.tower.outer_shape.outer_diameter.values": ("m", Plausible(0.2, 30.0, whole=True)),
    "components.tower.structure.layers[].thickness.values": (
        "m",
        Plausible(1e-3, 1.0, whole=True),
    ),
    "control.min_rotor_speed": ("rpm", Plausible(1.0, 400.0)),
    "control.rated_rotor_speed": ("rpm", Plausible(3.0, 600.0)),
    "control.rated_power": ("W", Plausible(1e3, 1e8)),
    "control.optimal_tsr": ("", Plausible(2.0, 20.0)),
    "control.fine_pitch": ("deg", Plausible(0.1, 30.0)),
    "control.max_pitch_limit": ("deg", Plausible(5.0, 180.0)),
    "control.max_pitch_rate": ("deg/s", Plausible(0.2, 60.0)),
}
"""Unit of the format and usual sizes, by place; [] stands for each entry of a list."""


def list_implausible(root: Entry) -> Iterator[str]:
    """A sentence for each kind of number of which some are unusual."""
    for place, (unit, usual) in USUAL.items():
        found = [
            (name, outlier)
            for name, value in _find(root.value, place.split("."), "")
            for outlier in usual.find_outliers(value if isinstance(value, list) else [value])
        ]
        if found:
            name, outlier = found[0]
            number = len({name for name, _ in found}) - 1
            others = f", with {number} more," if number else ""
            advice = f"the format counts in {unit}" if unit else "it has no unit"
            yield usual.describe(f"{root.file}: {name}{others}", outlier, unit, advice)


def _find(value: Any, keys: list[str], above: str) -> Iterator[tuple[str, Any]]:
    """Names and values of a place in nested lists and tables."""
    if not keys:
        yield above.removesuffix(".values"), value
        return
    key, each = keys[0].removesuffix("[]"), keys[0].endswith("[]")
    inner = value.get(key) if isinstance(value, dict) else None
    name = f"{above}.{key}" if above else key
    if inner is None:
        return
    if not each:
        yield from _find(inner, keys[1:], name)
    elif isinstance(inner, list):
        for entry in inner:
            label = entry.get("name") if isinstance(entry, dict) else None
            yield from _find(entry, keys[1:], f"{name}[{label!r}]")

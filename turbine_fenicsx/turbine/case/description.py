"""A case in words: what has an effect, how bearings move, what is damped."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, pi
from typing import Annotated, Any

from turbine_fenicsx.case.quantities import unit_of
from turbine_fenicsx.case.rules import find_unused_keys
from turbine_fenicsx.case.section import Section
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.tables.damping import DEFAULT_MODES, DampingCase
from turbine_fenicsx.turbine.tables.tables import Tables

_OPTIONAL = ("aero", "control", "drivetrain", "generator", "wind", "yaw")
"""Tables of what a turbine has only if its case says so."""


def describe_case(data: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a case without what is empty or has no effect, as the sizes of a rigid tower.

    Returns:
        Nested tables whose keys carry their SI units, for example ``length_[m]``.
    """
    case = Case.parse(data, None)
    unused = {key.name for key in find_unused_keys(case)}
    absent = {
        name for name in _OPTIONAL if not getattr(case, name).model_dump(exclude_defaults=True)
    }
    return _describe(case, unused | absent, "")


def _describe(section: Section, unused: set[str], above: str) -> dict[str, Any]:
    """One table."""
    found = {}
    for key, field in type(section).model_fields.items():
        value = getattr(section, key)
        if f"{above}{key}" in unused or value in ("", None):
            continue
        if isinstance(value, dict):
            tables = {
                name: _describe(table, unused, f"{above}{key}.{name}.")
                for name, table in value.items()
            }
            found.update({key: tables} if tables else {})
            continue
        if isinstance(value, Section):
            found[key] = _describe(value, unused, f"{above}{key}.")
            continue
        kind = (
            Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
        )
        unit = unit_of(kind)
        found[f"{key}_[{unit}]" if unit and not isinstance(value, str) else key] = value
    return found


YAW = {
    "free": "turns freely",
    "lock": "is locked",
    "drive": "turns at the rate that the controller commands, and is locked without one",
}
"""Motion of the yaw bearing by its drive."""


def describe_bearings(case: Tables) -> list[str]:
    """Yaw, pitch and rotor of a case in one line, and its structural damping in another."""
    sentences = [f"yaw {YAW[case.yaw.drive]}", _describe_pitch(case), _describe_rotor(case)]
    damped = [
        f"{name} {text}{_describe_dropped(case, key, table)}"
        for name, key, table, there in (
            ("blades", "blade", case.blade.damping, case.turbine.model == "hybrid"),
            ("tower", "tower", case.tower.damping, case.tower.flexible),
        )
        if there and (text := table.describe())
    ]
    m, flexible = case.material, case.turbine.model == "hybrid"
    if flexible and (m.shear_viscosity or m.bulk_viscosity):
        damped.append("blades by the viscosities of [material]")
    if case.turbine.numerical_dissipation:
        damped.append(f"numerical dissipation {case.turbine.numerical_dissipation:g}")
    lines = ["; ".join(filter(None, sentences))]
    if flexible or case.tower.flexible:
        lines.append(f"structural damping: {', '.join(damped) or 'none'}")
    return lines


def _describe_dropped(case: Tables, key: str, damping: DampingCase) -> str:
    """Modes that have a ratio by default, but not beside those of the case."""
    given = damping.ratios
    dropped = [name for name in DEFAULT_MODES[key] if name not in given]
    if case.turbine.file is None or not given or not dropped:
        return ""
    return f" (without the default of {' and '.join(dropped)})"


def _describe_pitch(case: Tables) -> str:
    """Motion of the pitch bearings."""
    pitch = case.pitch
    angles = [f"{degrees(angle):.3g}" for angle in pitch.initial]
    start = f"{', '.join(angles if len(set(angles)) > 1 else angles[:1])} deg"
    if not case.has_pitch_bearings:
        return "blades fixed to the hub without pitch bearings"
    if pitch.drive == "prescribed" and pitch.file is None:
        if pitch.angle == 0.0:
            return f"pitch locked at {start}"
        return (
            f"pitch from {start} by {degrees(pitch.angle):.3g} deg within {pitch.duration:g} s "
            f"from {pitch.start:g} s on"
        )
    return {
        "lock": f"pitch locked at {start}",
        "free": f"pitch turns freely from {start} on",
        "spring": f"pitch on springs about {start}",
        "prescribed": "pitch as pitch.file says",
        "actuator": f"pitch starts at {start} and follows commands",
    }[pitch.drive]


def _describe_rotor(case: Tables) -> str:
    """Motion of the rotor."""
    speed = f"{case.turbine.rotor_speed * 30.0 / pi:.4g} rpm"
    kept = case.generator.keeps
    if kept == "speed":
        return f"rotor kept at {speed}"
    kind = case.control.kind
    driven = f", torque of the controller ({kind.partition(':')[0]})" if kind != "none" else ""
    return f"rotor starts at {speed} and turns freely{driven}"

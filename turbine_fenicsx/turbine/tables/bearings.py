"""How the bearings of a case move and what is damped, in words."""

from __future__ import annotations

from math import degrees, pi

from turbine_fenicsx.turbine.tables.tables import Tables

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
        f"{name} {text}"
        for name, table, there in (
            ("blades", case.blade.damping, case.turbine.model == "hybrid"),
            ("tower", case.tower.damping, case.tower.flexible),
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


def _describe_pitch(case: Tables) -> str:
    """Motion of the pitch bearings."""
    pitch, start = case.pitch, f"{degrees(case.pitch.initial):.3g} deg"
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

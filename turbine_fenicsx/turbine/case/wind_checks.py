"""Wind and aerodynamics of a case against their files, and in words."""

from __future__ import annotations

from math import degrees
from pathlib import Path

from turbine_fenicsx.case.contradictions import Check
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.turbine.tables.wind_table import describe_wind_table


def _check_data(case: Tables) -> str:
    """The wind finds blades with aerodynamics that can be read."""
    if not case.wind.blows:
        return ""
    if case.aero.file is None and case.turbine.file is None:
        return (
            "aero.file: expected one beside a wind, a primary file of AeroDyn 15 or a windIO file "
            "with the polars of the blades"
        )
    from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade

    key = "turbine.file" if case.aero.file is None else "aero.file"
    try:
        blade = load_aero_blade(case)
    except (InputError, ModelError, OSError) as error:
        return "\n".join(f"{key}: {line}" for line in str(error).splitlines())
    tip, expected = blade.tip_radius, case.blade.hub_radius + case.blade.length
    if abs(tip - expected) <= 0.01 * expected:
        return ""
    return (
        f"{key}: its blades end at a radius of {tip:.4g} m, those of the case at "
        f"blade.hub_radius + blade.length = {expected:.4g} m, expected the same to 1 %"
    )


def _check_field(case: Tables) -> str:
    """The turbulence can be read, and is as large as the rotor and as long as the run."""
    w = case.wind
    has_box = w.has_box and w.speed and not w.find_box_mistake()
    if w.table is not None or not (w.file is not None or has_box):
        return ""
    from turbine_fenicsx.turbine.case.inflow import list_field_mistakes

    try:
        found = list_field_mistakes(case)
    except (InputError, ModelError, OSError) as error:
        found = [str(error)]
    made = "wind.turbulence" if w.turbulence.is_made else "wind.box.files"
    key = made if w.file is None else "wind.file"
    return "\n".join(f"{key}: {sentence}" for sentence in found)


_BLADE = ("turbine.file", "blade.hub_radius", "blade.length")
_ROTOR = ("turbine.tilt", "turbine.precone", "turbine.hub_rise", "tower.height")

_FIELD = ("wind.file", "wind.box", "wind.turbulence", "wind.hub_height", "time.end")

WIND_CHECKS = (
    Check(("aero.file", "aero.stations", "wind.speed", "wind.file", *_BLADE), _check_data),
    Check((*_FIELD, *_BLADE, *_ROTOR), _check_field),
)
"""Checks that read files of wind and aerodynamics."""


def describe_aerodynamics(case: Tables) -> list[str]:
    """Wind of a case and its models, in a few lines; empty without a wind."""
    w = case.wind
    if not w.blows:
        return []
    from turbine_fenicsx.turbine.case.aero_blade import find_aero_file, load_aero_blade

    blade = load_aero_blade(case)
    wind = (
        describe_wind_table(w.table)
        if w.table
        else f"turbulence of {quote(Path(w.file).name)}"
        if w.file
        else f"wind of {w.speed:g} m/s at {case.hub_height:g} m above ground, shear {w.shear:g}"
    )
    if w.box.files and w.box.points:
        names = ", ".join(quote(Path(file).name) for file in w.box.files)
        wind += f", with the turbulence of {names}, {' x '.join(map(str, w.box.points))} points"
    if w.turbulence.is_made:
        from turbine_fenicsx.turbine.case.turbulence import TurbulencePlan

        wind += f", with {TurbulencePlan.of(case).describe()}"
    if w.direction:
        wind += f", {degrees(w.direction):.4g} deg from the axis of the nacelle"
    if w.inclination and w.gust == "none":
        wind += f", {degrees(w.inclination):.4g} deg upwards"
    kind = f"{w.gust} of class {w.turbine_class}"
    gust = f", {kind} from {w.gust_start:g} s on" if w.gust != "none" else ""
    sets_in = f", sets in within {w.ramp:g} s" if w.ramp else ""
    return [
        f"{wind}{gust}{sets_in}",
        f"aerodynamics of {Path(find_aero_file(case)).name}: blade-element momentum theory with "
        f"{_name_models(case)}, {len(blade.radius)} stations from {blade.radius[0]:.4g} to "
        f"{blade.radius[-1]:.4g} m, chords from {blade.chord.min():.3g} to "
        f"{blade.chord.max():.3g} m",
    ]


def _name_models(case: Tables) -> str:
    """Aerodynamic models of a case, in words."""
    aero = case.aero
    found = ["dynamic inflow" if aero.induction else "no induction"]
    if aero.dynamic_stall == "oeye":
        found.append("dynamic stall")
    if aero.unsteady:
        found.append("shed vorticity")
    if aero.skewed_wake:
        found.append("a skewed wake")
    if aero.tower_shadow != "none":
        found.append("the tower's shadow")
    return found[0] if len(found) == 1 else f"{', '.join(found[:-1])} and {found[-1]}"

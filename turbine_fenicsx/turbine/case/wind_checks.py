"""Checks of the keys of wind and aerodynamics against each other and their files."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees
from pathlib import Path

from turbine_fenicsx.case.section import UnusedKeys
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.turbine.tables.wind_table import (
    FALLBACKS,
    check_wind_table,
    describe_wind_table,
    find_own_keys,
)


def _check_source(case: Tables) -> str:
    """A wind is steady, or that of a file."""
    w = case.wind
    if w.file is None or w.speed is None:
        return ""
    return f"wind.speed = {w.speed:g}: expected none beside wind.file, which has its own wind"


def _check_gust(case: Tables) -> str:
    """A gust needs a wind before it."""
    w = case.wind
    if w.gust == "none" or (w.speed and w.file is None):
        return ""
    return f'wind.gust = "{w.gust}": expected wind.speed greater than 0, the wind before the gust'


def _check_height(case: Tables) -> str:
    """The blades do not touch the ground of the wind."""
    if not case.wind.blows:
        return ""
    height, radius = case.hub_height, case.blade.hub_radius + case.blade.length
    if height > radius:
        return ""
    return (
        f"wind.hub_height = {height:g}: expected more than {radius:.4g} m, the radius of the rotor"
    )


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


def _check_tower(case: Tables) -> str:
    """A tower that stands in the wind has a shape."""
    shadow = case.aero.tower_shadow
    if not case.wind.blows or shadow == "none" or case.tower.flexible:
        return ""
    return f'aero.tower_shadow = "{shadow}": expected tower.flexible = true, a tower with diameters'


def _check_field(case: Tables) -> str:
    """The turbulence can be read, and is as large as the rotor and as long as the run."""
    w = case.wind
    if w.table is not None:
        return check_wind_table(w.table, case.time.end)
    if w.file is None and (w.box.files is None or _check_box(case) or not w.speed):
        return ""
    from turbine_fenicsx.turbine.case.inflow import list_field_mistakes

    try:
        found = list_field_mistakes(case)
    except (InputError, ModelError, OSError) as error:
        found = [str(error)]
    key = "wind.box.files" if w.file is None else "wind.file"
    return "\n".join(f"{key}: {sentence}" for sentence in found)


def _check_box(case: Tables) -> str:
    """A box has a size, and a mean wind along e3 that carries it."""
    w, box = case.wind, case.wind.box
    if box.files is None:
        return ""
    for name in ("points", "spacing"):
        if getattr(box, name) is None:
            return f"wind.box.{name}: expected three numbers, along e3, e1 and e2, beside its files"
    if w.file is not None:
        return "wind.box.files: expected none beside wind.file, which has its own wind"
    if not w.speed:
        return "wind.box.files: expected wind.speed greater than 0, the mean wind that carries it"
    for name in ("direction", "inclination"):
        if getattr(w, name):
            value = getattr(w, name)
            return f"wind.{name} = {value:g}: expected 0 beside wind.box, which is not turned"
    if w.gust != "none":
        return f'wind.gust = "{w.gust}": expected "none" beside wind.box, which has its own gusts'
    return ""


_BLADE = ("turbine.file", "blade.hub_radius", "blade.length")
_ROTOR = ("turbine.tilt", "turbine.precone", "turbine.hub_rise", "tower.height")

WIND_CHECKS: tuple[tuple[tuple[str, ...], Callable[[Tables], str]], ...] = (
    (("wind.speed", "wind.file"), _check_source),
    (("wind.gust", "wind.speed", "wind.file"), _check_gust),
    (
        ("wind.gust_sign",),
        lambda case: "" if case.wind.gust_sign else "wind.gust_sign = 0: expected 1 or -1",
    ),
    (("wind.hub_height", "wind.speed", "wind.file", *_BLADE, *_ROTOR), _check_height),
    (("aero", "wind.speed", "wind.file", *_BLADE), _check_data),
    (("aero.tower_shadow", "wind.speed", "wind.file", "tower.flexible"), _check_tower),
    (("wind.box", "wind.speed", "wind.file", "wind.gust", "wind.direction"), _check_box),
    (("wind.file", "wind.box", "wind.hub_height", "time.end", *_BLADE, *_ROTOR), _check_field),
)
"""The keys that a check looks at, the guilty one first, and the check: a sentence or nothing."""


def find_unused_wind_keys(case: Tables) -> UnusedKeys:
    """Keys without effect."""
    w, turbulence = case.wind, ("turbine_class", "turbulence")
    if not w.blows:
        others = set(type(w).model_fields) - {"speed", "file"}
        yield "wind", tuple(others), "without wind.speed or wind.file"
        yield "", ("aero",), "without wind.speed or wind.file"
        return
    if case.aero.tower_shadow != "powles":
        yield "aero", ("tower_drag",), f'with aero.tower_shadow = "{case.aero.tower_shadow}"'
    if w.box.files is None:
        yield "wind.box", tuple(set(type(w.box).model_fields) - {"files"}), "without wind.box.files"
    if w.file is not None:
        yield "wind", ("gust_start", "gust_sign", *turbulence), "beside wind.file"
        own = FALLBACKS if w.table is None else find_own_keys(w.table)
        yield "wind", own, "beside wind.file, which has its own"
    elif w.gust == "none":
        yield "wind", ("gust_start", "gust_sign", *turbulence), 'with wind.gust = "none"'
    else:
        yield "wind", ("inclination",), f'with wind.gust = "{w.gust}"'
        if w.gust == "EOG":
            yield "wind", ("gust_sign",), 'with wind.gust = "EOG"'


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
    if w.direction:
        wind += f", {degrees(w.direction):.4g} deg from the axis of the nacelle"
    if w.inclination and w.gust == "none":
        wind += f", {degrees(w.inclination):.4g} deg upwards"
    kind = f"{w.gust} of class {w.turbine_class}{w.turbulence}"
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
    if aero.skewed_wake:
        found.append("a skewed wake")
    if aero.tower_shadow != "none":
        found.append("the tower's shadow")
    return found[0] if len(found) == 1 else f"{', '.join(found[:-1])} and {found[-1]}"

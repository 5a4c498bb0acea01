"""A windIO file as part of a case: the case overrides single values of the file.

Hub, nacelle and tower of the file become the defaults of the keys; shape and layup of the blades
are the file's alone.
"""

from __future__ import annotations

import copy
import functools
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from turbine_fenicsx.case.contradictions import Check
from turbine_fenicsx.case.files import read_if_changed
from turbine_fenicsx.case.quantities import to_si
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.text_files import quote, suggest
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.turbine.case.beam_file import add_beam, find_beam_mu
from turbine_fenicsx.turbine.case.turbine_control import (
    GeneratorShaft,
    design_control,
    find_generator,
)
from turbine_fenicsx.turbine.tables.damping import DEFAULT_MODES
from turbine_fenicsx.turbine.tables.named_files import list_included
from turbine_fenicsx.turbine.tables.tables import Tables

if TYPE_CHECKING:  # cases without a file do not wait for what reads one
    from turbine_fenicsx.windio import WindIOTurbine
    from turbine_fenicsx.windio.rigid_parts import RigidPart

N_BLADES = 3

FILE = ("turbine", "file")

DEFAULTS: dict[str, dict[str, Any]] = {
    "blade": {"damping": 0.005},
    "tower": {"damping": 0.01},
    "yaw": {"drive": "lock"},
}
"""Keys of turbines of a file that the file does not give, as engineers set them."""


@read_if_changed("windIO file", parts=list_included)
def load_turbine(path: str) -> WindIOTurbine:
    """The turbine of a windIO file."""
    from turbine_fenicsx.windio import read_turbine

    try:
        turbine = read_turbine(path)
    except ModelError as error:
        raise InputError(str(error)) from None
    name = Path(path).name
    if turbine.blade_count != N_BLADES:
        raise InputError(
            f"{name} has {turbine.blade_count} blades, expected {N_BLADES}, which turbines of this "
            "package have"
        )
    if not turbine.upwind:
        raise InputError(f"{name} has its rotor behind the tower, expected one in front of it")
    return turbine


def tabulate_file(
    turbine: WindIOTurbine,
    tower: bool,
    wind: bool = False,
    generator: GeneratorShaft | None = None,
    rigid: bool = False,
) -> dict[str, Any]:
    """Keys of a case that a file gives, as nested tables.

    Args:
        wind: Whether there is a wind, which blows at the height of the hub.
        generator: What a controller acts on; None without one.
    """
    nacelle, hub = turbine.nacelle, turbine.hub
    assert nacelle
    parts = (("nacelle", nacelle.body), ("hub", hub.body))
    found: dict[str, Any] = {
        "turbine": {
            "hub_distance": nacelle.overhang,
            "hub_rise": nacelle.height,
            "tilt": -nacelle.tilt * pi / 180.0,
            "precone": -hub.cone_angle * pi / 180.0,
            **{key: _tabulate_part(part) for key, part in parts if part},
        },
        "blade": {"hub_radius": hub.radius, "length": turbine.blade.length},
    }
    if not rigid:
        found["material"] = {"law": "windio"}
    if wind and turbine.hub_height:
        found["wind"] = {"hub_height": turbine.hub_height}
    if tower and turbine.tower:
        t = turbine.tower
        stations = np.unique(np.concatenate([[0.0, 1.0], t.diameter.grid, t.wall.grid]))
        found["tower"] = {
            "flexible": True,
            "height": t.top - t.base,
            "stations": stations.tolist(),
            "diameters": t.diameter(stations).tolist(),
            "walls": t.wall(stations).tolist(),
            "young": t.material.young[0],
            "poisson": t.material.poisson[0],
            "density": t.material.density * t.outfitting,
        }
        if turbine.yaw and turbine.yaw.mass > 0.0:
            found["tower"]["top_mass"] = turbine.yaw.mass
    if generator is not None:
        found.update(copy.deepcopy(design_control(turbine, generator).tables))
        if rigid:
            del found["pitch"]["bearings"]  # rigid blades have them always
    return found


def _list_missing(turbine: WindIOTurbine, data: Mapping[str, Any], name: str) -> Iterator[str]:
    """Sentences about what a turbine needs and neither the file nor the case has."""
    if turbine.nacelle is None:
        yield f"{name} has no components.drivetrain, which a turbine needs"
    parts = (
        ("drivetrain", "nacelle", turbine.nacelle.body if turbine.nacelle else None),
        ("hub", "hub", turbine.hub.body),
    )
    for component, key, part in parts:
        table = data["turbine"].get(key)
        given = set(table) if isinstance(table, Mapping) else set()
        there = part is not None or ("mass" in given and given & {"inertia", "euler"})
        if not there and (component == "hub" or turbine.nacelle):
            yield (
                f"{name} has no components.{component}.elastic_properties: give turbine.{key}.mass "
                f"and turbine.{key}.inertia, and turbine.{key}.centre if it is not zero"
            )
    if not turbine.hub.radius and find_own_radius(data) is None:
        yield f"{name} has no components.hub.diameter: give blade.hub_radius, half of it"


def find_own_radius(data: Mapping[str, Any]) -> float | None:
    """The key ``blade.hub_radius`` of nested tables, None if it is missing or wrong [m]."""
    blade = data.get("blade")
    with suppress(ValueError):
        if isinstance(blade, Mapping) and "hub_radius" in blade:
            radius = to_si(blade["hub_radius"], "m")
            return radius if radius > 0.0 else None
    return None


@functools.lru_cache(maxsize=8)
def give_hub(turbine: WindIOTurbine, radius: float) -> WindIOTurbine:
    """A turbine whose file has no diameter of the hub, with that of its case [m]."""
    if turbine.hub.radius:
        return turbine
    blade = replace(turbine.blade, hub_radius=radius)
    return replace(turbine, hub=replace(turbine.hub, radius=radius), blade=blade)


def load_case_turbine(case: Tables) -> WindIOTurbine:
    """The turbine of the file of a case; InputError as `load_turbine`."""
    assert case.turbine.file is not None
    return give_hub(load_turbine(case.turbine.file), case.blade.hub_radius)


def _tabulate_part(part: RigidPart) -> dict[str, Any]:
    """Mass, centre and inertia of a rigid part, from windIO's x, y, z = e3, e1, e2."""
    order = [1, 2, 0]
    J: Array = part.inertia[np.ix_(order, order)]
    return {
        "mass": part.mass,
        "centre": part.location[order].tolist(),
        "inertia": [*np.diag(J).tolist(), J[0, 1], J[0, 2], J[1, 2]],
    }


def add_file(data: Mapping[str, Any], folder: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Nested tables of a case with those of its files, if it names any, below them.

    Args:
        folder: Where the file is looked for before the examples of windIO.
    """
    file = _find_file(data)
    if file is None:
        return add_beam(data)
    from turbine_fenicsx.windio import find_turbine_file

    name = str(find_turbine_file(file, folder))
    own = data.get("tower")
    tower = not isinstance(own, Mapping) or own.get("flexible") is not False
    blows = data.get("wind")
    wind = isinstance(blows, Mapping) and ("speed" in blows or "file" in blows)
    turbine = load_turbine(name)
    missing = list(_list_missing(turbine, data, Path(name).name))
    if missing:
        raise InputError("\n".join(missing))
    own_radius = find_own_radius(data)
    turbine = turbine if own_radius is None else give_hub(turbine, own_radius)
    rigid = data["turbine"].get("model") == "rigid"
    below = tabulate_file(turbine, tower, wind, find_generator(data, turbine), rigid)
    for part in ("nacelle", "hub"):
        table = data["turbine"].get(part)
        if isinstance(table, Mapping) and "euler" in table and part in below["turbine"]:
            del below["turbine"][part]["inertia"]
    found = _merge(_merge(_find_defaults(data, turbine, tower, rigid), below), data)
    found["turbine"]["file"] = name
    return found


def _find_defaults(
    data: Mapping[str, Any], turbine: WindIOTurbine, tower: bool, rigid: bool
) -> dict[str, dict[str, Any]]:
    """Defaults of a turbine of a file, as far as the case has no other."""
    material = data.get("material")
    viscous = isinstance(material, Mapping) and any("viscosity" in str(key) for key in material)
    found = {name: dict(values) for name, values in DEFAULTS.items()}
    for name, mu in (("blade", turbine.blade_damping), ("tower", turbine.tower_damping)):
        own = data.get(name)
        given = own.get("damping") if isinstance(own, Mapping) else None
        is_beam = name == "blade" and isinstance(own, Mapping) and own.get("model") == "beam"
        mu = find_beam_mu(own or {}, mu) if is_beam else mu
        if is_beam and any(mu):
            found[name] = {"damping": {"mu": mu}}
        elif time := 0.5 * (mu[3] + mu[4]):
            found[name] = {"damping": {"stiffness_time": time}}
        if isinstance(given, Mapping) and not set(given) - {"speed"}:
            ratio = found[name]["damping"]  # a table that names no mode, but the speed for all
            if not isinstance(ratio, Mapping):
                found[name] = {"damping": dict.fromkeys(DEFAULT_MODES[name], ratio)}
        elif given is not None:
            del found[name]
    if rigid:
        found["pitch"] = {"drive": "prescribed"}  # else the blades would turn freely
    if viscous or rigid:
        found.pop("blade", None)
    if not tower:
        found.pop("tower", None)
    return found


def _find_file(data: Any) -> str | None:
    """The key ``turbine.file`` of nested tables, if these are tables and it is text."""
    turbine = data.get("turbine") if isinstance(data, Mapping) else None
    name = turbine.get("file") if isinstance(turbine, Mapping) else None
    return name if isinstance(name, str) else None


def _merge(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Nested tables, the second over the first."""
    found = dict(below)
    for key, value in above.items():
        both = isinstance(value, Mapping) and isinstance(below.get(key), Mapping)
        found[key] = _merge(below[key], value) if both else value
    return found


def list_origins(case: Tables) -> tuple[list[str], list[str]]:
    """Keys that have the value of the file, and those that the case overrides."""
    if case.turbine.file is None:
        return [], []
    turbine = load_case_turbine(case)
    is_given = load_turbine(case.turbine.file).hub.radius > 0.0
    taken: list[str] = []
    overridden: list[str] = []
    rigid = case.turbine.model == "rigid"
    shaft = _find_shaft(case)
    tables = tabulate_file(turbine, case.tower.flexible, case.wind.blows, shaft, rigid)
    for key, value in _flatten(tables):
        if key == "blade.hub_radius" and not is_given:
            continue
        mine: Any = case
        for name in key.split("."):
            mine = getattr(mine, name)
        same = list(mine) == value if isinstance(mine, tuple) else mine == value
        (taken if same else overridden).append(key)
    return taken, overridden


def describe_file(case: Tables) -> list[str]:
    """Values of a case that come from its file, in a few lines; empty without a file."""
    if case.turbine.file is None:
        return []
    turbine, (taken, overridden) = load_turbine(case.turbine.file), list_origins(case)
    lines = [
        f"{Path(case.turbine.file).name}: {turbine.name}",
        f"from the file: {', '.join(taken) or 'nothing'}, shape and {_name_walls(case)} of the "
        "blades",
    ]
    if overridden:
        lines.append(f"overridden by the case: {', '.join(overridden)}")
    if turbine.foundations:
        lines.append(
            f"left out: components.{', components.'.join(turbine.foundations)}; the tower is "
            "clamped at its base"
        )
    lines += [f"not read: {text}" for text in turbine.references.damping]
    if turbine.rated_speed is not None:
        lines.append(f"rated speed of the rotor {turbine.rated_speed * 30.0 / pi:.4g} rpm")
    return lines


def _name_walls(case: Tables) -> str:
    """The structure of the blades that a case takes from its file, in words."""
    assert case.turbine.file is not None
    layup = load_turbine(case.turbine.file).blade.has_layup and not case.has_beam_blades
    return "layup" if layup else "section matrices"


def _find_shaft(case: Tables) -> GeneratorShaft | None:
    """The generator of a case with a controller; None without one."""
    d, kind = case.drivetrain, case.control.kind
    return None if kind == "none" else GeneratorShaft(d.ratio, d.efficiency, kind == "pi")


def _flatten(tables: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


# --- checks


def _check_length(case: Tables) -> str:
    """Blades of a file are as long as it says."""
    if case.turbine.file is None:
        return ""
    length = load_turbine(case.turbine.file).blade.length
    if case.blade.length == length:
        return ""
    return (
        f"blade.length = {case.blade.length:g}: expected none beside turbine.file, whose blades "
        f"have {length:g} m"
    )


def _check_controller(case: Tables) -> str:
    """The built-in controller knows the turbine that it is for."""
    shaft, control = _find_shaft(case), case.control
    if case.turbine.file is None or shaft is None:
        return ""
    gap = design_control(load_case_turbine(case), shaft).gap
    if not gap or {"torque", "pitch"} <= control.model_fields_set:
        return ""
    return (
        'control.kind = "pi": expected the tables control.torque and control.pitch, which do not '
        f"follow from {quote(Path(case.turbine.file).name)}: {gap}"
    )


def _check_gauges(case: Tables) -> str:
    """The strain gauges lie on the blades, whose panels a file may name."""
    if case.turbine.model == "rigid":
        return ""
    file, length = case.turbine.file, case.blade.length
    panels = load_turbine(file).blade.panels if file else ()
    sentences = (
        gauge.find_mistake(f"output.gauges.{name}", length, panels)
        for name, gauge in case.output.gauges.items()
    )
    return next(filter(None, sentences), "")


def _check_life(case: Tables) -> str:
    """Materials whose life a case describes are those of the file."""
    if case.turbine.file is None or not case.life.material:
        return ""
    known = load_turbine(case.turbine.file).materials
    for name in case.life.material:
        if name not in known:
            return f"life.material.{name}: no material of turbine.file{suggest(name, known)}"
    return ""


TURBINE_CHECKS = (
    Check(("blade.length", "turbine.file"), _check_length),
    Check(("control", "drivetrain", "turbine.file"), _check_controller),
    Check(("output.gauges", "blade.length", "turbine.file", "turbine.model"), _check_gauges),
    Check(("life.material", "turbine.file"), _check_life),
)
"""Checks that read the file of the turbine."""

"""Contradictions between keys of a case, and keys without effect.

A contradiction is a mistake. A key that is set but has no effect in the chosen model is only worth
a warning: cases are varied with ``--set turbine.model=rigid``, and a file may hold the constants of
two materials.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import cos, pi, prod, tan
from operator import eq
from typing import Any

import numpy as np

from turbine_fenicsx.case.mistakes import Key, Mistake
from turbine_fenicsx.case.section import MAX_ELEMENTS, UnusedKeys
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.case.turbine_file import (
    FILE_CHECKS,
    find_unused_file_keys,
    load_turbine,
)
from turbine_fenicsx.turbine.case.wind_checks import WIND_CHECKS, find_unused_wind_keys
from turbine_fenicsx.turbine.tables.blade_walls import WALL_CHECKS, find_unused_wall_keys
from turbine_fenicsx.turbine.tables.control_checks import CONTROL_CHECKS, find_unused_control_keys
from turbine_fenicsx.turbine.tables.damping import check_damping
from turbine_fenicsx.turbine.tables.gauges import check_gauges
from turbine_fenicsx.turbine.tables.generator import check_generator, find_unused_generator_keys
from turbine_fenicsx.turbine.tables.load_tables import TABLE_CHECKS
from turbine_fenicsx.turbine.tables.pitch import check_pitch, find_unused_pitch_keys
from turbine_fenicsx.turbine.tables.rigid_parts import check_inertia
from turbine_fenicsx.turbine.tables.tables import BladeCase, MeshCase, Tables
from turbine_fenicsx.turbine.tables.tower import TOWER_CHECKS, find_unused_tower_keys

MAX_STEPS = 1e9
"""Steps of a run; a million times as many as the paper's."""


def find_contradictions(case: Tables, wrong: set[Key]) -> list[Mistake]:
    """Mistakes that take more than one key to see.

    Args:
        case: The tables, with defaults in the place of what is wrong by itself.
        wrong: The keys that are wrong by themselves; nothing is said that depends on them.
    """
    found = []
    for names, check in _CHECKS:
        keys = [tuple(name.split(".")) for name in names]
        # one key is, or is inside of, the other
        if any(all(map(eq, key, bad)) for key in keys for bad in wrong):
            continue
        sentence = check(case)
        if sentence:
            found.append(Mistake(keys[0], sentence))
            wrong = wrong | {keys[0]}
    return found


def _check_stations(case: Tables) -> str:
    """Stations increase from 0 to 1."""
    s = case.blade.stations
    if len(s) >= 2 and (s[0], s[-1]) == (0.0, 1.0) and all(a < b for a, b in pairwise(s)):
        return ""
    return (
        f"blade.stations = {quote(s)}: expected increasing fractions of the span that begin with 0 "
        "and end with 1, for example [0, 0.2, 1]"
    )


def _check_widths(name: str, widths: tuple[float, ...], case: Tables) -> str:
    """As many widths as stations."""
    n = len(case.blade.stations)
    if len(widths) == n:
        return ""
    return (
        f"blade.{name} = {quote(widths)}: expected one width for each of the {n} blade.stations, "
        f"got {len(widths)}"
    )


def _has_solid_blades(case: Tables) -> bool:
    """Whether the blades are flexible and described by the case alone."""
    return case.turbine.model == "hybrid" and case.turbine.file is None


def _check_clearance(case: Tables) -> str:
    """The roots of three built-in blades do not overlap."""
    b = case.blade
    width = max(b.chord[0], b.thickness[0])
    needed = width / 2.0 / tan(pi / 3.0) / cos(case.turbine.precone)
    if not _has_solid_blades(case) or case.mesh.file or b.hub_radius >= needed:
        return ""
    return (
        f"blade.hub_radius = {b.hub_radius:g}: three blades that are {width:g} m wide at the root "
        f"overlap, expected at least {needed:.4g} m"
    )


def _check_size(case: Tables) -> str:
    """The mesh of a blade has not absurdly many elements."""
    m, b = case.mesh, case.blade
    rigid = case.turbine.model == "rigid" and case.turbine.file is None
    if rigid or m.file:
        return ""
    key, value = ("size", f"{m.size:g}") if m.size else ("elements", quote(list(m.elements)))
    keys = f"mesh.{key} = {value}"
    if case.turbine.file or b.wall:
        count = float(m.span * m.around)
        keys = f"mesh.span = {m.span} and mesh.around = {m.around}"
    elif m.cell == "tetrahedron":
        count = _count_bricks(m, b)
    else:
        widths = (max(b.chord), max(b.thickness), b.length)
        count = prod(w / m.size for w in widths) if m.size else float(prod(m.elements))
    if count <= MAX_ELEMENTS:
        return ""
    return f"{keys}: expected at most {MAX_ELEMENTS} elements in each blade, got some {count:.3g}"


def _count_bricks(mesh: MeshCase, blade: BladeCase) -> float:
    """Number of bricks that fill a blade, with edges as long as those of its tetrahedra."""
    # imported here, so that no other case needs MPI
    from turbine_fenicsx.meshing import MeshOptions

    s, shape = np.linspace(0.0, 1.0, 500), blade.geometry()
    edges = MeshOptions(mesh.cell, elements=mesh.elements, size=mesh.size).edge_lengths(shape)
    h = np.interp(s, shape.stations, edges)
    with np.errstate(all="ignore"):  # absurd shapes have infinitely many
        volumes = shape.chord_at(s) * shape.thickness_at(s) * shape.length
        return float(np.mean(volumes / h**3))


def _check_curved_cells(case: Tables) -> str:
    """Displacements can follow the shape of the cells, or a rotation would store energy."""
    m = case.mesh
    if not _has_solid_blades(case) or m.file or case.blade.wall:
        return ""
    if m.geometry_degree <= m.degree:
        return ""
    return (
        f"mesh.geometry_degree = {m.geometry_degree}: expected at most mesh.degree = "
        f"{m.degree}, or a rigid rotation would store energy"
    )


def _check_steps(case: Tables) -> str:
    """The number of steps is not absurd."""
    t = case.time
    if t.end <= MAX_STEPS * t.step:
        return ""
    return (
        f"time.step = {t.step:g}: takes more than {MAX_STEPS:.0e} steps to time.end = {t.end:g} s"
    )


def _check_start(case: Tables) -> str:
    """Static equilibrium does not turn."""
    speed = case.turbine.rotor_speed
    if case.time.start != "equilibrium" or speed == 0.0:
        return ""
    return (
        f'time.start = "equilibrium": expected turbine.rotor_speed = 0, got {speed:g}; "turning" '
        "is the equilibrium of a rotor that turns"
    )


def _check_material(case: Tables) -> str:
    """The material is positive definite."""
    if case.turbine.model == "rigid" or case.material.law == "windio":
        return ""
    try:
        with np.errstate(all="raise"):
            case.material.make(("a1", "a2", "a3"))
    except ModelError as error:
        return str(error)
    except (ArithmeticError, np.linalg.LinAlgError):  # of numbers that are absurdly large or small
        names = ", ".join(_CONSTANTS[case.material.law])
        return f"material is not positive definite: {names} are out of range"
    return ""


def _check_damping(case: Tables) -> str:
    """Blades are damped in one way."""
    m, damping = case.material, case.blade.damping
    viscous = [x for x in ("shear_viscosity", "bulk_viscosity") if getattr(m, x) > 0.0]
    if viscous and damping.acts:
        return f"blade.damping: expected none beside material.{viscous[0]}"
    return check_damping("blade.damping", damping)


def _check_gauges(case: Tables) -> str:
    """The strain gauges lie on the blades."""
    if case.turbine.model == "rigid":
        return ""
    file = case.turbine.file
    panels = load_turbine(file).blade.panels if file else ()
    return check_gauges(case.output.gauges, case.blade.length, panels)


_MATERIAL = ("law", "young", "shear", "poisson", "first_lame", "shear_modulus")
"""Keys of the stiffness."""

_ROOTS = ("blade.hub_radius", "blade.chord", "blade.thickness", "mesh.file", "turbine.precone")
"""Keys that say how near to each other the roots are."""

_CHECKS: tuple[tuple[tuple[str, ...], Callable[[Tables], str]], ...] = (
    *FILE_CHECKS,
    (("blade.stations",), _check_stations),
    (("blade.chord", "blade.stations"), lambda c: _check_widths("chord", c.blade.chord, c)),
    (
        ("blade.thickness", "blade.stations"),
        lambda c: _check_widths("thickness", c.blade.thickness, c),
    ),
    *WALL_CHECKS,
    (_ROOTS, _check_clearance),
    (("turbine.nacelle",), lambda case: check_inertia("turbine.nacelle", case.turbine.nacelle)),
    (("turbine.hub",), lambda case: check_inertia("turbine.hub", case.turbine.hub)),
    (("mesh", "blade"), _check_size),
    (("mesh.geometry_degree", "mesh.degree"), _check_curved_cells),
    *((keys, lambda c, check=check: check(c.tower)) for keys, check in TOWER_CHECKS),
    (
        ("pitch.drive", "pitch.stiffness", "pitch.damping"),
        lambda c: check_pitch(c.pitch, c.turbine.model),
    ),
    (("time.step", "time.end"), _check_steps),
    (("time.start", "turbine.rotor_speed"), _check_start),
    (tuple(f"material.{name}" for name in _MATERIAL), _check_material),
    (("blade.damping", "material.shear_viscosity", "material.bulk_viscosity"), _check_damping),
    *CONTROL_CHECKS,
    (("output.gauges", "blade.length", "turbine.file", "turbine.model"), _check_gauges),
    *WIND_CHECKS,
    *TABLE_CHECKS,
    (
        ("generator", "wind", "turbine.rotor_speed", "control"),
        lambda c: check_generator(c.generator, c.wind, c.turbine.rotor_speed, c.control.kind),
    ),
)
"""The keys that a check looks at, the guilty one first, and the check: a sentence or nothing."""

_CONSTANTS = {
    "transversely_isotropic": ("young", "shear", "poisson"),
    "transversely_isotropic_finite": ("young", "shear", "poisson"),
    "st_venant_kirchhoff": ("first_lame", "shear_modulus"),
    "neo_hooke": ("first_lame", "shear_modulus"),
    "windio": (),
}


def describe_unused_keys(case: Tables) -> list[str]:
    """One sentence for every key that is set but changes nothing.

    Args:
        case: A valid case.
    """
    sentences = []
    for table, names, reason in find_unused_keys(case):
        section: Any = case
        for name in filter(None, table.split(".")):
            section = section[name] if isinstance(section, dict) else getattr(section, name)
        for name in sorted(section.model_fields_set & set(names)):
            sentences.append(f"{f'{table}.{name}'.lstrip('.')} has no effect {reason}")
    return sentences


def find_unused_keys(case: Tables) -> UnusedKeys:
    """Table, its keys without effect, and the reason.

    Args:
        case: A valid case.
    """
    m, law = case.mesh, case.material.law
    if case.turbine.model == "rigid":
        if case.turbine.file is None:
            yield "", ("mesh", "material"), 'with turbine.model = "rigid"'
        else:  # a mesh gives their inertia
            yield "", ("material",), 'with turbine.model = "rigid"'
            yield "mesh", ("file",), 'with turbine.model = "rigid"'
            yield "turbine", ("blade", "blade_arm"), "beside turbine.file"
        yield "output", ("gauges",), 'with turbine.model = "rigid"'
        yield "blade", ("damping",), 'with turbine.model = "rigid"'
    else:
        yield "turbine", ("blade", "blade_arm"), 'with turbine.model = "hybrid"'
        unused = set().union(*_CONSTANTS.values()) - set(_CONSTANTS[law])
        yield "material", tuple(unused), f'with material.law = "{law}"'
        if m.file:
            made = ("cell", "elements", "size", "geometry_degree", "span", "around", "tip")
            yield "mesh", made, "beside mesh.file"
            shape = ("stations", "chord", "thickness", "wall", "twist")
            yield "blade", shape, "on the run beside mesh.file"
        elif m.size and case.blade.wall is None:
            yield "mesh", ("elements",), "beside mesh.size"
    for name in ("nacelle", "hub"):
        if getattr(case.turbine, name).inertia is not None:
            yield f"turbine.{name}", ("euler",), f"beside turbine.{name}.inertia"
    yield from find_unused_file_keys(case)
    yield from find_unused_wall_keys(case)
    yield from find_unused_pitch_keys(case.pitch, case.turbine.model)
    if case.time.scheme == "generalised_alpha":
        keys = ("numerical_dissipation", "angle_form")
        yield "turbine", keys, 'with time.scheme = "generalised_alpha"'
    else:
        yield "time", ("spectral_radius",), f'with time.scheme = "{case.time.scheme}"'
    if case.turbine.model == "rigid" and not case.tower.flexible:
        yield "turbine", ("numerical_dissipation",), "without flexible parts"
    yield from find_unused_tower_keys(case.tower)
    yield from find_unused_wind_keys(case)
    yield from find_unused_control_keys(case)
    yield from find_unused_generator_keys(case.generator)
    loads = case.loads
    if loads.rotor_torque == loads.yaw_torque == loads.pitch_torque == 0.0:
        yield "loads", ("duration",), "without a torque"
        if loads.file is None:
            yield "time", ("ramp",), "without a torque"

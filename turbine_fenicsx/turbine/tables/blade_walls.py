"""Checks of the wall and the twist of blades with elliptic sections."""

from __future__ import annotations

from collections.abc import Callable

from turbine_fenicsx.case.section import UnusedKeys
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.tables import Tables


def _check_count(name: str, values: tuple[float, ...] | None, case: Tables) -> str:
    """As many numbers as stations, if there are any."""
    n = len(case.blade.stations)
    if values is None or len(values) == n:
        return ""
    return (
        f"blade.{name} = {quote(values)}: expected one number for each of the {n} blade.stations, "
        f"got {len(values)}"
    )


def _check_wall(case: Tables) -> str:
    """One wall per station, which leaves a hollow."""
    b = case.blade
    sentence = _check_count("wall", b.wall, case)
    if sentence or b.wall is None:
        return sentence
    for station, wall, *widths in zip(b.stations, b.wall, b.chord, b.thickness, strict=True):
        if wall >= min(widths) / 2.0:
            return (
                f"blade.wall = {wall:g} at station {station:g}: leaves no hollow, expected less "
                f"than {min(widths) / 2.0:g} m, half of the section there"
            )
    return ""


WALL_CHECKS: tuple[tuple[tuple[str, ...], Callable[[Tables], str]], ...] = (
    (("blade.wall", "blade.stations", "blade.chord", "blade.thickness"), _check_wall),
    (("blade.twist", "blade.stations"), lambda c: _check_count("twist", c.blade.twist, c)),
)
"""The keys that a check looks at, the guilty one first, and the check: a sentence or nothing."""


def find_unused_wall_keys(case: Tables) -> UnusedKeys:
    """Keys of the mesh that have no effect on blades with a wall, or without."""
    if case.turbine.model == "rigid" or case.turbine.file or case.mesh.file:
        return
    if case.blade.wall is None:
        yield "mesh", ("span", "around", "tip"), "without blade.wall or turbine.file"
    else:
        names = ("cell", "elements", "size", "degree", "geometry_degree")
        yield "mesh", names, "beside blade.wall, which takes quadratic hexahedra"
        yield "mesh", ("tip",), "without turbine.file"

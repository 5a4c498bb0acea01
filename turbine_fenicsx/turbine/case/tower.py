"""The table of the tower: its keys, and what they have to do with each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from pydantic import Field

from turbine_fenicsx.turbine.case.mistakes import quote
from turbine_fenicsx.turbine.case.quantities import Density, Kilograms, Metres, Number, Pascal
from turbine_fenicsx.turbine.case.section import (
    MAX_UNKNOWNS,
    Count,
    Degree,
    Flag,
    IdleKeys,
    Moment,
    Positive,
    Section,
)


class TowerCase(Section):
    """Tower: a hollow cone of hexahedra below the yaw bearing, clamped to the ground.

    A rigid body at its top, of the mass and Euler values in e1, e2, e3 given here, carries the yaw
    bearing. With ``flexible = false`` the yaw bearing stands on the ground.
    """

    flexible: Flag = False
    height: Annotated[Metres, Positive] = 80.0
    bottom_diameter: Annotated[Metres, Positive] = 6.0
    top_diameter: Annotated[Metres, Positive] = 4.0
    wall: Annotated[Metres, Positive] = 0.04
    elements: tuple[Count, Count, Count] = (8, 1, 8)
    degree: Degree = 2
    young: Annotated[Pascal, Positive] = 210e9
    poisson: Annotated[Number, Field(gt=-1.0, lt=0.5)] = 0.3
    density: Annotated[Density, Positive] = 7850.0
    top_mass: Annotated[Kilograms, Positive] = 2000.0
    top_euler: tuple[Moment, Moment, Moment] = (4000.0, 200.0, 4000.0)


def _check_wall(t: TowerCase) -> str:
    """The tower is hollow."""
    inner = 0.5 * min(t.bottom_diameter, t.top_diameter)
    if not t.flexible or t.wall < inner:
        return ""
    return (
        f"tower.wall = {t.wall:g}: leaves no hollow, expected less than {inner:g} m, half of the "
        "smaller diameter"
    )


def _check_size(t: TowerCase) -> str:
    """The tower is a tube, and not too large to be counted."""
    if not t.flexible:
        return ""
    around, through, along = (t.degree * n for n in t.elements)
    if t.elements[0] < 3:
        return f"tower.elements = {quote(list(t.elements))}: expected 3 or more around the tower"
    displacements = 3.0 * around * (through + 1.0) * (along + 1.0)
    if displacements < MAX_UNKNOWNS:
        return ""
    return (
        f"tower.elements = {quote(list(t.elements))}: gives some {displacements:.1e} "
        f"displacements, expected fewer than {MAX_UNKNOWNS:.1e}"
    )


TOWER_CHECKS: tuple[tuple[tuple[str, ...], Callable[[TowerCase], str]], ...] = (
    (("tower.wall", "tower.bottom_diameter", "tower.top_diameter"), _check_wall),
    (("tower.elements", "tower.degree"), _check_size),
)
"""The keys that a check looks at, the guilty one first, and the check: a sentence or nothing."""


def idle_tower_keys(tower: TowerCase) -> IdleKeys:
    """Keys without effect."""
    if not tower.flexible:
        others = set(type(tower).model_fields) - {"flexible"}
        yield "tower", tuple(others), "without tower.flexible = true"

"""The table of the tower."""

from __future__ import annotations

from itertools import pairwise
from math import prod
from typing import Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Density, Kilograms, Metres, Number, Pascal
from turbine_fenicsx.case.rules import Beside, If, Only
from turbine_fenicsx.case.section import (
    MAX_ELEMENTS,
    Count,
    Degree,
    Flag,
    Moment,
    NotNegative,
    Positive,
    Section,
)
from turbine_fenicsx.foundation.plausible import Plausible
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.beam import TowerBeamCase
from turbine_fenicsx.turbine.tables.damping import TowerDamping, TowerDampingCase, check_damping
from turbine_fenicsx.turbine.tables.reduction import TowerReductionCase

_NO_FULL_BLADES = If(lambda case: not case.has_full_blades, "beside blades on their whole mesh")
_WIDTH, _WALL = Plausible(0.2, 30.0), Plausible(1e-3, 1.0)


class TowerCase(Section):
    """Tower: a hollow tube of hexahedra below the yaw bearing, clamped to the ground.

    It is a cone from ``bottom_diameter`` to ``top_diameter`` with a uniform ``wall``, or linear
    between ``stations``, fractions of the height, with ``diameters`` and ``walls`` at these.

    A rigid body at its top, of the mass and Euler values in e1, e2, e3 given here, carries the yaw
    bearing. With ``flexible = false`` the yaw bearing stands on the ground.
    """

    rules = (Only("flexible", True),)

    flexible: Flag = False
    """Whether there is a flexible tower, see howto/turbine_options."""
    height: Annotated[Metres, Positive, Plausible(5.0, 400.0)] = 80.0
    """Height of the yaw bearing above the foot."""
    bottom_diameter: Annotated[Metres, Positive, Beside("stations"), _WIDTH] = 6.0
    """Outer diameter at the foot."""
    top_diameter: Annotated[Metres, Positive, Beside("stations"), _WIDTH] = 4.0
    """Outer diameter at the top."""
    wall: Annotated[Metres, Positive, Beside("stations"), _WALL] = 0.04
    """Thickness of the wall, less than half of the diameters."""
    stations: tuple[Annotated[Number, NotNegative], ...] | None = None
    """Places along the height, as fractions from 0 at the foot to 1; with ``diameters`` and
    ``walls`` in place of a cone."""
    diameters: Annotated[tuple[Annotated[Metres, Positive], ...] | None, _WIDTH] = None
    """Outer diameter at each station, linear between."""
    walls: Annotated[tuple[Annotated[Metres, Positive], ...] | None, _WALL] = None
    """Thickness of the wall at each station, linear between."""
    elements: tuple[Count, Count, Count] = (8, 1, 8)
    """Numbers of hexahedra around, 3 or more, through the wall and along the height."""
    degree: Degree = 2
    """Polynomial degree of the displacement; 2 for curved cells, 1 is much too stiff."""
    young: Annotated[Pascal, Positive, Plausible(1e9, 5e11)] = 210e9
    """Young's modulus E."""
    poisson: Annotated[Number, Field(gt=-1.0, lt=0.5)] = 0.3
    """Poisson's ratio."""
    density: Annotated[Density, Positive, Plausible(200.0, 2e4)] = 7850.0
    """Density."""
    model: Annotated[Literal["full", "reduced", "beam"], _NO_FULL_BLADES] = "full"
    """Tower on its whole mesh; or beside rigid, reduced and beam blades as some functions of it
    move, see howto/reduced_turbine, or as a beam of its tube, see howto/beam_turbine."""
    beam: Annotated[TowerBeamCase, Only("model", "beam"), _NO_FULL_BLADES] = TowerBeamCase()
    reduction: Annotated[TowerReductionCase, Only("model", "reduced"), _NO_FULL_BLADES] = (
        TowerReductionCase()
    )
    damping: TowerDamping = TowerDampingCase()
    """Structural damping: a ratio such as ``"1 %"``, or a table with ratios of named modes, see
    howto/damping; 1 % beside ``turbine.file``."""
    top_mass: Annotated[Kilograms, Positive, Plausible(10.0, 1e6)] = 2000.0
    """Mass of the rigid body at the top, which carries the yaw bearing."""
    top_euler: tuple[Moment, Moment, Moment] = (4000.0, 200.0, 4000.0)
    """Principal values of its Euler tensor along e₁, e₂, e₃."""

    @check("wall", "bottom_diameter", "top_diameter")
    def _check_wall(self, case: Any) -> str:
        """The tower is hollow."""
        inner = 0.5 * min(self.bottom_diameter, self.top_diameter)
        if not self.flexible or self.stations is not None or self.wall < inner:
            return ""
        return (
            f"tower.wall = {self.wall:g}: leaves no hollow, expected less than {inner:g} m, half "
            "of the smaller diameter"
        )

    @check("stations", "diameters", "walls")
    def _check_stations(self, case: Any) -> str:
        """Stations rise from 0 to 1, and each has a diameter and a wall."""
        lists = {"stations": self.stations, "diameters": self.diameters, "walls": self.walls}
        missing = [name for name, values in lists.items() if values is None]
        if not self.flexible or len(missing) == len(lists):
            return ""
        if missing:
            there = " and ".join(f"tower.{name}" for name in lists if name not in missing)
            return f"tower.{missing[0]}: expected beside {there}"
        s, d, w = (values or () for values in lists.values())
        if len(s) < 2 or (s[0], s[-1]) != (0.0, 1.0) or not all(a < b for a, b in pairwise(s)):
            return (
                f"tower.stations = {quote(list(s))}: expected increasing fractions of the height "
                "that begin with 0 and end with 1"
            )
        for name, values in (("diameters", d), ("walls", w)):
            if len(values) != len(s):
                return (
                    f"tower.{name} = {quote(list(values))}: expected one for each of the {len(s)} "
                    f"tower.stations, got {len(values)}"
                )
        for wall, diameter in zip(w, d, strict=True):
            if wall >= 0.5 * diameter:
                return (
                    f"tower.walls: {wall:g} leaves no hollow, expected less than "
                    f"{0.5 * diameter:g} m, half of the diameter there"
                )
        return ""

    @check("elements")
    def _check_size(self, case: Any) -> str:
        """The tower is a tube, of not absurdly many elements."""
        words = f"tower.elements = {quote(list(self.elements))}: expected"
        if not self.flexible:
            return ""
        if self.elements[0] < 3:
            return f"{words} 3 or more around the tower"
        if prod(self.elements) <= MAX_ELEMENTS:
            return ""
        return f"{words} at most {MAX_ELEMENTS} elements, got {prod(self.elements)}"

    @check("damping")
    def _check_damping(self, case: Any) -> str:
        """Ratios go together."""
        return check_damping("tower.damping", self.damping)

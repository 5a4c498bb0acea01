"""The table of the shape, layup and damping of a blade."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import cos, pi, tan
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Metres, Number, Radians
from turbine_fenicsx.case.rules import Beside, NotBeside, Only, Unless, With
from turbine_fenicsx.case.section import NotNegative, Positive, Section
from turbine_fenicsx.foundation.plausible import DEGREE, Plausible
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.tables.beam import BeamCase
from turbine_fenicsx.turbine.tables.damping import BladeDamping, BladeDampingCase, check_damping
from turbine_fenicsx.turbine.tables.reduction import ReductionCase

if TYPE_CHECKING:  # no case needs MPI to be read
    from turbine_fenicsx.meshing import BladeGeometry

_BUILT_MASS, _BUILT_LENGTH, _BUILT_POWER = 17.7e3, 61.5, 2.3
"""Mass [kg] and length [m] of a blade of the NREL 5 MW turbine; how masses grow with length."""

_FAR_OFF = 15.0
"""Times lighter or heavier than a built blade; the paper's solid blades are 10 times heavier."""

SOLID = "they are hollow, so a solid one needs a density to match"
"""Advice about the mass of blades without a wall, or with a thick one."""

SHAPE = ("hub_radius", "length", "stations", "chord", "thickness", "wall", "twist")
"""Keys of the shape."""

QUADRATIC = ("transversely_isotropic", "st_venant_kirchhoff", "windio")
"""Laws of the material whose energy is quadratic in the strain."""

_OF_FILE = (
    NotBeside("turbine.file", "which has the shape of the blades"),
    Beside("mesh.file", say="on the run beside mesh.file"),
)

_NO_BEAM = Unless("model", "beam")

Fractions = tuple[Annotated[Number, NotNegative], ...]
Widths = tuple[Annotated[Metres, Positive], ...]


def find_mass_warning(mass: float, length: float, advice: str = "") -> list[str]:
    """A sentence if a blade is far lighter or heavier than built ones.

    Args:
        mass: Of one blade [kg].
        length: Its length [m].
        advice: What to look at.
    """
    built = _BUILT_MASS * (length / _BUILT_LENGTH) ** _BUILT_POWER
    if built / _FAR_OFF <= mass <= built * _FAR_OFF:
        return []
    after = f"; {advice}" if advice else ""
    return [
        f"a blade of {length:.4g} m has {mass / 1e3:.3g} t, built ones have about "
        f"{built / 1e3:.2g} t{after}"
    ]


class BladeCase(Section):
    """Shape of a blade, see `turbine_fenicsx.meshing.BladeGeometry`; or layup of that of a file.

    ``"homogenised"`` walls have the stiffness of their plies in the plane, ``"laminate"`` walls
    also in bending.
    """

    hub_radius: Annotated[Metres, Positive, Plausible(0.1, 10.0)] = 2.25
    """Radius of the hub, where the blades begin."""
    length: Annotated[Metres, Positive, Plausible(1.0, 250.0)] = 54.0
    """Length from the hub to the tip."""
    stations: Annotated[Fractions, *_OF_FILE] = (0.0, 0.2, 1.0)
    """Places along the span, as fractions of the length, from 0 to 1."""
    chord: Annotated[Widths, *_OF_FILE, Plausible(0.05, 20.0, whole=True)] = (1.8, 3.0, 0.6)
    """Full width along the chord, one for each station."""
    thickness: Annotated[Widths, *_OF_FILE, Plausible(0.02, 15.0, whole=True)] = (1.8, 1.5, 0.2)
    """Full width across the chord, one for each station."""
    wall: Annotated[Widths | None, *_OF_FILE, _NO_BEAM, Plausible(5e-4, 0.5, whole=True)] = None
    """Thickness of the wall of hollow blades, one for each station; none: they are solid."""
    twist: Annotated[
        tuple[Annotated[Radians, Field(ge=-pi, le=pi)], ...] | None,
        *_OF_FILE,
        _NO_BEAM,
        Plausible(1.0 * DEGREE, 50.0 * DEGREE, whole=True),
    ] = None
    """Angle by which the leading edge is turned upwind, as in OpenFAST, one for each station;
    none: no twist."""
    layup: Annotated[Literal["homogenised", "laminate"], With("turbine.file"), _NO_BEAM] = (
        "homogenised"
    )
    """Walls of blades of ``turbine.file``: with the in-plane stiffness of their plies, or with
    their bending stiffness too."""
    model: Annotated[Literal["full", "reduced", "beam"], Only("turbine.model", "hybrid")] = "full"
    """Blades on their whole mesh; as some dozen functions of it move, see howto/reduced_turbine; or
    as beams of section matrices, see howto/beam_turbine."""
    beam: Annotated[BeamCase, Only("model", "beam")] = BeamCase()
    reduction: Annotated[ReductionCase, Only("model", "reduced")] = ReductionCase()
    damping: Annotated[BladeDamping, Only("turbine.model", "hybrid")] = BladeDampingCase()
    """Structural damping: a ratio such as ``"0.5 %"``, or a table with ratios of named modes, see
    howto/damping; 0.5 % beside ``turbine.file``."""

    def geometry(self) -> BladeGeometry:
        """The shape of a blade with elliptic sections.

        Raises:
            ModelError: if stations and widths do not fit together.
        """
        from turbine_fenicsx.meshing import BladeGeometry

        return BladeGeometry(**self.model_dump(include=set(SHAPE)))

    @check(
        "model",
        "beam.file",
        "turbine.model",
        "turbine.file",
        "mesh.file",
        "material.law",
        "time.scheme",
    )
    def _check_model(self, case: Any) -> str:
        """The law of reduced blades is quadratic in the strain, and their scheme conserves."""
        if self.model == "full" or case.turbine.model == "rigid":
            return ""
        law, scheme = case.material.law, case.time.scheme
        if self.model == "beam" and case.mesh.file is not None:
            return 'blade.model = "beam": expected none beside mesh.file'
        if self.model == "beam" and self.beam.file is None and case.turbine.file is None:
            return 'blade.model = "beam": expected turbine.file or blade.beam.file'
        if self.model == "reduced" and law not in QUADRATIC:
            return (
                f'blade.model = "reduced": expected a material.law that is quadratic in the '
                f'strain, one of {", ".join(QUADRATIC)}, not "{law}"'
            )
        if scheme != "energy_momentum":
            return (
                f'blade.model = "{self.model}": expected time.scheme = "energy_momentum", not '
                f'"{scheme}"'
            )
        return ""

    @check("stations")
    def _check_stations(self, case: Any) -> str:
        """Stations increase from 0 to 1."""
        s = self.stations
        if len(s) >= 2 and (s[0], s[-1]) == (0.0, 1.0) and all(a < b for a, b in pairwise(s)):
            return ""
        return (
            f"blade.stations = {quote(s)}: expected increasing fractions of the span that begin "
            "with 0 and end with 1, for example [0, 0.2, 1]"
        )

    @check("chord", "stations")
    def _check_chord(self, case: Any) -> str:
        """As many chords as stations."""
        return self._check_count("chord", "width")

    @check("thickness", "stations")
    def _check_thickness(self, case: Any) -> str:
        """As many thicknesses as stations."""
        return self._check_count("thickness", "width")

    @check("twist", "stations")
    def _check_twist(self, case: Any) -> str:
        """As many angles as stations, if there are any."""
        return self._check_count("twist", "number")

    @check("wall", "stations", "chord", "thickness")
    def _check_wall(self, case: Any) -> str:
        """One wall per station, which leaves a hollow."""
        sentence = self._check_count("wall", "number")
        if sentence or self.wall is None:
            return sentence
        sections = zip(self.stations, self.wall, self.chord, self.thickness, strict=True)
        for station, wall, *widths in sections:
            if wall >= min(widths) / 2.0:
                return (
                    f"blade.wall = {wall:g} at station {station:g}: leaves no hollow, expected "
                    f"less than {min(widths) / 2.0:g} m, half of the section there"
                )
        return ""

    def _check_count(self, name: str, what: str) -> str:
        """As many values as stations, if there are any."""
        values, n = getattr(self, name), len(self.stations)
        if values is None or len(values) == n:
            return ""
        return (
            f"blade.{name} = {quote(values)}: expected one {what} for each of the {n} "
            f"blade.stations, got {len(values)}"
        )

    @check("hub_radius", "chord", "thickness", "mesh.file", "turbine.precone")
    def _check_clearance(self, case: Any) -> str:
        """The roots of three built-in blades do not overlap."""
        width = max(self.chord[0], self.thickness[0])
        needed = width / 2.0 / tan(pi / 3.0) / cos(case.turbine.precone)
        given = case.turbine.file is not None or case.mesh.file is not None
        if given or case.turbine.model == "rigid" or self.hub_radius >= needed:
            return ""
        return (
            f"blade.hub_radius = {self.hub_radius:g}: three blades that are {width:g} m wide at "
            f"the root overlap, expected at least {needed:.4g} m"
        )

    @check("damping", "material.shear_viscosity", "material.bulk_viscosity")
    def _check_damping(self, case: Any) -> str:
        """Blades are damped in one way."""
        m = case.material
        viscous = [x for x in ("shear_viscosity", "bulk_viscosity") if getattr(m, x) > 0.0]
        if viscous and self.damping.acts:
            return f"blade.damping: expected none beside material.{viscous[0]}"
        return check_damping("blade.damping", self.damping)

    def find_doubts(self, case: Any) -> Iterator[str]:
        """The blades weigh about what blades do; those of a file are looked at with their mesh."""
        if case.turbine.file is not None:
            return
        if case.turbine.model == "rigid":
            yield from find_mass_warning(case.turbine.blade.mass, self.length)
        elif case.mesh.file is None and self.model != "beam":
            shape = self.geometry()
            mass = shape.volume * case.material.density
            yield from find_mass_warning(mass, shape.length, SOLID)

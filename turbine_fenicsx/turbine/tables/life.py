"""The table of the life of the plies."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from turbine_fenicsx.case.contradictions import check
from turbine_fenicsx.case.quantities import Metres, Number, Pascal
from turbine_fenicsx.case.rules import Only, With
from turbine_fenicsx.case.section import Positive, Section
from turbine_fenicsx.foundation.plausible import Plausible

Strength = Annotated[Pascal, Positive, Plausible(1e5, 1e10)]
Slope = Annotated[Number, Field(ge=1.0, le=100.0)]
Factor = Annotated[Number, Field(ge=0.1, le=10.0)]


class LifeMaterialCase(Section):
    """How a material of ``turbine.file`` lasts, in place of what the file says.

    NAME is that of the material.
    """

    slope: Slope | None = None
    """Slope m of its S-N curves S = S₁/N^(1/m); none: that of the file, or that of plies of its
    family: 14 with carbon fibres, 10 with glass fibres, 9 if biaxial."""
    tension: tuple[Strength, Strength] | None = None
    """Strengths in tension, along and across the fibre."""
    compression: tuple[Strength, Strength] | None = None
    """Strengths in compression, along and across the fibre."""
    shear: Strength | None = None
    """Strength in shear."""
    first: Annotated[Strength | None, Only("life.diagram", "goodman")] = None
    """Amplitude S₁ of the S-N curve along the fibre, about zero; none: ``A`` of the file, or the
    lesser strength."""


class AdhesiveCase(Section):
    """The adhesive at feet of webs and trailing edges, whose life is estimated if it is given.

    Moduli, strengths and slope are those of the material ``name`` of ``turbine.file``, if there is
    one, unless they are given.
    """

    thickness: Annotated[Metres, Positive, Plausible(1e-4, 0.05)] | None = None
    """Its thickness; none: no bonds."""
    width: Annotated[Metres, Positive, Plausible(0.005, 0.5)] | None = None
    """Width of a bond, across the span."""
    name: str = "adhesive"
    """Name of its material in the file; capitals do not matter."""
    young: Annotated[Pascal, Positive] | None = None
    """Young's modulus."""
    shear_modulus: Annotated[Pascal, Positive] | None = None
    """Shear modulus."""
    tension: Strength | None = None
    """Strength in peel."""
    compression: Strength | None = None
    """Strength in compression; none: that of the file, or as in peel."""
    shear: Strength | None = None
    """Strength in shear."""
    slope: Slope | None = None
    """Slope m of its S-N curves; none: that of the file, or 10."""

    @check("thickness", "width")
    def _check_bond(self, case: Any) -> str:
        """A bond has a thickness and a width."""
        if (self.thickness is None) == (self.width is None):
            return ""
        given = "thickness" if self.width is None else "width"
        return f"life.adhesive.{given}: expected both thickness and width, or neither"


class LifeCase(Section):
    """How the command ``life`` finds the damage of the plies, see howto/ply_life."""

    rules = (With("turbine.file"), Only("blade.model", "reduced"))

    years: Annotated[Number, Field(gt=0.0, le=1000.0)] = 20.0
    """Life of the turbine in years, in which a run is repeated; a load set has its own."""
    diagram: Literal["shifted_goodman", "goodman"] = "shifted_goodman"
    """How the mean of a cycle counts."""
    strength_factor: Factor = 1.0
    """Partial factor of the strengths, by which means are multiplied."""
    fatigue_factor: Factor = 1.0
    """Partial factor of fatigue, by which amplitudes are multiplied."""
    adhesive: AdhesiveCase = AdhesiveCase()
    material: dict[str, LifeMaterialCase] = Field(default_factory=dict)

"""The table of blades and towers that are beams."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from turbine_fenicsx.case.quantities import Number, Whole
from turbine_fenicsx.case.section import Section


class BeamCase(Section):
    """Finite elements of blades or towers that are beams, see howto/beam_turbine."""

    elements: Annotated[Whole, Field(ge=1, le=60)] = 8
    """Number of elements along the axis."""
    degree: Annotated[Whole, Field(ge=1, le=5)] = 3
    """Polynomial degree of their functions."""
    hold: Annotated[Number, Field(gt=0.0, le=10.0)] = 0.01
    """Stiffness that keeps sections whole, over that of stretch: less takes fewer iterations, more
    is exact for thick beams."""

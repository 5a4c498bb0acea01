"""A blade as a beam, as files of several codes have it."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections


@dataclass(frozen=True, eq=False)
class BeamBlade:
    """A blade from a file.

    Args:
        line: Its axis from the root, x downwind, y to the trailing edge, z along the span.
        sections: Stiffness, mass and viscosity along the axis.
        warnings: Settings that are not followed, a sentence each.
    """

    line: BeamLine
    sections: BeamSections
    warnings: tuple[str, ...] = ()

"""The table of blades and towers that are beams."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from turbine_fenicsx.case.files import DataFile
from turbine_fenicsx.case.quantities import Number, Whole
from turbine_fenicsx.case.rules import With
from turbine_fenicsx.case.section import Section
from turbine_fenicsx.turbine.tables.named_files import list_beam_parts


class BeamElementsCase(Section):
    """Finite elements of a beam."""

    elements: Annotated[Whole, Field(ge=1, le=60)] = 8
    """Number of elements along the axis."""
    degree: Annotated[Whole, Field(ge=1, le=5)] = 3
    """Polynomial degree of their functions."""
    hold: Annotated[Number, Field(gt=0.0, le=10.0)] = 0.01
    """Stiffness that keeps sections whole, over that of stretch: less takes fewer iterations, more
    is exact for thick beams."""


class BeamCase(BeamElementsCase):
    """Finite elements of blades that are beams of section matrices, see howto/beam_turbine."""

    file: Annotated[str | None, DataFile("file of a beam", parts=list_beam_parts)] = None
    """Primary file of BeamDyn, or ``.htc`` file of HAWC2 with the body ``blade1``: axis and
    matrices of the blades, in place of those of ``turbine.file``, which then may be missing."""
    taper: Annotated[bool, With("turbine.file")] = False
    """Whether bending turns sections where walls of the layup of ``turbine.file`` are inclined,
    which prismatic matrices leave out, see theory/beams."""


class TowerBeamCase(BeamElementsCase):
    """Finite elements of a tower that is a beam of its tube, see howto/beam_turbine."""

    file: Annotated[str | None, DataFile("file of the tower")] = None
    """Tower file of ElastoDyn, with mass and stiffness in place of those of the tube."""

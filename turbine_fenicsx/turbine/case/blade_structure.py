"""The structure of beam blades: axis and section matrices, from the file that has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.reduction.beam_sections import BeamSections
from turbine_fenicsx.turbine.case.beam_file import load_beam
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.windio import WindIOTurbine
from turbine_fenicsx.windio.outer_shape import OuterShape

ALONG = 400
"""Points along a curved axis."""


@dataclass(frozen=True, eq=False)
class BladeStructure:
    """A blade as a beam, from its root along x (suction side), y (trailing edge) and z.

    Args:
        stations: Arc lengths of the matrices, shape (m,) [m].
        stiffness: Shape (m, 6, 6).
        inertia: Shape (m, 6, 6).
        viscosity: Times of the damping of each strain, shape (6,) [s].
    """

    line: BeamLine
    stations: Array
    stiffness: Array
    inertia: Array
    viscosity: Array

    @property
    def sections(self) -> BeamSections:
        """The matrices as a beam has them.

        Raises:
            ModelError: for matrices that no section can have, with the station.
        """
        return BeamSections(self.stations, self.stiffness, self.inertia, self.viscosity)


def find_structure(case: Tables) -> BladeStructure:
    """The structure of beam blades, or of blades of a ``turbine.file`` with section matrices."""
    file, mu = case.blade.beam.file, np.array(case.blade.damping.mu or (0.0,) * 6)
    if file is None or not case.has_beam_blades:
        assert case.turbine.file is not None
        return _read_windio(load_turbine(case.turbine.file), mu)
    blade = load_beam(file)
    s = blade.sections
    return BladeStructure(blade.line, s.stations, s.stiffness, s.inertia, mu)


def make_line(outer: OuterShape, grid: Array | tuple[float, ...] = ()) -> BeamLine:
    """The axis of a blade from its root, over span fractions, x to the suction side.

    Args:
        grid: Span fractions that are among those of the line.
    """
    stations = np.unique(np.concatenate([np.linspace(0.0, 1.0, ALONG), grid]))
    to_trailing, to_suction = outer.frames(stations)
    directors = np.stack([to_suction, to_trailing], axis=1)
    return BeamLine(stations, outer.reference_points(stations), directors)


def _read_windio(turbine: WindIOTurbine, mu: Array) -> BladeStructure:
    """The structure of a windIO file."""
    p = turbine.blade_sections
    assert p is not None
    line = make_line(turbine.blade.outer_shape, p.grid)
    return BladeStructure(line, line.arc_length(p.grid), p.stiffness, p.inertia, mu)

"""Sections of the blade of a case with a windIO file, beside the matrices that the file has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.section_matrices import interpolate_matrices
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.sections.properties import find_properties
from turbine_fenicsx.turbine.blades.beam_blades import place_line
from turbine_fenicsx.turbine.blades.blade_sections import BladeSections, analyse_rows
from turbine_fenicsx.turbine.blades.wall_rows import WallRows
from turbine_fenicsx.turbine.case.blade_structure import make_line
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.windio import WindIOTurbine

COMPARED = {
    "mass": "mass_[kg/m]",
    "EA": "stretch_stiffness_[N]",
    "EI 1": "bending_stiffness_1_[Nm2]",
    "EI 2": "bending_stiffness_2_[Nm2]",
    "GJ": "torsion_stiffness_[Nm2]",
}
"""Columns that are compared with those of the file."""

BETWEEN = 0.15, 0.9
"""Span fractions between which they are compared; layers begin and end beyond."""


@dataclass(frozen=True, eq=False)
class CaseSections:
    """Sections of a case.

    Args:
        line: Axis from the root, over span fractions.
        given: The same columns of the matrices of the file, a row for each section; none if it
            has no matrices.
    """

    sections: BladeSections
    line: BeamLine
    given: list[dict[str, float]]

    @cached_property
    def own(self) -> list[dict[str, float]]:
        """Columns of each section."""
        of = self.sections
        return [find_properties(C, M) for C, M in zip(of.stiffness, of.inertia, strict=True)]

    def compare(self) -> list[str]:
        """A sentence on the differences from the matrices of the file."""
        part = self.sections.stations / self.sections.length
        within = (part >= BETWEEN[0]) & (part <= BETWEEN[1])
        if not self.given or not within.any():
            return []
        gaps = []
        for word, key in COMPARED.items():
            own, given = (np.array([row[key] for row in rows]) for rows in (self.own, self.given))
            ratio = own[within] / given[within] - 1.0
            gaps.append(f"{word} {100.0 * ratio.min():+.1f} to {100.0 * ratio.max():+.1f} %")
        return [
            f"beside the matrices of the file, from {BETWEEN[0]:g} to {BETWEEN[1]:g} of the span: "
            + ", ".join(gaps)
        ]


def find_sections(
    case: Case, stations: int, around: int, found: Callable[[int], object] = lambda done: None
) -> CaseSections:
    """Find the sections of the blade of a case.

    Args:
        stations: Number of sections.
        around: Number of cells around each, without those of webs.
        found: Called after each with the number of those that are done.

    Raises:
        InputError: if the case has no windIO file, or blades without a layup.
        MeshError: if there are too few cells for the webs.
    """
    file = case.turbine.file
    turbine = load_turbine(file) if file is not None else None
    if turbine is None or not turbine.blade.has_layup:
        raise InputError(
            "turbine.file: expected a windIO file whose blades have layers "
            "(components.blade.structure.layers), to find their sections"
        )
    line = make_line(turbine.blade.outer_shape)
    placed = place_line(line, turbine.blade.hub_radius)
    walls = WallRows.of(turbine.blade, placed, stations, around)
    sections = analyse_rows(walls, case.blade.layup == "laminate", found)
    return CaseSections(sections, line, find_given(turbine, sections.stations))


def find_given(turbine: WindIOTurbine, s: Array) -> list[dict[str, float]]:
    """Columns of the matrices of a file at arc lengths; none if it has none that can be."""
    p = turbine.blade_sections
    if p is None:
        return []
    at = make_line(turbine.blade.outer_shape).arc_length(p.grid)
    C, M = (interpolate_matrices(s, at, x) for x in (p.stiffness, p.inertia))
    if np.any(np.linalg.eigvalsh(C)[:, 0] <= 0.0) or np.any(M[:, 2, 2] <= 0.0):
        return []
    return [find_properties(*both) for both in zip(C, M, strict=True)]

"""Warnings from sections: a mesh that is too coarse, matrices that are not those of the layup."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.laminate_theory import tabulate_walls
from turbine_fenicsx.sections.properties import find_properties
from turbine_fenicsx.turbine.blades.beam_blades import place_line
from turbine_fenicsx.turbine.blades.blade_sections import analyse_row
from turbine_fenicsx.turbine.blades.wall_rows import WallRows
from turbine_fenicsx.turbine.blades.windio_sections import COMPARED, find_given
from turbine_fenicsx.turbine.case.blade_structure import make_line
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.windio import WindIOTurbine

PLACES = (0.3, 0.5, 0.7, 0.85)
"""Span fractions near which sections are looked at."""

FINE_SPAN, FINE_AROUND = 50, 64
"""Numbers of cells of a fine mesh."""

LARGEST_GAP = 0.05
"""Largest relative difference of a stiffness, or of the mass, without a warning."""


def list_section_doubts(case: Case) -> list[str]:
    """A sentence if sections of the mesh, or the matrices of the file, are not those of the layup.

    Cells of the mesh count where blades are solid or reduced, matrices of the file where blades are
    beams of them. Takes some seconds.
    """
    file, beams = case.turbine.file, case.has_beam_blades
    if file is None or case.turbine.model != "hybrid" or not load_turbine(file).blade.has_layup:
        return []
    others = case.blade.beam.file if beams else case.mesh.file
    if others is not None:
        return []
    try:
        return _compare_matrices(file) if beams else _compare_cells(case, file)
    except ModelError as error:
        return [f"sections of the blades cannot be compared: {error}"]


def _compare_cells(case: Case, file: str) -> list[str]:
    """A sentence on cells that are too coarse."""
    mesh, moments = case.mesh, case.blade.layup == "laminate"
    fine, rows = _make_walls(load_turbine(file), mesh.span, FINE_AROUND)
    own, _ = _make_walls(load_turbine(file), mesh.span, mesh.around)
    numbers = (_find_columns(walls, rows, moments) for walls in (own, fine))
    gaps = _describe_gaps(*numbers)
    if not gaps:
        return []
    return [
        f"mesh.around = {mesh.around}: cells are too coarse for the stiffness of sections: {gaps} "
        f"beside those of {FINE_AROUND} cells"
    ]


def _compare_matrices(file: str) -> list[str]:
    """A sentence on matrices that are not those of the layup."""
    turbine = load_turbine(file)
    fine, rows = _make_walls(turbine, FINE_SPAN, FINE_AROUND)
    given = find_given(turbine, fine.stations[rows])
    if not given:
        return []
    other = np.array([[row[key] for key in COMPARED.values()] for row in given])
    gaps = _describe_gaps(other, _find_columns(fine, rows, moments=True))
    if not gaps:
        return []
    return [
        f"{file}: the matrices of beams are not those of its layup: {gaps}; "
        "`turbine-fenicsx sections` finds these, for blade.beam.file"
    ]


def _make_walls(turbine: WindIOTurbine, span: int, around: int) -> tuple[WallRows, list[int]]:
    """Walls of a blade, and the rows near `PLACES`."""
    blade = turbine.blade
    line = place_line(make_line(blade.outer_shape), blade.hub_radius)
    walls = WallRows.of(blade, line, span, around)
    part = walls.stations / line.length
    return walls, [int(np.argmin(np.abs(part - place))) for place in PLACES]


def _find_columns(walls: WallRows, rows: list[int], moments: bool) -> Array:
    """Numbers of some sections that are compared, shape (rows, columns)."""
    table = tabulate_walls(walls.plies, walls.cells.thickness, moments)
    sections = [analyse_row(walls, k, table) for k in rows]
    found = [find_properties(section.stiffness, section.inertia) for section in sections]
    return np.array([[row[key] for key in COMPARED.values()] for row in found])


def _describe_gaps(found: Array, good: Array) -> str:
    """The columns that differ too much, with their largest difference; empty if none does."""
    ratios = found / good - 1.0
    worst = ratios[np.abs(ratios).argmax(axis=0), np.arange(ratios.shape[1])]
    pairs = zip(COMPARED, worst, strict=True)
    return ", ".join(f"{word} {100.0 * x:+.0f} %" for word, x in pairs if abs(x) > LARGEST_GAP)

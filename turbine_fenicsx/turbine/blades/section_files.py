"""Sections of a blade as files: a table, and beams for BeamDyn, HAWC2 and windIO."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from turbine_fenicsx.beam_files.beam_blade import BeamBlade
from turbine_fenicsx.beam_files.write_beamdyn import write_beamdyn
from turbine_fenicsx.beam_files.write_hawc2 import write_hawc2
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.output_folder import SECTIONS, make_target_folder
from turbine_fenicsx.records.row_file import write_table
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.sections.properties import find_properties
from turbine_fenicsx.turbine.blades.blade_sections import BladeSections
from turbine_fenicsx.windio.write_section_properties import write_section_properties

KINDS = {"prisms": False, "inclined": True}
"""Folders of beams, and whether their walls are inclined."""

FINE = np.linspace(0.0, 1.0, 2001)
"""Span fractions between which those of arc lengths are straight."""


def tabulate_sections(found: BladeSections) -> list[dict[str, float]]:
    """A row for each section, from the root."""
    return [
        {"span_[-]": float(s / found.length), "arc_length_[m]": float(s)} | find_properties(C, M)
        for s, C, M in zip(found.stations, found.stiffness, found.inertia, strict=True)
    ]


def write_sections(
    folder: Path,
    found: BladeSections,
    line: BeamLine,
    title: str,
    mu: tuple[float, ...] = (0.0,) * 6,
) -> list[str]:
    """Write the table, and beams of prisms and of inclined walls; names of files and folders.

    Args:
        line: Axis from the root of the blade, over span fractions.
        title: Of the blade.
        mu: Times of stiffness-proportional damping of each strain [s].
    """
    rows = tabulate_sections(found)
    write_table(folder / SECTIONS, [*rows[0]], ([f"{x:.9g}" for x in r.values()] for r in rows))
    for kind, taper in KINDS.items():
        beam = found.as_beam(taper, mu)
        own, blade = make_target_folder(folder / kind), BeamBlade(line, beam)
        words = f"{title}, {kind}"
        write_beamdyn(own / "beamdyn.dat", blade, words)
        write_hawc2(own / "hawc2.htc", blade, words)
        grid = _find_fractions(line, np.asarray(beam.stations))
        write_section_properties(own / "windio.yaml", grid, beam.stiffness, beam.inertia)
    return [SECTIONS, *(f"{kind}/" for kind in KINDS)]


def _find_fractions(line: BeamLine, s: Array) -> Array:
    """Span fractions of arc lengths."""
    return np.asarray(np.interp(s, line.arc_length(FINE), FINE))

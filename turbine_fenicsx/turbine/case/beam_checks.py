"""Checks of the structure of blades of a file: a layup, section matrices, or a file of beams."""

from __future__ import annotations

from pathlib import Path

from turbine_fenicsx.case.contradictions import Check
from turbine_fenicsx.foundation.errors import FileError, InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.case.beam_file import load_beam
from turbine_fenicsx.turbine.case.turbine_file import load_turbine
from turbine_fenicsx.turbine.tables.tables import Tables

SAME_LENGTH = 0.01
"""Largest relative difference of the lengths of a blade in two files."""


def _check_beam_file(case: Tables) -> str:
    """A sentence if the file of a beam cannot be read, or is that of another blade."""
    file, turbine = case.blade.beam.file, case.turbine.file
    if file is None or not case.has_beam_blades:
        return ""
    try:
        found = load_beam(file).line.length
    except (InputError, FileError) as error:
        return f"blade.beam.file: {error}"
    wanted = case.blade.length if turbine is None else load_turbine(turbine).blade.length
    if abs(found - wanted) <= SAME_LENGTH * wanted:
        return ""
    other = "as blade.length says" if turbine is None else "as that of turbine.file"
    return (
        f"blade.beam.file: {Path(file).name} has a blade of {found:.4g} m, expected one of "
        f"{wanted:.4g} m, {other}"
    )


def _check_layup(case: Tables) -> str:
    """Flexible blades of a file have a layup, or are beams of section matrices."""
    if case.turbine.file is None:
        return ""
    turbine, name = load_turbine(case.turbine.file), quote(Path(case.turbine.file).name)
    sections, rigid = turbine.blade_sections, case.turbine.model == "rigid"
    if case.has_beam_blades and sections is None and case.blade.beam.file is None:
        return (
            f'blade.model = "beam": expected a file with the 6 x 6 matrices of the blade, '
            f"components.blade.structure.elastic_properties, which {name} does not have; or "
            "blade.beam.file"
        )
    if turbine.blade.has_layup or case.has_beam_blades or (rigid and sections is not None):
        return ""
    if rigid:
        return (
            "turbine.file: expected a file with components.blade.structure.layers or "
            f"components.blade.structure.elastic_properties; {name} has neither"
        )
    return (
        f'blade.model = "{case.blade.model}": expected "beam" beside {name}, which has no layup: '
        "components.blade.structure.layers is missing"
    )


def _check_taper(case: Tables) -> str:
    """Walls that are inclined have a layup."""
    file = case.turbine.file
    if not (case.has_beam_blades and case.blade.beam.taper) or file is None:
        return ""
    if load_turbine(file).blade.has_layup:
        return ""
    return (
        "blade.beam.taper: expected a file with components.blade.structure.layers, which "
        f"{quote(Path(file).name)} does not have"
    )


def _check_tower_file(case: Tables) -> str:
    """The file of a tower can be read."""
    file = case.tower.beam.file
    if file is None or not case.has_beam_tower:
        return ""
    from turbine_fenicsx.beam_files.elastodyn import read_elastodyn_tower

    try:
        read_elastodyn_tower(file, case.tower.height)
    except (InputError, FileError) as error:
        return f"tower.beam.file: {error}"
    return ""


BEAM_CHECKS = (
    Check(("tower.beam.file", "tower.model", "tower.height", "blade.model"), _check_tower_file),
    Check(("blade.model", "blade.beam.file", "turbine.file", "turbine.model"), _check_layup),
    Check(("blade.beam.taper", "blade.model", "turbine.file", "turbine.model"), _check_taper),
    Check(
        ("blade.beam.file", "blade.model", "blade.length", "turbine.file", "turbine.model"),
        _check_beam_file,
    ),
)
"""Checks of the structure of blades of a file."""

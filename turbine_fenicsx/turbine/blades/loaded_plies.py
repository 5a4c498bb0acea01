"""Stresses and failure indices of all plies of a blade, from loads in its sections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.records import names
from turbine_fenicsx.records.loads_along import LoadsAlong
from turbine_fenicsx.records.output_folder import SECTION_PLIES
from turbine_fenicsx.records.row_file import write_table
from turbine_fenicsx.records.steady_tables import SPAN, WIND
from turbine_fenicsx.reduction.beam_line import BeamLine
from turbine_fenicsx.sections.section_plies import SectionPlies
from turbine_fenicsx.turbine.blades.blade_sections import BladeSections

STRESSES = tuple(names.SECTION_PLY_STRESS(component=c) for c in ("11", "22", "12"))
INDICES = tuple(names.SECTION_PLY_INDEX(criterion=name) for name in CRITERIA)
"""Columns of numbers of each ply."""


class LoadedPly(NamedTuple):
    """A ply of a panel or web in a section, at the place where it is nearest to failure.

    Attributes:
        state: Number of the state of the loads, from 1.
        wind: Its wind speed, if there is one [m/s].
        span: Place of the section as a fraction of the length.
        ply: Its number from the outer face, from 1.
        material: Its name.
        angle: From the span to the fibre [rad].
        arc: Fraction of the contour, or of the width of a web.
        stresses: Along the fibre, across it, and shear [Pa].
        indices: By the criteria of `turbine_fenicsx.materials.ply_failure`.
    """

    state: int
    wind: float | None
    span: float
    panel: str
    ply: int
    material: str
    angle: float
    arc: float
    stresses: tuple[float, ...]
    indices: tuple[float, ...]


def find_loaded_plies(
    found: BladeSections, line: BeamLine, states: Sequence[LoadsAlong]
) -> list[LoadedPly]:
    """All plies of the sections that the loads hold for, from the root, state by state.

    Args:
        line: Axis from the root of the blade, along the axes of the loads.
        states: Loads about it, in the axes of the root.

    Raises:
        InputError: if the loads hold for no section.
    """
    span = found.stations / found.length
    turns = find_turns(line, found.stations)
    sections: dict[int, _LayeredSection] = {}
    plies: list[LoadedPly] = []
    for number, state in enumerate(states, 1):
        for k, loads in zip(*state.at(span), strict=True):
            if k not in sections:
                sections[k] = _LayeredSection(found, int(k))
            turned = (loads.reshape(2, 3) @ turns[k].T).ravel()
            plies += sections[k].list_plies(number, state.wind, float(span[k]), turned)
    if not plies:
        places = ", ".join(f"{s:.4g}" for s in span)
        raise InputError(f"the table of loads holds for none of the sections, at {places}")
    return plies


def find_turns(line: BeamLine, stations: Array) -> Array:
    """Axes x, y, z of sections as rows, along those of the line, shape (m, 3, 3)."""
    d = line.at(stations)[1]
    return np.concatenate([d, np.cross(d[:, 0], d[:, 1])[:, None]], axis=1)


class _LayeredSection:
    """The plies of a section, in groups of one number, material and angle of a panel.

    A trailing edge that is hardly wider than thick stands for no layup, and is left out.
    """

    def __init__(self, found: BladeSections, k: int) -> None:
        rows, cells = found.find_cells(k), found.walls.cells
        self._plies = SectionPlies(found.sections[k], [found.walls.plies[c] for c in rows])
        table = self._plies.table
        self._arc = cells.arc[rows].mean(axis=1)[table.wall]
        self._rows = np.flatnonzero(~cells.is_ridge[rows][table.wall])
        number = np.arange(1, len(table.plies) + 1) - table.first[table.wall]
        parts = cells.part[rows][table.wall]
        keys = [
            (cells.panels[parts[j]], int(number[j]), ply.material.name, ply.angle)
            for j, ply in ((j, table.plies[j]) for j in self._rows)
        ]
        self._keys = list(dict.fromkeys(keys))
        known = {key: g for g, key in enumerate(self._keys)}
        self._group = np.array([known[key] for key in keys])

    def list_plies(
        self, state: int, wind: float | None, span: float, loads: Array
    ) -> Iterator[LoadedPly]:
        """The worst place of each group."""
        strains = self._plies.strains(loads)
        table, n = self._plies.table, len(strains)
        stresses = table.stresses(strains).reshape(n, -1, 3)
        indices = np.stack([f(table, strains).reshape(n, -1) for f in CRITERIA.values()], axis=-1)
        # a ply without strengths has no index: the largest stress along it counts
        size = np.where(indices[..., 0] > 0.0, indices[..., 0], 1e-30 * np.abs(stresses[..., 0]))
        point = size.argmax(axis=1)
        order = np.lexsort([-size.max(axis=1)[self._rows], self._group])
        _, first = np.unique(self._group[order], return_index=True)
        for key, j in zip(self._keys, self._rows[order[first]], strict=True):
            values = (tuple(x[j, point[j]].tolist()) for x in (stresses, indices))
            yield LoadedPly(state, wind, span, *key, float(self._arc[j]), *values)


def write_loaded_plies(folder: Path, plies: Sequence[LoadedPly]) -> str:
    """Write a row for each ply; the name of the file."""
    winds = [WIND] if plies[0].wind is not None else []
    head = ["state", *winds, SPAN, "panel", "ply", "material", names.PLY_ANGLE, "arc_[-]"]
    rows = []
    for p in plies:
        wind = [] if p.wind is None else [f"{p.wind:g}"]
        place = [f"{p.span:.6g}", p.panel, str(p.ply), p.material]
        numbers = [np.degrees(p.angle) + 0.0, p.arc, *p.stresses, *p.indices]
        rows.append([str(p.state), *wind, *place, *(f"{x:.6g}" for x in numbers)])
    write_table(folder / SECTION_PLIES, [*head, *STRESSES, *INDICES], rows)
    return SECTION_PLIES


def describe_worst(plies: Sequence[LoadedPly]) -> list[str]:
    """A sentence on the largest index of each criterion; that none is known, if so."""
    lines = []
    for k, criterion in enumerate(CRITERIA):
        p = max(plies, key=lambda ply: ply.indices[k])
        if p.indices[k] > 0.0:
            wind = "" if p.wind is None else f", {p.wind:g} m/s"
            lines.append(
                f"largest index of {criterion}: {p.indices[k]:.3g} in {p.panel}, ply {p.ply} "
                f"({p.material}), at {p.span:.3f} of the span{wind}; 1 is failure"
            )
    return lines or ["no index of failure: no ply whose strengths the file has is loaded"]

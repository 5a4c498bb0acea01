"""Where plies of the blades fail first by fatigue, and the section there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_fatigue import MEASURES
from turbine_fenicsx.turbine.life.ply_life import PlyLife, describe_years
from turbine_fenicsx.turbine.run.wall_history import SAME_ROW

MOST = 10
"""Number of places that are listed."""

FACES = ("outer", "inner")

SIDES = (("rear_panel", "leading_edge"), ("suction_side", "pressure_side"))
"""Parts of names of panels that lie at the end of the axes y and x, and opposite."""

AROUND = np.array([[0.5, 0.0, 1.0], [0.5, 1.0, 1.0], [0.5, 0.5, 1.0], [0.5, 0.5, 0.0]])
"""Points of a cell half way along the span: ends of its outer face, middles of both faces."""


@dataclass(frozen=True)
class WorstPlace:
    """The place of a panel where one of its plies fails first.

    Args:
        damage: Miner's sum over the life, the largest of `damages`; the ply fails at 1 [-].
        index: The fatigue index [-].
        years: Its life; infinite without damage.
        measure: The stress that does it, one of `MEASURES`.
        range: Its largest range [Pa], of the exertion [-].
        panel: Name of the panel or web.
        distance: Of the middle of the cell from the root [m].
        station: The same as a fraction of the span [-].
        ply: Number of the ply from the outer face, from 1.
        plies: Number of plies there.
        material: Name of its material.
        angle: Angle of its fibre from the span [deg].
        face: Face of the ply, "outer" or "inner".
        blade: Number of the blade, from 1.
        damages: By `MEASURES`.
        run: The run that does most damage.
        of_winds: Parts of the damage by wind speed [m/s].
    """

    damage: float
    index: float
    years: float
    measure: str
    range: float
    panel: str
    distance: float
    station: float
    ply: int
    plies: int
    material: str
    angle: float
    face: str
    blade: int
    damages: tuple[float, ...]
    run: str
    of_winds: dict[float, float]

    def __str__(self) -> str:
        """Lines for people."""
        return (
            f"fails first: ply {self.ply} of {self.plies} from outside, {self.material} at "
            f"{self.angle:.3g} deg, in {self.panel} of blade {self.blade}, {self.distance:.4g} m "
            f"from the root\ndamage {self.damage:.3g} by {WORDS[self.measure]}, life "
            f"{describe_years(self.years)}, fatigue index {self.index:.3g}; most of it in "
            f"{self.run}"
        )


WORDS = dict(
    zip(
        MEASURES,
        ("stress along the fibre", "stress across the fibre", "shear stress", "exertion"),
        strict=True,
    )
)
"""The measures in words."""


@dataclass(frozen=True, eq=False)
class SectionLife:
    """Damage around the section where a ply fails first, arrays with n rows.

    Args:
        distance: Of the section from the root [m].
        blade: Number of the blade, from 1.
        panels: Names of the panels of the cells.
        ends: Ends of the outer faces of the cells, (y, x) in the section, shape (n, 2, 2) [m].
        normal: Outwards, along (y, x), shape (n, 2).
        damage: Largest of the plies of each cell [-].
        index: Largest fatigue index [-].
    """

    distance: float
    blade: int
    panels: tuple[str, ...]
    ends: Array
    normal: Array
    damage: Array
    index: Array


class WorstPlaces:
    """Finds where plies fail first. Collective, also its methods."""

    def __init__(self, life: PlyLife) -> None:
        self._life, self._plies = life, life.recovery.plies
        self._comm = life.recovery.run.turbine.comm
        self._table = life.recovery.recovered.table

    @cached_property
    def _panel(self) -> IntArray:
        """Number of the panel of each cell of this rank; -1 of those without."""
        found = np.full(len(self._table.first), -1)
        for k, cells in enumerate(self._plies.panels.values()):
            found[cells] = k
        return found

    def find(self) -> list[WorstPlace]:
        """The worst place of each ply of each panel, the `MOST` worst ones, rising in life.

        Raises:
            InputError: if no stress changes.
        """
        table = self._table
        number = np.arange(len(table.wall)) - table.first[table.wall]
        panel = self._panel[table.wall]
        mine: dict[tuple[int, int], int] = {}
        for j in np.flatnonzero((panel >= 0) & (self._life.plies.range.any(axis=(0, 2, 3)))):
            key = int(panel[j]), int(number[j])
            if key not in mine or self._rank(j) < self._rank(mine[key]):
                mine[key] = int(j)
        found: dict[tuple[int, int], tuple[Any, WorstPlace]] = {}
        described = {key: (self._rank(j), self._describe(j)) for key, j in mine.items()}
        for of_rank in self._comm.allgather(described):
            for key, (rank, place) in of_rank.items():
                if key not in found or rank < found[key][0]:
                    found[key] = rank, place
        if not found:
            raise InputError("no stress of the plies that count changes in these runs")
        return [place for _, place in sorted(found.values(), key=lambda each: each[0])[:MOST]]

    def _rank(self, j: int) -> tuple[float, ...]:
        """Plies are sorted by this, the worst first; places decide between those that are alike."""
        cell = int(self._table.wall[j])
        place, x = float(self._plies.place[cell]), self._middles[cell]
        damage = float(self._life.of_plies[:, j].max())
        return (-damage, place, *(float(y) for y in np.round(x, 9)))

    @cached_property
    def _middles(self) -> Array:
        """Middles of the outer faces of the cells of this rank, shape (cells, 3) [m]."""
        return self._find_points()[:, 2]

    def _find_points(self) -> Array:
        """The points `AROUND` of the cells of this rank, shape (cells, 4, 3) [m]."""
        mesh = self._plies.stresses.body.mesh
        nodes = _compat.nodes_of_cells(mesh)[: len(self._table.first)]
        degree = round(nodes.shape[1] ** (1.0 / 3.0)) - 1
        values = _compat.shape_functions("hexahedron", degree, AROUND)[0]
        return np.asarray(np.einsum("pa,cai->cpi", values, mesh.geometry.x[nodes]))

    def _describe(self, j: int) -> WorstPlace:
        """The place of a ply of this rank."""
        life, table = self._life, self._table
        own = life.plies.damage[:, j]
        copy, face, k = np.unravel_index(int(np.argmax(own)), own.shape)
        at = copy, j, face, k
        cell, ply = int(table.wall[j]), table.plies[j]
        damage, distance = float(life.plies.damage[at]), float(self._plies.place[cell])
        return WorstPlace(
            damage=damage,
            index=float(life.indices[copy, j]),
            years=life.years / damage if damage > 0.0 else np.inf,
            measure=MEASURES[k],
            range=float(life.plies.range[at]),
            panel=list(self._plies.panels)[self._panel[cell]],
            distance=distance,
            station=distance / life.recovery.run.turbine.rotor.blades.length,
            ply=j - int(table.first[cell]) + 1,
            plies=int(np.sum(table.wall == cell)),
            material=ply.material.name,
            angle=float(np.degrees(ply.angle)) + 0.0,
            face=FACES[face],
            blade=int(copy) + 1,
            damages=tuple(life.plies.damage[copy, j, face].tolist()),
            run=life.runs[life.plies.worst[at]].name,
            of_winds={wind: float(part[at]) for wind, part in sorted(life.plies.of_winds.items())},
        )

    def find_section(self, place: WorstPlace) -> SectionLife:
        """The section of a place, in its blade."""
        table, n = self._table, len(self._table.first)
        length = self._life.recovery.run.turbine.rotor.blades.length
        points, copy = self._find_points(), place.blade - 1
        of_cells = [
            np.maximum.reduceat(values[copy], table.first) if n else np.zeros(0)
            for values in (self._life.of_plies, self._life.indices)
        ]
        in_row = np.abs(self._plies.place - place.distance) < SAME_ROW * length
        rows = np.flatnonzero(in_row & (self._panel >= 0))
        mine = rows, points[rows], self._panel[rows], *(x[rows] for x in of_cells), points[:, 2]
        gathered = zip(*self._comm.allgather(mine), strict=True)
        _, x, panel, damage, index, every = map(np.concatenate, gathered)
        panels = np.array(list(self._plies.panels))[panel]
        flat = x @ _find_section_axes(every, x, panels).T
        normal = flat[:, 2] - flat[:, 3]
        order = np.lexsort((*np.round(x[:, 2].T, 9), panel))
        return SectionLife(
            distance=place.distance,
            blade=place.blade,
            panels=tuple(panels[order].tolist()),
            ends=flat[order, :2] - flat[:, 2].mean(axis=0),
            normal=(normal / np.linalg.norm(normal, axis=1, keepdims=True))[order],
            damage=damage[order],
            index=index[order],
        )


def _find_section_axes(every: Array, section: Array, panels: npt.NDArray[np.str_]) -> Array:
    """Axes y along the chord and x across it as rows, shape (2, 3).

    They point to the trailing edge and to the suction side.

    Args:
        every: Points of all cells, whose long axis is that of the blade, shape (n, 3) [m].
        section: Points of the cells of a section, shape (m, 4, 3) [m].
        panels: Names of their panels.
    """
    along = np.linalg.svd(every - every.mean(axis=0), full_matrices=False)[2][0]
    points = section[:, 2] - section[:, 2].mean(axis=0)
    points = points - np.outer(points @ along, along)
    chord = np.linalg.svd(points, full_matrices=False)[2][0]
    axes = np.array([chord, np.cross(along, chord)])
    for axis, (front, back) in zip(axes, SIDES, strict=True):
        ahead, behind = (points[[word in panel for panel in panels]] for word in (front, back))
        if len(ahead) and len(behind) and (ahead.mean(axis=0) - behind.mean(axis=0)) @ axis < 0.0:
            axis *= -1.0
    return axes

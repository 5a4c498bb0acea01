"""Meaning of the cells of hollow blades, from the data of their mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.laminate_theory import Plies
from turbine_fenicsx.meshing.hollow_ends import TIP
from turbine_fenicsx.windio import WindIOBlade
from turbine_fenicsx.windio.blade import FACE_NAME

NAMES = ("part", "span_start", "span_end", "arc_start", "arc_end", "wanted", "thickness")
"""Data of cells that are needed, see `turbine_fenicsx.meshing.hollow.HollowBlock`."""

TRAILING_BOND = "trailing_edge"
"""How the names of the bonds of a trailing edge begin."""

SIDES = ("suction_side", "pressure_side")
"""Sides of a bond, by rising contour fraction."""

AT_END = 1e-9
"""Difference of contour fractions that are one."""

SLENDER = 3.0
"""Minimum ratio of width to thickness of half of a trailing edge's face that is a wall."""


@dataclass(frozen=True, eq=False)
class WallCells:
    """Cells of hollow blades.

    Args:
        part: Index in ``parts`` of each cell, shape (n,).
        span: First and last span fraction of each cell, shape (n, 2) [-].
        arc: First and last contour fraction, shape (n, 2) [-].
        wanted: Thickness of the wall that each cell stands for, shape (n,) [m].
        thickness: Thickness that the cell has, shape (n,) [m].
    """

    shape: WindIOBlade
    part: IntArray
    span: Array
    arc: Array
    wanted: Array
    thickness: Array

    @classmethod
    def read(cls, shape: WindIOBlade, data: Mapping[str, Array]) -> WallCells:
        """The cells of a mesh.

        Args:
            data: Numbers of the cells by name.
        """
        missing = [name for name in NAMES if name not in data]
        if missing:
            raise ModelError(
                f"it lacks the cell data {', '.join(missing)}: blades with a layup need a mesh "
                "that `turbine-fenicsx mesh` has written for them"
            )
        part, s0, s1, a0, a1, wanted, thickness = (np.asarray(data[name]) for name in NAMES)
        n = len(_list_parts(shape))
        rules = {
            "part": (part == np.round(part)) & (part >= 0) & (part < n),
            "span_start": s0 >= 0.0,
            "span_end": (s1 > s0) & (s1 <= 1.0),
            "arc_start": a0 >= 0.0,
            "arc_end": (a1 >= a0) & (a1 <= 1.0),
            "wanted": (wanted > 0.0) & (wanted < np.inf),
            "thickness": (thickness > 0.0) & (thickness < np.inf),
        }
        for name, good in rules.items():
            if not good.all():
                worst = float(np.asarray(data[name])[~good][0])
                raise ModelError(
                    f"the cell data {name!r} have {worst:g}, which no cell of the blades of "
                    "turbine.file can have: rewrite the mesh with `turbine-fenicsx mesh`"
                )
        span, arc = np.stack([s0, s1], axis=1), np.stack([a0, a1], axis=1)
        return cls(shape, part.astype(np.int64), span, arc, wanted, thickness)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of panels, webs, and the plate of a closed tip."""
        return _list_parts(self.shape)

    @property
    def panels(self) -> tuple[str, ...]:
        """Their names in output, where panels may share one."""
        return tuple(name.replace(", ", "_").replace(" ", "_") for name in self.parts)

    @property
    def is_tip(self) -> Array:
        """Which cells are the plate at the tip, shape (n,)."""
        return np.asarray(self.part == len(self.parts) - 1)

    @cached_property
    def is_ridge(self) -> Array:
        """Which cells are of a trailing edge's face that is hardly wider than thick, shape (n,).

        They close the section as a hinge between suction and pressure side: what bends them across
        the span the adhesive would carry, which no file describes.
        """
        found = np.array([name == FACE_NAME for name in self.parts])[self.part]
        if not found.any():  # as on some ranks
            return found
        s, middle = self.span[found].mean(axis=1), self.arc[found].mean(axis=1)
        lines = self.shape.lines(s)
        halves = np.where(middle[:, None] < 0.5, lines[:, :2], lines[:, -2:])
        ends = [self.shape.surface(s, a) for a in halves.T]
        width = np.linalg.norm(ends[1] - ends[0], axis=1)
        found[found] = width < SLENDER * self.wanted[found]
        return found

    def find_bonds(self, comm: MPI.Intracomm) -> dict[str, IntArray]:
        """Cells of this rank at bonds: feet of webs, and trailing edges of the shell. Collective.

        Returns:
            Numbers of cells by the name of the bond and its side, all names on all ranks.
        """
        found: dict[str, IntArray] = {}
        first, last = self.arc.T
        for web in self.shape.webs:
            own = self.part == self.parts.index(web.name)
            ends = first < AT_END, last > 1.0 - AT_END
            for side, at_end in zip(SIDES, ends, strict=True):
                found[f"{web.name}_{side}"] = np.flatnonzero(own & at_end)
        skin = self.part < len(self.shape.panels)
        skin &= np.array([name != FACE_NAME for name in self.parts])[self.part]
        rows = np.round(self.span[:, 0], 9)
        for side, arcs in zip(SIDES, (first, -last), strict=True):
            least: dict[float, float] = {}
            mine = {row: float(arcs[skin & (rows == row)].min()) for row in np.unique(rows[skin])}
            for of_rank in comm.allgather(mine):
                for row, arc in of_rank.items():
                    least[row] = min(arc, least.get(row, np.inf))
            at_end = arcs < np.array([least.get(row, np.inf) for row in rows]) + AT_END
            found[f"{TRAILING_BOND}_{side}"] = np.flatnonzero(skin & at_end)
        return found

    def find_plies(self) -> list[Plies]:
        """Plies of each cell."""
        known: dict[_Place, Plies] = {}
        found = []
        rows = zip(self.part.tolist(), self.span.tolist(), self.arc.tolist(), strict=True)
        for part, (s0, s1), (a0, a1) in rows:
            place = _Place(part, s0, s1, a0, a1)
            if place not in known:  # three blades are alike
                known[place] = self.shape.layup(self.parts[part], (s0, s1), (a0, a1))
            found.append(known[place])
        return found


class _Place(NamedTuple):
    """Where a cell is: part, ranges of span and contour."""

    part: int
    s0: float
    s1: float
    a0: float
    a1: float


def _list_parts(shape: WindIOBlade) -> tuple[str, ...]:
    """Names of all parts that a mesh of the blade may have."""
    return (*shape.panels, *(web.name for web in shape.webs), TIP)

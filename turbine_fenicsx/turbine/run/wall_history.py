"""Strain and stress of the plies at one place of the blades over a recorded run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.text_files import suggest
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.laminate_theory import Plies
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.records import names
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery

SAME_ROW = 1e-6
"""Difference of places of cells in one row around a blade, relative to its length."""

BLOCK = 512
"""Number of states that are evaluated together."""

COMPONENTS = ("11", "22", "12")


@dataclass(frozen=True)
class WallPlace:
    """A place of the walls of a blade.

    Args:
        station: Fraction of the span [-].
        panel: Name of the panel or web.
        ply: Number of the ply from the outer face, from 1; None for all.
    """

    station: float
    panel: str
    ply: int | None = None

    @classmethod
    def parse(cls, text: str) -> WallPlace:
        """A place as users write it: ``0.35,spar_cap_suction_side`` or with ``,3``, the ply.

        Raises:
            InputError: for another text.
        """
        parts = [part.strip() for part in text.split(",")]
        try:
            station, panel, ply = float(parts[0]), parts[1], [int(part) for part in parts[2:]]
        except (ValueError, IndexError):
            station, panel, ply = np.nan, "", [0]
        if not (0.0 <= station <= 1.0 and panel and len(ply) < 2 and min(ply, default=1) >= 1):
            raise InputError(
                f"place {text!r}: expected STATION,PANEL or STATION,PANEL,PLY, such as "
                "0.35,spar_cap_suction_side,1, with a fraction of the span"
            )
        return cls(station, panel, *ply)

    @property
    def label(self) -> str:
        """The place as a part of a file's name."""
        ply = "" if self.ply is None else f"_ply_{self.ply}"
        return f"{self.station:g}_{self.panel}{ply}"


@dataclass(frozen=True, eq=False)
class WallHistory:
    """Strains and stresses of the plies of one cell, in all blades.

    Args:
        place: The place.
        distance: Of the middle of the cell from the root [m].
        plies: The plies of its wall, from the outer face.
        columns: Time and the numbers of each blade and ply that is wanted, by their names.
    """

    place: WallPlace
    distance: float
    plies: Plies
    columns: dict[str, Array]

    def __str__(self) -> str:
        """Lines for people."""
        found = [
            f"  ply {k}: {ply.material.name} at {np.degrees(ply.angle):.3g} deg, "
            f"{1e3 * ply.thickness:.3g} mm"
            for k, ply in enumerate(self.plies, start=1)
        ]
        head = f"{self.place.panel}, the cell {self.distance:.4g} m from the root, from outside:"
        return "\n".join([head, *found])


def find_wall_history(
    recovery: PlyRecovery, place: WallPlace, criterion: str = "tsai_wu"
) -> WallHistory:
    """The history of a place: its cell is the one in the middle of the panel. Collective.

    Strains and stresses are those in the axes of the ply in its middle, means over the cell; the
    failure index is the largest of its points.

    Args:
        recovery: The plies of the run.
        place: The place.
        criterion: One of `turbine_fenicsx.materials.ply_failure.CRITERIA`.

    Raises:
        InputError: for a panel or a ply that the blades do not have there.
    """
    comm, panels = recovery.run.turbine.comm, recovery.plies.panels
    if place.panel not in panels:
        raise InputError(
            f"there is no panel {place.panel!r}, but {', '.join(panels)}"
            f"{suggest(place.panel, panels)}"
        )
    owner, cell = _find_cell(recovery, place)
    found: WallHistory | None = None
    error: Exception | None = None
    if comm.rank == owner:
        try:
            found = _evaluate(recovery, place, cell, criterion)
        except InputError as problem:
            error = problem
    raise_together(comm, error)
    history: WallHistory = comm.bcast(found, root=owner)
    return history


def _find_cell(recovery: PlyRecovery, place: WallPlace) -> tuple[int, int]:
    """Rank and number of the cell in the middle of a panel at a station. Collective."""
    plies, comm = recovery.plies, recovery.run.turbine.comm
    length = recovery.run.turbine.rotor.blades.length
    cells, mesh = plies.panels[place.panel], plies.stresses.body.mesh
    x = mesh.geometry.x[_compat.nodes_of_cells(mesh)[cells]].mean(axis=1)
    mine = plies.place[cells], x, np.full(len(cells), comm.rank), cells
    places, x, ranks, numbers = map(np.concatenate, zip(*comm.allgather(mine), strict=True))
    off = np.abs(places - place.station * length)
    row = np.flatnonzero(off <= off.min() + SAME_ROW * length)
    from_middle = np.linalg.norm(x[row] - x[row].mean(axis=0), axis=1)
    # cells that are as near come in an order that does not depend on the ranks
    best = row[np.lexsort((*x[row].T, np.round(from_middle / length, 6)))[0]]
    return int(ranks[best]), int(numbers[best])


def _evaluate(recovery: PlyRecovery, place: WallPlace, cell: int, criterion: str) -> WallHistory:
    """The history of a cell that this rank owns."""
    wall = recovery.recovered.take(np.array([cell]))
    plies, vectors = wall.table.plies, recovery.vectors
    if place.ply is not None and place.ply > len(plies):
        raise InputError(
            f"there is no ply {place.ply} in {place.panel} at {place.station:g} of the span, which "
            f"has {len(plies)}"
        )
    wanted = range(len(plies)) if place.ply is None else [place.ply - 1]
    columns = {names.TIME: recovery.run.motion.times}
    for copy in range(vectors.shape[1]):
        blocks = []
        for first in range(0, len(vectors), BLOCK):
            E = wall.strains(vectors[first : first + BLOCK, copy], copy)[0]
            m = E.shape[2]
            inner, outer = E.reshape(1, 2, -1, 3).swapaxes(0, 1)
            strains = wall.table.strains(inner, outer)  # plies, faces, points and states
            stresses = wall.table.stresses(strains)
            index = CRITERIA[criterion](wall.table, strains).reshape(len(plies), -1, m).max(axis=1)
            means = [x.reshape(len(plies), -1, m, 3).mean(axis=1) for x in (strains, stresses)]
            blocks.append(np.concatenate([*means, index[..., None]], axis=2))
        values = np.concatenate(blocks, axis=1)
        for k in wanted:
            of = {"blade": copy + 1, "ply": k + 1}
            families = [
                *((names.PLY_STRAIN, {"component": c}) for c in COMPONENTS),
                *((names.PLY_STRESS, {"component": c}) for c in COMPONENTS),
                (names.PLY_FAILURE, {"criterion": criterion}),
            ]
            for column, (family, more) in enumerate(families):
                columns[family(**of, **more)] = values[k, :, column]
    return WallHistory(place, float(recovery.plies.place[cell]), plies, columns)

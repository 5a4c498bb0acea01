"""Files with the life of plies: tables and fields."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx import _compat
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.files import name_file_in_errors, replace_file
from turbine_fenicsx.foundation.parallel import on_rank0, raise_together
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.ply_fatigue import MEASURES
from turbine_fenicsx.records import names
from turbine_fenicsx.records.life_tables import ALL, BONDS, PLACES, SECTION, WINDS
from turbine_fenicsx.records.mode_tables import Row, format_rows
from turbine_fenicsx.simulation.observers.cell_values import CellValues
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.life.ply_life import PlyLife
from turbine_fenicsx.turbine.life.worst_bonds import WorstBond
from turbine_fenicsx.turbine.life.worst_places import SectionLife, WorstPlace
from turbine_fenicsx.turbine.run.full_motion import FullMotion
from turbine_fenicsx.turbine.run.turbine_fields import make_fields

INDEX = "fatigue_index"
"""Field that the picture of the blade shows."""

SAME_CELL = 1e-6
"""Distance of middles of cells that are one, relative to the size of the blades."""


def write_life_tables(
    life: PlyLife,
    places: Sequence[WorstPlace],
    section: SectionLife,
    bonds: Sequence[WorstBond],
    folder: Path,
) -> list[str]:
    """Write the places, the section of the first, its damage by wind, and the bonds.

    Files of an earlier life in the folder are removed. Collective.

    Returns:
        Names of the files.
    """
    texts = {
        PLACES: format_rows([_list_place(place) for place in places]),
        SECTION: format_rows(_list_section(section)),
        WINDS: format_rows(_list_winds(places[0])),
    }

    if bonds:
        texts[BONDS] = format_rows([_list_bond(bond) for bond in bonds])

    def write() -> None:
        for name in ALL:  # what is not written again would be of another life
            with name_file_in_errors("write", folder / name):
                (folder / name).unlink(missing_ok=True)
        for name, text in texts.items():
            replace_file(folder / name, text.encode())

    on_rank0(life.recovery.run.turbine.comm, write)
    return list(texts)


def _list_place(place: WorstPlace) -> Row:
    """The row of a place."""
    return {
        "station": place.station,
        names.DISTANCE: place.distance,
        "panel": place.panel,
        "ply": place.ply,
        "plies": place.plies,
        "material": place.material,
        names.PLY_ANGLE: place.angle,
        "face": place.face,
        "blade": place.blade,
        "measure": place.measure,
        "largest_range": place.range,
        names.DAMAGE: place.damage,
        names.LIFE: place.years,
        names.FATIGUE_INDEX: place.index,
        "run": place.run,
        **{
            names.DAMAGE_BY(measure=measure): damage
            for measure, damage in zip(MEASURES, place.damages, strict=True)
        },
    }


def _list_section(section: SectionLife) -> list[Row]:
    """A row for each cell of a section."""
    return [
        {
            names.DISTANCE: section.distance,
            "blade": section.blade,
            "panel": panel,
            **{
                names.SECTION_END(end=end, axis=axis): float(ends[i, k])
                for i, end in enumerate(("start", "end"))
                for k, axis in enumerate("yx")
            },
            **{names.SECTION_NORMAL(axis=a): float(x) for a, x in zip("yx", normal, strict=True)},
            names.DAMAGE: float(damage),
            names.FATIGUE_INDEX: float(index),
        }
        for panel, ends, normal, damage, index in zip(
            section.panels, section.ends, section.normal, section.damage, section.index, strict=True
        )
    ]


def _list_bond(bond: WorstBond) -> Row:
    """The row of a bond."""
    return {
        "bond": bond.bond,
        names.DISTANCE: bond.distance,
        "blade": bond.blade,
        "measure": bond.measure,
        names.BOND_RANGE(stress="peel"): bond.peel,
        names.BOND_RANGE(stress="shear"): bond.shear,
        names.DAMAGE: bond.damage,
        names.LIFE: bond.years,
        "run": bond.run,
    }


def _list_winds(place: WorstPlace) -> list[Row]:
    """Damage by wind speed."""
    return [{names.WIND_SPEED: wind, names.DAMAGE: x} for wind, x in place.of_winds.items()]


class LifeFields:
    """Fields of the life on the cells of all blades: the largest of the plies, and each ply.

    ``damage``, ``life`` in years, ``fatigue_index``, and ``damage_ply_1`` from the outer face.
    Cells without damage have none in ``life``: it is not-a-number there.

    Args:
        life: The life.

    Note:
        Collective, also its method.
    """

    def __init__(self, life: PlyLife) -> None:
        self._motion = FullMotion(life.recovery.run)
        turbine = self._motion.turbine
        bodies = turbine.system.flexible_bodies
        body = next(body for body in bodies if body.name == BODY).full
        cells = _find_cells(life, body)
        self._values = [
            CellValues(name, body, partial(_show, values[cells]))
            for name, values in _gather(life).items()
        ]

    def write(self, path: Path, wanted: Sequence[str] | None = None) -> None:
        """Write them.

        Args:
            path: The file, ``.vtkhdf`` or ``.xdmf``.
            wanted: Names of fields; None for all.
        """
        known = ["displacement", *(values.name for values in self._values)]
        fields = make_fields(
            self._motion.turbine, path, np.inf, np.inf, self._values, wanted or known
        )
        series = fields.open(path, None, 1)
        fields.write(series, self._motion.find_state(0))
        series.finish()


def _show(values: Array, state: State) -> Array:
    """Values that no state changes."""
    return values


def _gather(life: PlyLife) -> dict[str, Array]:
    """Values of the cells of all blades and ranks, one copy after another, by name."""
    recovered, comm = life.recovery.recovered, life.recovery.run.turbine.comm
    first, table = recovered.table.first, recovered.table
    number = np.arange(len(table.wall)) - first[table.wall]
    most = max(comm.allgather(int(number.max(initial=0)) + 1))
    of_plies = np.zeros((len(life.of_plies), most, len(first)))
    of_plies[:, number, table.wall] = life.of_plies
    index = np.zeros((len(life.of_plies), len(first)))
    if len(first):
        index = np.maximum.reduceat(life.indices, first, axis=1)
    mine = np.concatenate([of_plies, index[:, None]], axis=1)
    every = np.concatenate(comm.allgather(mine), axis=2).swapaxes(0, 1).reshape(most + 1, -1)
    damage = every[:-1].max(axis=0)
    years = np.full_like(damage, np.nan)
    np.divide(life.years, damage, out=years, where=damage > 0.0)
    plies = {f"damage_ply_{k + 1}": values for k, values in enumerate(every[:-1])}
    return {"damage": damage, "life": years, INDEX: every[-1], **plies}


def _find_cells(life: PlyLife, body: Any) -> IntArray:
    """Numbers in `_gather` of the cells of the full blades that this rank owns. Collective."""
    run = life.recovery.run
    comm, reduced = run.turbine.comm, run.reduced[BODY].body
    n = len(life.recovery.recovered.table.first)
    own = _find_middles(reduced.full.mesh, n)
    placed = [p.place(own, np.ones(n)) for p in reduced.placements]
    every = np.concatenate([np.concatenate(x) for x in zip(*comm.allgather(placed), strict=True)])
    mesh = body.mesh
    middles = _find_middles(mesh, mesh.topology.index_map(3).size_local)
    distance, found = cKDTree(every).query(middles)
    size, error = float(np.max(np.ptp(every, axis=0))), None
    if np.max(distance, initial=0.0) > SAME_CELL * size:
        error = ModelError("the full blades have other cells than those whose life was found")
    raise_together(comm, error)
    return np.asarray(found, dtype=np.int64)


def _find_middles(mesh: Any, n: int) -> Array:
    """Means of the nodes of the first n cells, shape (n, 3) [m]."""
    nodes = _compat.nodes_of_cells(mesh)[:n]
    return np.asarray(mesh.geometry.x[nodes].mean(axis=1))

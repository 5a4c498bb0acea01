"""The moment of a recorded run in which a ply came nearest to failure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import add_openfast, read_history
from turbine_fenicsx.turbine.run.ply_history import PlyHistory, PlyRecovery

CHANNELS = (
    "RtVAvgxh_[m/s]",
    "RotSpeed_[rpm]",
    "Azimuth_[deg]",
    *(f"BldPitch{blade}_[deg]" for blade in (1, 2, 3)),
    "RtAeroPwr_[W]",
)
"""Columns of ``history.out`` that say what the turbine did."""

MODES = ("along the fibre", "across the fibre", "in shear")


@dataclass(frozen=True)
class WorstMoment:
    """Where, when and how a ply came nearest to failure.

    Args:
        criterion: One of `turbine_fenicsx.materials.ply_failure.CRITERIA`.
        index: The failure index; a ply fails at 1 [-].
        time: When [s].
        blade: Number of the blade, from 1.
        panel: Name of the panel or web.
        place: Distance from the root [m].
        ply: Number of the ply from the outer face, from 1.
        plies: Number of plies there.
        material: Name of its material.
        angle: Angle of its fibre from the span [deg].
        stresses: Along the fibre, across it, and of shear, where the index is largest [Pa].
        strengths: Those for the signs of these stresses; infinite where nothing is known [Pa].
        channels: What the turbine did then, by columns of ``history.out`` and their units.
    """

    criterion: str
    index: float
    time: float
    blade: int
    panel: str
    place: float
    ply: int
    plies: int
    material: str
    angle: float
    stresses: tuple[float, ...]
    strengths: tuple[float, ...]
    channels: Mapping[str, float]

    @property
    def mode(self) -> str:
        """The stress that is nearest to its strength, in words."""
        shares = [abs(s) / r for s, r in zip(self.stresses, self.strengths, strict=True)]
        return MODES[int(np.argmax(shares))]

    def __str__(self) -> str:
        """Lines for people."""
        of = zip(self.stresses, self.strengths, MODES, strict=True)
        parts = [
            f"{1e-6 * s:.3g} MPa {mode}" + (f" of {1e-6 * r:.3g}" if isfinite(r) else "")
            for s, r, mode in of
        ]
        lines = [
            f"nearest to failure: {self.criterion} {self.index:.3g} in {self.panel} of blade "
            f"{self.blade}, {self.place:.4g} m from the root, at t = {self.time:.4g} s",
            f"ply {self.ply} of {self.plies} from outside, {self.material} at {self.angle:.3g} "
            f"deg, most {self.mode}: {', '.join(parts)}",
        ]
        split = [(*names.split_unit(name), value) for name, value in self.channels.items()]
        values = [f"{name} {value:.4g} {unit}" for name, unit, value in split]
        return "\n".join([*lines, *(["then: " + ", ".join(values)] if values else [])])


def find_worst_moment(recovery: PlyRecovery, history: PlyHistory) -> WorstMoment:
    """The moment in which a ply came nearest to failure. Collective."""
    row, panel = np.unravel_index(int(np.argmax(history.index)), history.index.shape)
    comm, copy = recovery.run.turbine.comm, int(history.blade[row, panel]) - 1
    vectors, recovered = recovery.vectors[row : row + 1, copy], recovery.recovered
    cells = recovery.plies.panels[history.panels[panel]]
    index, number = recovered.find_largest(CRITERIA[history.criterion], vectors, copy)
    largest, found = float(np.max(index[cells], initial=-1.0)), None
    if comm.allreduce((largest, comm.rank), op=MPI.MAXLOC)[1] == comm.rank:
        cell = int(cells[np.argmax(index[cells, 0])])
        table = recovered.table
        k = int(table.first[cell] + number[cell, 0])
        strains = recovered.strains(vectors, copy)[:, :, :, 0]
        of_plies = table.strains(strains[:, 0], strains[:, 1])
        stresses = table.stresses(of_plies)[k].reshape(-1, 3)
        worst = int(np.argmax(CRITERIA[history.criterion](table, of_plies)[k]))
        count = int(np.sum(table.wall == cell))
        found = stresses[worst], table.plies[k], count
    stress, ply, count = next(x for x in comm.allgather(found) if x is not None)
    limits = ply.material.strengths
    signs = zip(stress[:2], limits.tension, limits.compression, strict=False)
    strengths = [tension if s >= 0.0 else compression for s, tension, compression in signs]
    time = float(history.times[row])
    return WorstMoment(
        criterion=history.criterion,
        index=float(history.index[row, panel]),
        time=time,
        blade=copy + 1,
        panel=history.panels[panel],
        place=float(history.place[row, panel]),
        ply=int(history.ply[row, panel]),
        plies=count,
        material=ply.material.name,
        angle=float(np.degrees(ply.angle)),
        stresses=tuple(map(float, stress)),
        strengths=(*strengths, limits.shear[0]),
        channels=on_rank0(comm, lambda: _read_channels(recovery.run.folder, time)),
    )


def _read_channels(folder: Path, time: float) -> dict[str, float]:
    """Columns of ``history.out`` at a time, those that are there."""
    path = folder / "history.out"
    if not path.exists():
        return {}
    series = add_openfast(read_history(folder / "history.csv"), path, CHANNELS)
    k = int(np.argmin(np.abs(series[names.TIME] - time)))
    return {name: float(series[name][k]) for name in CHANNELS if name in series.columns}

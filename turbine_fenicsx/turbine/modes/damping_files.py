"""The damping of a mode as files: ``damping.csv``, ``decay.csv``, ``work.csv``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import degrees, pi
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.decay_fit import Decay
from turbine_fenicsx.analysis.mode_work import ModeWork
from turbine_fenicsx.foundation.files import replace_file
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.records.damping_tables import DAMPING, DECAY, WORK
from turbine_fenicsx.records.mode_tables import Row, format_rows
from turbine_fenicsx.records.output_folder import make_target_folder, remove_results
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.modes.mode_files import RPM, Place
from turbine_fenicsx.turbine.run.resume import write_case


@dataclass(frozen=True, eq=False)
class Damping:
    """The damping of a mode in the wind.

    Args:
        name: Of the mode.
        place: The wind, and how the turbine runs.
        eigenvalue: s of the linear equations [rad/s].
        decay: In runs.
        work: Who takes part in the decay of the linear equations.
        radius: Of the stations of a blade along its span, shape (n,) [m].
        lengths: What each of them stands for, shape (n,) [m].
    """

    name: str
    place: Place
    eigenvalue: complex
    decay: Decay
    work: ModeWork
    radius: Array
    lengths: Array

    @property
    def along(self) -> Array:
        """Radius [m] and part of the air in the decay [1/(m s)], of all blades, shape (n, 2)."""
        of_blades = np.concatenate(self.work.sections).reshape(len(BLADES), -1).sum(axis=0)
        return np.column_stack([self.radius, of_blades / self.lengths])


def write_damping(case: Case, folder: Path, damping: Damping, comm: MPI.Intracomm) -> list[str]:
    """Write the tables and the case; names of the tables. Collective."""
    on_rank0(comm, partial(make_target_folder, folder))
    on_rank0(comm, partial(remove_results, folder))
    write_case(case, folder, comm)
    place, decay, work = damping.place, damping.decay, damping.work
    row: Row = {
        names.MODE_NAME: damping.name,
        names.WIND_SPEED: place.wind or 0.0,
        names.SPEED: place.speed * RPM,
        names.PITCH: degrees(place.pitch),
        names.FREQUENCY: damping.eigenvalue.imag / (2.0 * pi),
        names.RUN_FREQUENCY: decay.eigenvalue.imag / (2.0 * pi),
        names.DECAY_RATE(source="eigenvalue"): -damping.eigenvalue.real,
        names.DECAY_RATE(source="run"): -decay.eigenvalue.real,
        names.DECAY_RATE(source="run_with_steps"): -decay.with_steps.real,
        names.DECAY_RATE(source="air"): work.air,
        names.DECAY_RATE(source="structure"): work.structure,
        names.DECAY_RATE(source="drive"): work.drive,
    }
    motion = [
        {
            names.TIME: time,
            names.MEASURED(part="real"): q.real,
            names.MEASURED(part="imaginary"): q.imag,
            names.FITTED(part="real"): fit.real,
            names.FITTED(part="imaginary"): fit.imag,
        }
        for time, q, fit in zip(
            decay.times.tolist(), decay.measured.tolist(), decay.fitted.tolist(), strict=True
        )
    ]
    along = [{names.RADIUS: r, names.AIR_ALONG: x} for r, x in damping.along.tolist()]
    for name, rows in ((DAMPING, [row]), (DECAY, motion), (WORK, along)):
        text = format_rows(rows).encode()
        on_rank0(comm, partial(replace_file, folder / name, text))
    return [DAMPING, DECAY, WORK]

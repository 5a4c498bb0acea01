"""Time series: one row of numbers per accepted step, in a CSV file that grows as the run does."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

from turbine_fenicsx.forces import Gravity
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.simulation.observers.row_file import RowFile, read_rows, rows_until
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True)
class Channel:
    """Some columns of the time series.

    Args:
        columns: Names with units, for example ``("angle_yaw_[rad]",)``.
        values: Function of the snapshot that returns one number per column; called on all ranks.

    Raises:
        TypeError: for columns that are no names, or values that are no function.
    """

    columns: tuple[str, ...]
    values: Callable[[Snapshot], Sequence[float]]

    def __post_init__(self) -> None:
        """Check the data."""
        if isinstance(self.columns, str) or not all(isinstance(c, str) for c in self.columns):
            raise TypeError(f"columns of a channel must be a tuple of names, got {self.columns!r}")
        if not callable(self.values):
            raise TypeError(
                f"values of the channel {self.columns} must be a function of the snapshot, got "
                f"{self.values!r}"
            )

    def row(self, snapshot: Snapshot) -> Sequence[float]:
        """The numbers of a snapshot; a ValueError if they are not one per column."""
        row = self.values(snapshot)
        if len(row) != len(self.columns):
            raise ValueError(f"channel {self.columns} gave {len(row)} numbers")
        return row


class History:
    """Writes ``history.csv``, flushed after every row so that other programs can follow it.

    Args:
        comm: Communicator; rank 0 writes.
        path: The file.
        channels: The columns from left to right.
        keep_until: Keep the rows of an existing file up to this time [s] and append to them; None
            begins a new file. A file with other columns is kept under the name
            ``history.csv.damaged``.

    Attributes:
        name: Name of the file, under which checkpoints know it.

    Raises:
        FileError: if the file cannot be written, on all ranks.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: str | os.PathLike[str],
        channels: Sequence[Channel],
        keep_until: float | None = None,
    ) -> None:
        """Open the file and write the head."""
        self._channels, self.name = tuple(channels), Path(path).name
        self._columns = [name for channel in self._channels for name in channel.columns]

        def first() -> list[str]:
            head = ",".join(self._columns)
            if keep_until is None:
                return [head]
            if Path(path).exists() and not _has_head(path, head):
                os.replace(path, f"{os.fspath(path)}.damaged")
            return [head, *rows_until(read_history_rows(path, self._columns), keep_until, ",")]

        self._file = RowFile(comm, path, first)

    def observe(self, snapshot: Snapshot) -> None:
        """Append a row, but for a state that was observed before."""
        row = [x for channel in self._channels for x in channel.row(snapshot)]
        if not snapshot.resumed:
            self._file.write(",".join(_text(x) for x in row))

    def save(self) -> dict[str, Any]:
        """Bring the rows to the disk; their number and the columns. Collective."""
        return {"rows": self._file.sync() - 1, "columns": self._columns}

    def finish(self) -> None:
        """Close the file."""
        self._file.close()


def read_history_rows(path: str | os.PathLike[str], columns: Sequence[str]) -> list[str]:
    """The whole rows of a ``history.csv``; none if there is no such file or its columns differ.

    Raises:
        FileError: if it is there but cannot be read.
    """
    rows = read_rows(path, 1, len(columns), ",")
    return rows if rows and _has_head(path, ",".join(columns)) else []


def _has_head(path: str | os.PathLike[str], head: str) -> bool:
    """Whether a file begins with a line."""
    with Path(path).open("rb") as file:
        return file.readline() == f"{head}\n".encode()


def _text(x: float) -> str:
    """A number without loss: whole numbers plain, others so that they read back exactly."""
    return str(x) if isinstance(x, int) else repr(float(x))


def energy_channel() -> Channel:
    """Time, energies, work, energy error, linear and angular momentum."""

    def values(s: Snapshot) -> list[float]:
        b = s.balance
        return [
            s.state.time,
            b.kinetic,
            b.strain,
            b.potential,
            b.total,
            s.external_work,
            s.energy_error,
            *b.linear,
            *b.angular,
        ]

    return Channel(
        (
            names.TIME,
            names.KINETIC_ENERGY,
            names.STRAIN_ENERGY,
            names.POTENTIAL_ENERGY,
            names.TOTAL_ENERGY,
            names.EXTERNAL_WORK,
            names.ENERGY_ERROR,
            *(names.LINEAR_MOMENTUM(axis=i) for i in (1, 2, 3)),
            *(names.ANGULAR_MOMENTUM(axis=i) for i in (1, 2, 3)),
        ),
        values,
    )


def angle_channel(system: MultibodySystem) -> Channel:
    """All joint coordinates: angles, and displacements under names of their own."""
    kinds = zip(system.angle_names, system.rigid_block.is_angle, strict=True)
    columns = tuple((names.ANGLE if a else names.DISPLACEMENT)(joint=n) for n, a in kinds)
    return Channel(columns, lambda s: list(s.state.angles))


def work_channel(system: MultibodySystem) -> Channel:
    """Energy of springs, work of each load, drive and damper, and viscous dissipation so far.

    What does not occur in the system has no column. Total energy is initial energy plus all works
    minus everything dissipated.
    """
    springs = any(e.kind == "conservative" for e in system.elements)
    gravity = [isinstance(load, Gravity) for load in system.loads]
    places = [k for k in range(len(system.work_names)) if not (k < len(gravity) and gravity[k])]
    works = [system.work_names[k] for k in places]
    columns = (
        *((names.SPRING_ENERGY,) if springs else ()),
        *(names.WORK(name=name).replace(" ", "_") for name in works),
        *(names.DISSIPATION(name=name).replace(" ", "_") for name in system.dissipation_names),
    )

    def values(s: Snapshot) -> list[float]:
        energy = [s.balance.spring] if springs else []
        return [*energy, *s.works[places], *s.dissipated]

    return Channel(columns, values)


def numerics_channel() -> Channel:
    """Constraint error, iterations and wall time."""

    def values(s: Snapshot) -> list[float]:
        newton, krylov = (
            (s.report.newton_iterations, s.report.krylov_iterations) if s.report else (0, 0)
        )
        return [s.constraint_error, newton, krylov, round(s.wall_time, 6)]

    columns = (names.CONSTRAINT_ERROR, names.NEWTON_ITERATIONS, names.KRYLOV_ITERATIONS)
    return Channel((*columns, names.WALL_TIME), values)

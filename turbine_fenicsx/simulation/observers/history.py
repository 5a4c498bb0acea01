"""Time series: one row of numbers per accepted step, in a CSV file that grows as the run does."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from mpi4py import MPI

from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular
from turbine_fenicsx.foundation.own_code import name_exits
from turbine_fenicsx.foundation.parallel import raise_together
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.records import names
from turbine_fenicsx.records.row_file import (
    RowFile,
    join_columns,
    read_rows,
    select_rows,
    split_columns,
)
from turbine_fenicsx.simulation.observer import describe_shortfall
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.time_stepping.stepper import Stepper

log = logging.getLogger(__name__)


class Restartable(Protocol):
    """State of a channel between rows."""

    def save(self) -> RestartData:
        """Its state."""

    def restore(self, data: RestartData) -> None:
        """Know it again."""


@dataclass(frozen=True)
class Channel:
    """Some columns of the time series.

    Args:
        columns: Names with units, for example ``("angle_yaw_[rad]",)``.
        values: Function of the snapshot that returns one number per column; called on all ranks.
        memory: What the values remember of earlier snapshots and a restart needs; None for nothing.

    Raises:
        ModelError: for a name that holds a new line or another control character.
        TypeError: if columns are not names, or values are not a function.
    """

    columns: tuple[str, ...]
    values: Callable[[Snapshot], Sequence[float]]
    memory: Restartable | None = None

    def __post_init__(self) -> None:
        if isinstance(self.columns, str) or not all(isinstance(c, str) for c in self.columns):
            raise TypeError(f"columns of a channel must be a tuple of names, got {self.columns!r}")
        for name in self.columns:
            if not name.isprintable():
                raise ModelError(
                    f"column {name!r} of a history must be printable text: change the name in it, "
                    "which has a new line or another control character"
                )
        if not callable(self.values):
            raise TypeError(
                f"values of the channel {self.columns} must be a function of the snapshot, got "
                f"{self.values!r}"
            )

    def row(self, snapshot: Snapshot) -> Sequence[float]:
        """The numbers of a snapshot; a ModelError if they are not one per column."""
        row = self.values(snapshot)
        if len(row) != len(self.columns):
            raise ModelError(f"channel {self.columns} gave {len(row)} numbers")
        return row


def evaluate_channels(
    comm: MPI.Intracomm, channels: Sequence[Channel], snapshot: Snapshot
) -> list[float]:
    """The numbers of all channels; an error of one on some rank is raised on all. Collective."""
    values, failure = list[float](), None
    for channel in channels:
        try:
            with name_exits(f"channel {', '.join(channel.columns)}"):
                values += channel.row(snapshot)
        except Exception as error:
            failure = failure or error
    raise_together(comm, failure)
    return values


def save_channels(channels: Sequence[Channel]) -> RestartData:
    """States of channels, by their first columns."""
    data = RestartData()
    for channel in channels:
        if channel.memory is not None:
            data.add(channel.columns[0], channel.memory.save())
    return data


def restore_channels(channels: Sequence[Channel], data: RestartData) -> None:
    """Let channels remember what was saved."""
    for channel in channels:
        if channel.memory is not None:
            channel.memory.restore(data.part(channel.columns[0]))


class History:
    """Writes ``history.csv``, flushed after every row so that other programs can follow it.

    Args:
        comm: Communicator; rank 0 writes.
        path: The file.
        channels: The columns from left to right.

    Attributes:
        name: Name of the file, under which checkpoints know it.

    Note: A resumed run keeps the rows of the file up to its first state, and its columns: channels
        that are new are left out. A file whose head was changed since is kept under another name,
        ``history.csv.damaged``. A file whose rows are all lost begins with a row of the state that
        the run resumes from.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: str | os.PathLike[str],
        channels: Sequence[Channel],
    ) -> None:
        self._comm, self._path, self.name = comm, Path(path), Path(path).name
        self._channels = tuple(channels)
        self._file: RowFile | None = None

    @property
    def _columns(self) -> list[str]:
        return [name for channel in self._channels for name in channel.columns]

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Open the file, with a head and the first row, or with the rows so far.

        Raises:
            FileError: if it cannot be written, on all ranks.
        """
        row = self._format_row(snapshot)
        head = join_columns(self._columns)

        def make_first_lines() -> list[str]:
            if not resumed:
                return [head, row]
            if self._path.exists() and not _has_head(self._path, head):
                os.replace(self._path, f"{self._path}.damaged")
            rows = read_history_rows(self._path, self._columns)
            return [head, *(select_rows(rows, snapshot.state.time, ",") or [row])]

        self._file = RowFile(self._comm, self._path, make_first_lines)

    def observe(self, snapshot: Snapshot) -> None:
        """Append a row."""
        assert self._file is not None
        self._file.write(self._format_row(snapshot))

    def _format_row(self, snapshot: Snapshot) -> str:
        row = evaluate_channels(self._comm, self._channels, snapshot)
        return ",".join(map(_format_number, row))

    def save(self) -> RestartData:
        """Bring the rows to the disk; their number, columns and memories. Collective."""
        assert self._file is not None
        data = RestartData({"rows": self._file.sync() - 1, "columns": self._columns})
        data.add("memory", save_channels(self._channels))
        return data

    def restore(self, data: RestartData) -> None:
        """Leave out the channels that the file does not have; the others remember."""
        before = set(data.numbers["columns"])
        kept = tuple(c for c in self._channels if before.issuperset(c.columns))
        new = [name for c in self._channels if c not in kept for name in c.columns]
        if new:
            log.info("%s keeps its columns, without %s", self.name, ", ".join(new))
        self._channels = kept
        restore_channels(kept, data.part("memory"))

    def find_shortfall(self, data: RestartData, time: float) -> str | None:
        """Rows that the file lacks up to a checkpoint."""
        rows = read_history_rows(self._path, data.numbers["columns"])
        there = len(select_rows(rows, time + 1e-9 * max(1.0, abs(time)), ","))
        return describe_shortfall(self.name, there, data.numbers["rows"], "rows", time)

    def finish(self) -> None:
        """Close the file."""
        assert self._file is not None
        self._file.close()


def read_columns(path: str | os.PathLike[str]) -> list[str]:
    """Names of the columns of a ``history.csv``; none if there is no such file."""
    if not Path(path).exists():
        return []
    with name_file_in_errors("read", path), open_regular(path) as file:
        return split_columns(file.readline().decode("utf-8", "replace").strip())


def read_history_rows(path: str | os.PathLike[str], columns: Sequence[str]) -> list[str]:
    """The whole rows of a ``history.csv``; none if there is no such file or its columns differ."""
    rows = read_rows(path, 1, len(columns), ",")
    return rows if rows and _has_head(path, join_columns(columns)) else []


def _has_head(path: str | os.PathLike[str], head: str) -> bool:
    """Whether a file begins with a line."""
    with open_regular(path) as file:
        return file.readline() == f"{head}\n".encode()


def _format_number(x: float) -> str:
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
    """All joint coordinates: angles, and displacements under their names."""
    kinds = zip(system.joint_coordinate_names, system.rigid_model.is_angle, strict=True)
    columns = tuple((names.ANGLE if a else names.DISPLACEMENT)(joint=n) for n, a in kinds)
    return Channel(columns, lambda s: list(s.state.joint_coordinates))


def work_channel(stepper: Stepper) -> Channel:
    """Energy of springs, work of each force and drive, and what each damper dissipated so far.

    Quantities that do not occur in the system have no column. Total energy is initial energy plus
    all works minus everything dissipated.
    """
    system = stepper.system
    springs = any(e.kind == "conservative" for e in system.motion_forces) or any(
        model.has_surface_energy for model in system.flexible_models
    )
    gravity = [isinstance(force, Gravity) for force in system.prescribed_forces]
    places = [k for k in range(len(system.work_names)) if not (k < len(gravity) and gravity[k])]
    works = [system.work_names[k] for k in places]
    columns = (
        *((names.SPRING_ENERGY,) if springs else ()),
        *(names.WORK(name=name).replace(" ", "_") for name in works),
        *(names.DISSIPATION(name=name).replace(" ", "_") for name in stepper.dissipation_names),
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

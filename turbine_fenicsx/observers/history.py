"""Time series: one row of numbers per accepted step, in a CSV file that grows as the run does."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.loads import Gravity
from turbine_fenicsx.observers.row_file import RowFile
from turbine_fenicsx.simulation import Snapshot
from turbine_fenicsx.system import MultibodySystem


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
            begins a new file.

    Raises:
        OSError: if the file cannot be written, on all ranks.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        path: str | os.PathLike[str],
        channels: Sequence[Channel],
        keep_until: float | None = None,
    ) -> None:
        """Open the file and write the head."""
        self._channels = tuple(channels)

        def first() -> list[str]:
            kept = [] if keep_until is None else _rows_until(Path(path), keep_until)
            return kept or [",".join(name for c in self._channels for name in c.columns)]

        self._file = RowFile(comm, path, first)

    def observe(self, snapshot: Snapshot) -> None:
        """Append a row, but for a state that was observed before."""
        row = [x for channel in self._channels for x in channel.row(snapshot)]
        if not snapshot.resumed:
            self._file.write(",".join(_text(x) for x in row))

    def finish(self) -> None:
        """Close the file."""
        self._file.close()


def _rows_until(path: Path, time: float) -> list[str]:
    """Head and rows of a file up to a time [s], without a last row that was cut off."""
    lines = path.read_text(encoding="utf-8").split("\n")[:-1] if path.exists() else []
    return lines[:1] + [row for row in lines[1:] if float(row.split(",", 1)[0]) <= time]


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
            "time_[s]",
            "kinetic_energy_[J]",
            "strain_energy_[J]",
            "potential_energy_[J]",
            "total_energy_[J]",
            "external_work_[J]",
            "energy_error_[J]",
            *(f"linear_momentum_{i}_[kgm/s]" for i in (1, 2, 3)),
            *(f"angular_momentum_{i}_[Nms]" for i in (1, 2, 3)),
        ),
        values,
    )


def angle_channel(system: MultibodySystem) -> Channel:
    """All joint coordinates: angles, and displacements under names of their own."""
    kinds = zip(system.angle_names, system.rigid_block.is_angle, strict=True)
    columns = tuple(f"angle_{n}_[rad]" if a else f"displacement_{n}_[m]" for n, a in kinds)
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
        *(("spring_energy_[J]",) if springs else ()),
        *(f"work_of_{name}_[J]".replace(" ", "_") for name in works),
        *(f"dissipated_by_{name}_[J]".replace(" ", "_") for name in system.dissipation_names),
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

    return Channel(
        ("constraint_error_[-]", "newton_iterations", "krylov_iterations", "wall_time_[s]"), values
    )

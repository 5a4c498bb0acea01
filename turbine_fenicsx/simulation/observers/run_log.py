"""``run.log``: everything that happened in a run, one line each."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.simulation.snapshot import Snapshot

_PACKAGE = logging.getLogger("turbine_fenicsx")
log = logging.getLogger(__name__)


class StepLog:
    """An observer that logs a line for every step."""

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Log where the run begins."""
        self._time = snapshot.state.time
        log.info("%s at t = %.9g s", "resumed" if resumed else "begin", self._time)

    def observe(self, snapshot: Snapshot) -> None:
        """Log a step."""
        s, report = snapshot, snapshot.report
        t, dt = s.state.time, s.state.time - self._time
        self._time = t
        assert report is not None
        log.info(
            "step %d t = %.9g s dt = %.3g s, %d Newton, %d Krylov, residual %.1e, "
            "energy error %.2e J, constraints %.1e",
            s.index,
            t,
            dt,
            report.newton_iterations,
            report.krylov_iterations,
            report.residual,
            s.energy_error,
            s.constraint_error,
        )

    def finish(self) -> None:
        """There is no file to close."""


class _Handler(logging.FileHandler):
    """Writes to a file; a full disk does not end the run here."""

    def handleError(self, record: logging.LogRecord) -> None:
        """Drop the message."""


@contextmanager
def log_to_file(comm: MPI.Intracomm, path: str | os.PathLike[str], append: bool) -> Iterator[None]:
    """Write the messages of the package to a file, on rank 0.

    Args:
        append: Whether to keep what is in it.
    """

    def open_log() -> None:
        at = Path(path)
        if not at.is_char_device():
            if at.is_symlink():  # anybody's file might be emptied
                raise InputError(f"cannot write {os.fspath(path)}: it is a symbolic link")
            if at.exists() and not at.is_file():  # to open a pipe might not end
                raise InputError(f"cannot write {os.fspath(path)}: it is not a regular file")
        try:
            Path(path).open("a" if append else "w").close()
        except OSError as error:
            raise InputError(f"cannot write {os.fspath(path)}: {error.strerror}") from None

    on_rank0(comm, open_log)
    if comm.rank:
        yield
        return
    handler = _Handler(path, mode="a", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    level = _PACKAGE.level
    _PACKAGE.setLevel(logging.INFO)
    _PACKAGE.addHandler(handler)
    try:
        yield
    finally:
        _PACKAGE.removeHandler(handler)
        _PACKAGE.setLevel(level)
        with suppress(OSError):  # what there was no room for
            handler.close()

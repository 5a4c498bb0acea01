"""An output folder belongs to one run at a time."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mpi4py import MPI

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0


@contextmanager
def lock_folder(comm: MPI.Intracomm, folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Make a folder and keep other runs out of it.

    The system drops the lock when the program ends, however it ends.
    """
    path = Path(folder)

    def claim() -> int:
        try:
            path.mkdir(parents=True, exist_ok=True)
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW
            lock = os.open(path / ".lock", flags, 0o644)
        except OSError as error:
            if error.errno == errno.ELOOP and (path / ".lock").is_symlink():
                raise InputError(
                    f"cannot write to {str(folder)!r}: its .lock is a symbolic link"
                ) from None
            raise InputError(f"cannot write to {str(folder)!r}: {error.strerror}") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            raise InputError(f"the folder {str(folder)!r} is in use by another run") from None
        except OSError:
            pass  # a file system without locks
        return lock

    lock = on_rank0(comm, claim)
    try:
        yield path
    finally:
        if comm.rank == 0:
            os.close(lock)

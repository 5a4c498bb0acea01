"""Files that are whole at any moment, on the disk when it matters, and named when they fail."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from turbine_fenicsx.foundation.errors import FileError


@contextmanager
def name_file_in_errors(act: str, path: str | os.PathLike[str]) -> Iterator[None]:
    """Let errors say what was tried with which file.

    Args:
        act: What is tried: "read" or "write".
        path: The file.

    Raises:
        FileError: in the place of any other OSError.
    """
    try:
        yield
    except FileError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise FileError(f"cannot {act} {os.fspath(path)}: {reason}") from None


def replace_file(path: str | os.PathLike[str], content: bytes | memoryview) -> None:
    """Write a file beside the old one and let it take its place once it is on the disk.

    Nothing is written through a symbolic link, neither where the file is nor beside it.

    Args:
        path: The file; its folder exists.
        content: All of it.

    Raises:
        FileError: if it cannot be written; an old file is then as it was.
    """
    path = Path(path)
    temporary = path.with_name(f"{path.name}.tmp")
    with name_file_in_errors("write", path):
        try:
            temporary.unlink(missing_ok=True)
            with temporary.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except OSError:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)


def sync_file(path: str | os.PathLike[str]) -> None:
    """Bring what was written to a file to the disk, and wait for it.

    Raises:
        FileError: if it is not there or the disk refuses.
    """
    with name_file_in_errors("write", path):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def sync_folder(path: str | os.PathLike[str]) -> None:
    """Bring the names of the files in a folder to the disk, where its file system can do that."""
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(descriptor)

"""Files that are whole at any moment, on the disk when it matters, and named when they fail.

Files of others are opened by `open_regular`, which does not wait for a pipe.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path

from turbine_fenicsx.foundation.errors import FileError


@contextmanager
def name_file_in_errors(act: str, path: str | os.PathLike[str]) -> Iterator[None]:
    """Let errors say what was tried with which file."""
    try:
        yield
    except FileError:
        raise
    except OSError as error:
        name = os.fspath(path)
        name = name if name.isprintable() else repr(name)
        raise FileError(f"cannot {act} {name}: {error.strerror or error}") from None


def open_regular(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a file from outside to read its bytes.

    Pipes and devices are refused: to read them would not end.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except ValueError:  # a null byte, half a character
        raise OSError(errno.EINVAL, "its name is not valid", os.fspath(path)) from None
    except OSError as error:
        if error.errno != errno.ENXIO:  # a socket
            raise
        raise OSError(errno.EINVAL, "it is not a regular file", os.fspath(path)) from None
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(descriptor, "rb")
    os.close(descriptor)
    if stat.S_ISDIR(mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    raise OSError(errno.EINVAL, "it is not a regular file", os.fspath(path))


def read_regular(path: str | os.PathLike[str]) -> bytes:
    """The bytes of a file from outside; errors as in `open_regular`."""
    with open_regular(path) as file:
        return file.read()


def replace_file(path: str | os.PathLike[str], content: bytes | memoryview) -> None:
    """Write a file beside the old one and let it take its place once it is on the disk.

    Nothing is written through a symbolic link, neither where the file is nor beside it, and no
    device or pipe is replaced.
    """
    path = Path(path)
    temporary = path.with_name(f"{path.name}.tmp")
    with name_file_in_errors("write", path):
        if path.exists() and not (path.is_file() or path.is_symlink() or path.is_dir()):
            raise OSError(errno.EINVAL, "it is not a regular file", os.fspath(path))
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
    """Bring what was written to a file to the disk, and wait for it."""
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

"""Cache of compiled forms: one process compiles at a time, leftovers of dead ones are removed.

DOLFINx takes a file ``NAME.c`` without ``NAME.c.cached`` for a form that another process compiles.
If that process was killed, all later ones would wait for it in vain.
"""

from __future__ import annotations

import errno
import fcntl
import functools
import hashlib
import logging
import os
import re
import shlex
import shutil
import sysconfig
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from mpi4py import MPI

from cffi import VerificationError

from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.interrupts import end_at_once
from turbine_fenicsx.foundation.parallel import on_rank0, raise_together

PATIENCE = 900
"""Time after which another process will not finish a form any more [s]."""

WORTH_SAYING = 1.0
"""Time of waiting that is told; to load a compiled form takes others a small part of it [s]."""

T = TypeVar("T", bound=tuple[Any, ...])
log = logging.getLogger(__name__)


EXTRA_FLAGS = "TURBINE_FENICSX_CFLAGS"
"""Variable with more flags for the compiler of forms, such as ``-march=native``."""


def read_extra_flags() -> list[str]:
    """Flags for the compiler of forms that the user adds, which also tell compiled forms apart.

    Where code is made for this processor, a name of the processor is among them, so that another
    machine with the same cache compiles for itself.

    Raises:
        CompilationError: for a quotation without its end.
    """
    text = os.environ.get(EXTRA_FLAGS, "")
    try:
        flags = shlex.split(text)
    except ValueError as error:
        raise CompilationError(f"{EXTRA_FLAGS} = {text!r}: {str(error).lower()}") from None
    if any(flag.endswith("=native") for flag in flags):
        processor = "\n".join(
            sorted(set(re.findall(r"^(?:model name|flags).*$", describe_processors(), re.M)))
        )
        flags.append(f"-DPROCESSOR_{hashlib.sha1(processor.encode()).hexdigest()[:16]}")
    return flags


def compile_on_all(comm: MPI.Intracomm, folder: Path, compile_here: Callable[[], T]) -> T:
    """Compile on rank 0, and load on the other ranks; those that see another folder compile too.

    Args:
        comm: Communicator.
        folder: Where compiled code is kept, used in no other way than this; created if need be.
        compile_here: Compiles, or loads what is there, without communication. Its result holds
            the Python module with the code in second place.

    Returns:
        The result of this rank.

    Raises:
        CompilationError: on every rank, if there is no C compiler, it fails, the folder cannot be
            written to, or another process does not finish.
        KeyboardInterrupt: on every rank, if rank 0 was interrupted.

    Note:
        Collective over ``comm``.
    """
    made: list[T] = []

    def compile_first() -> str:
        made.append(_compile_alone(folder, compile_here))
        return Path(made[0][1].__file__).name.partition(".")[0]

    name = on_rank0(comm, compile_first)
    if comm.size == 1:
        return made[0]
    error: BaseException | None = None
    if comm.rank > 0:
        try:
            if (folder / f"{name}.c.cached").exists():
                made.append(_compile(folder, compile_here))
            else:
                made.append(_compile_alone(folder, compile_here))
        except BaseException as raised:  # all ranks must hear of it
            error = raised
    raise_together(comm, error)
    return made[0]


def _compile_alone(folder: Path, compile_here: Callable[[], T]) -> T:
    """Compile while no other process does, and without what dead ones have left."""
    with end_at_once(), _lock(folder) as alone:
        if folder.is_dir():
            _remove_leavings(folder, 0.0 if alone else PATIENCE)
        try:
            return _compile(folder, compile_here)
        except ImportError as error:
            if not (alone and error.path):
                raise
            _remove(Path(error.path))  # cut short when the computer went down
            return _compile(folder, compile_here)


@contextmanager
def _lock(folder: Path) -> Iterator[bool]:
    """Keep other processes out, and tell whether that was possible.

    The system drops the lock when the program ends, however it ends.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:  # what is compiled already can be used all the same
        yield False
        return
    try:
        yield _take(lock, folder)
    finally:
        os.close(lock)


def _take(lock: int, folder: Path) -> bool:
    """Wait for a lock, and tell whether the file system has such a thing."""
    begin = time.monotonic()
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            waited = time.monotonic() - begin
            if waited > PATIENCE:
                raise CompilationError(_describe_wait(folder)) from None
            if waited > WORTH_SAYING:
                _say_once(f"waiting for another process to compile into {str(folder)!r}")
            time.sleep(0.1)
        except OSError as error:
            _say_once(
                f"the file system of {str(folder)!r} has no locks ({error.strerror}): if a "
                f"compilation is killed there, runs of the next {PATIENCE // 60} minutes fail; "
                "XDG_CACHE_HOME names another place"
            )
            return False


@functools.cache
def _say_once(sentence: str) -> None:
    """Log a warning, once in the life of the process."""
    log.warning(sentence)


def _remove_leavings(folder: Path, age: float) -> None:
    """Remove files of compilations that were not finished and are older than ``age`` [s]."""
    names = set(os.listdir(folder))
    for name in names:
        if name.endswith(".c") and f"{name}.cached" not in names:
            path = folder / name
            if time.time() - path.stat().st_mtime >= age:
                _remove(path)


def _remove(path: Path) -> None:
    """Remove all files of a form."""
    for file in path.parent.glob(f"{path.name.partition('.')[0]}.*"):
        file.unlink(missing_ok=True)


def _compile(folder: Path, compile_here: Callable[[], T]) -> T:
    """Compile, with one sentence about what keeps the compiler from it."""
    try:
        return compile_here()
    except TimeoutError:
        raise CompilationError(_describe_wait(folder)) from None
    except OSError as error:
        reason = error.strerror or error
        if error.errno in (errno.EACCES, errno.EROFS, errno.ENOSPC, errno.EDQUOT):
            reason = f"{reason}; XDG_CACHE_HOME names another place"
        raise CompilationError(f"cannot compile a form into {str(folder)!r}: {reason}") from error
    except VerificationError as error:
        raise CompilationError(f"cannot compile a form: {_describe_fault(error)}") from error


def _describe_wait(folder: Path) -> str:
    """The sentence about a process that takes too long."""
    return (
        f"another process has not finished compiling into {str(folder)!r} within "
        f"{PATIENCE // 60} minutes; end it, or set XDG_CACHE_HOME to another place"
    )


def _describe_fault(error: Exception) -> str:
    """What is wrong with the compiler, or what it says."""
    name = (os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc").split()[0]
    if shutil.which(name) is None:
        return f"FFCx needs a C compiler and there is no {name!r}; on Debian: apt install gcc"
    if not Path(sysconfig.get_path("include"), "Python.h").exists():
        return "FFCx needs the header files of Python; on Debian: apt install python3-dev"
    return f"{error}; see the messages of the compiler above"


def describe_processors() -> str:
    """What Linux says of the processors of this machine, /proc/cpuinfo; empty if that is hidden."""
    try:
        return Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return ""

"""Cache of compiled forms: one process compiles each form, leftovers of dead ones are removed.

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
import pwd
import re
import shlex
import shutil
import stat
import sysconfig
import time
from collections.abc import Callable
from contextlib import closing, suppress
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any, TypeVar

from mpi4py import MPI

from cffi import VerificationError

from turbine_fenicsx.foundation.errors import CompilationError
from turbine_fenicsx.foundation.files import read_regular, replace_file
from turbine_fenicsx.foundation.interrupts import end_immediately
from turbine_fenicsx.foundation.parallel import on_rank0, raise_together


def describe_stranger(path: Path) -> str | None:
    """Say who else could have written a folder, or a file in it.

    The system's administrator may, and so may the group, which the umask of many systems lets in.
    A link in a folder counts as what it leads to.

    Args:
        path: The folder or file; it need not exist.

    Returns:
        What is wrong, to follow the name of the path; None if nothing is.
    """
    try:
        status = os.stat(path)
    except OSError:
        return None
    if status.st_uid not in (os.geteuid(), 0):
        return f"belongs to {_name_user(status.st_uid)}, not to you"
    if status.st_mode & stat.S_IWOTH and not stat.S_ISCHR(status.st_mode):
        mode = stat.S_IMODE(status.st_mode)
        return f"may be written to by everybody (mode {mode:o}; `chmod o-w` forbids it)"
    return None


def _name_user(number: int) -> str:
    """Name of a user, or the number of one without a name."""
    try:
        return f"the user {pwd.getpwuid(number).pw_name!r}"
    except KeyError:
        return f"the user {number}"


PATIENCE = 900
"""Time after which DOLFINx does not wait for a form any more, in a folder without a claim [s]."""

WORTH_SAYING = 1.0
"""Waiting time after which a message appears; loading a compiled form takes a small part of it
[s]."""

T = TypeVar("T", bound=tuple[Any, ...])
log = logging.getLogger(__name__)


EXTRA_FLAGS = "TURBINE_FENICSX_CFLAGS"
"""Variable with more flags for the compiler of forms, such as ``-march=native``."""


def read_extra_flags() -> list[str]:
    """Flags for the compiler of forms that the user adds, which also identify compiled forms.

    Where code is made for this processor, a name of the processor is among them, so that another
    machine with the same cache compiles for itself.
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


def compile_on_all(
    comm: MPI.Intracomm, folder: Path, compile_here: Callable[[Path, Claim], T]
) -> T:
    """Compile on rank 0, and load on the other ranks; those that see another folder compile too.

    Args:
        folder: Where compiled code is kept, used in no other way than this; created if need be.
        compile_here: Compiles into a folder, or loads what is there, without communication. It
            calls the claim with the name of the form before it looks for its files, and its
            result holds the Python module with the code in second place.

    Note:
        Collective over ``comm``.
    """
    made: list[T] = []

    def compile_first() -> Path | None:
        made.append(_compile_alone(folder, compile_here))
        place = Path(made[0][1].__file__).parent
        return None if place == folder else place

    elsewhere = on_rank0(comm, compile_first)
    if comm.size == 1:
        return made[0]
    error: BaseException | None = None
    if comm.rank > 0:
        try:
            place = elsewhere if elsewhere is not None and elsewhere.is_dir() else folder
            made.append(_compile_alone(place, compile_here))
        except BaseException as raised:  # all ranks must hear of it
            error = raised
    raise_together(comm, error)
    return made[0]


def _compile_alone(folder: Path, compile_here: Callable[[Path, Claim], T]) -> T:
    """Compile while no other process does, and without what dead ones have left."""
    _check_trust(folder)
    with end_immediately(), closing(Claim(folder)) as claim:
        try:
            made = _compile(folder, compile_here, claim)
            claim.seal()
            return made
        except ImportError:
            if not (claim.name and claim.take(all_files=True)):
                raise
            made = _compile(folder, compile_here, claim)  # cut short when the computer went down
            claim.seal()
            return made


class Claim:
    """The right to compile one form. Forms that are compiled already need none.

    The system drops the lock when the process ends, however it ends.

    Attributes:
        name: Name of the form; empty until it is known.
    """

    def __init__(self, folder: Path) -> None:
        self.name = ""
        self._folder = folder
        self._lock: int | None = None

    def __call__(self, name: str) -> None:
        """Wait until the form is compiled, or until this process alone may compile it."""
        self.name = name
        self._check_code()
        if not self._is_whole():
            self.take()
            self._check_code()

    def take(self, all_files: bool = False) -> bool:
        """Take the lock of the form and remove what dead processes have left of it.

        Returns:
            Whether there is a lock, which a folder that is not writable has not.
        """
        if not self._wait():
            return False
        if all_files or not self._is_whole():
            files = self._folder.glob(f"{self.name}.*")
            for file in sorted(files, key=lambda file: file.suffix != ".cached"):
                file.unlink(missing_ok=True)
        return True

    def _check_code(self) -> None:
        """Refuse code that others may have written."""
        for suffix in EXTENSION_SUFFIXES:
            _check_trust(self._folder / f"{self.name}{suffix}")

    def seal(self) -> None:
        """Write a checksum of the code that was compiled here; a computer may go down meanwhile.

        Code that was cut off later can be loaded, and then ends the process when it is run.
        """
        if self._lock is not None and not self._is_whole() and (digest := self._digest()):
            with suppress(OSError):
                replace_file(self._seal, digest)

    def _is_whole(self) -> bool:
        """Whether the form is compiled, and its code is what the compiler wrote."""
        if not (self._folder / f"{self.name}.c.cached").exists():
            return False
        try:
            return read_regular(self._seal) == self._digest()
        except OSError:  # code of an earlier version, which cannot be replaced in some folders
            return not os.access(self._folder, os.W_OK)

    def _digest(self) -> bytes:
        """Checksum of the code; empty if there is none."""
        for suffix in EXTENSION_SUFFIXES:
            with suppress(OSError):
                code = read_regular(self._folder / f"{self.name}{suffix}")
                return hashlib.blake2b(code, digest_size=16).hexdigest().encode()
        return b""

    @property
    def _seal(self) -> Path:
        return self._folder / f"{self.name}.seal"

    def close(self) -> None:
        """Let others in; nobody needs the lock of what is compiled."""
        if self._lock is None:
            return
        with suppress(OSError):
            if (self._folder / f"{self.name}.c.cached").exists():
                self._path.unlink()
        os.close(self._lock)
        self._lock = None

    @property
    def _path(self) -> Path:
        return self._folder / f".{self.name}.lock"

    def _wait(self) -> bool:
        """Wait for the lock; False in a folder that is not writable."""
        if self._lock is not None:
            return True
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
        except OSError:  # what is compiled already can be used all the same
            return False
        try:
            self._lock_file()
        except OSError as error:
            raise CompilationError(
                f"the file system of {str(self._folder)!r} has no locks ({error.strerror}); "
                "XDG_CACHE_HOME names another place"
            ) from None
        return True

    def _lock_file(self) -> None:
        """Wait until no other process has the lock, and say so if it takes longer."""
        assert self._lock is not None
        begin = time.monotonic()
        while time.monotonic() < begin + WORTH_SAYING:
            try:
                return fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                time.sleep(0.1)
        _say_once(f"waiting for another process to compile into {str(self._folder)!r}")
        fcntl.flock(self._lock, fcntl.LOCK_EX)


def _check_trust(path: Path) -> None:
    """Refuse to run code that others may have written."""
    wrong = describe_stranger(path)
    if wrong:
        raise CompilationError(
            f"the cache of compiled forms {str(path)!r} {wrong}; or set XDG_CACHE_HOME to a folder "
            "of your own"
        )


@functools.cache
def _say_once(sentence: str) -> None:
    """Log a warning, once in the life of the process."""
    log.warning(sentence)


def _compile(folder: Path, compile_here: Callable[[Path, Claim], T], claim: Claim) -> T:
    """Compile, with one sentence about what keeps the compiler from it."""
    try:
        return compile_here(folder, claim)
    except TimeoutError:
        raise CompilationError(
            f"another process has not finished compiling into {str(folder)!r} within "
            f"{PATIENCE // 60} minutes; end it, or set XDG_CACHE_HOME to another place"
        ) from None
    except OSError as error:
        reason = error.strerror or error
        if error.errno in (errno.EACCES, errno.EROFS, errno.ENOSPC, errno.EDQUOT):
            reason = f"{reason}; XDG_CACHE_HOME names another place"
        raise CompilationError(f"cannot compile a form into {str(folder)!r}: {reason}") from error
    except VerificationError as error:
        raise CompilationError(f"cannot compile a form: {_describe_fault(error)}") from error


def _describe_fault(error: Exception) -> str:
    """Complaint about the compiler, or its message."""
    name = (os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc").split()[0]
    if shutil.which(name) is None:
        return f"FFCx needs a C compiler and there is no {name!r}; on Debian: apt install gcc"
    if not Path(sysconfig.get_path("include"), "Python.h").exists():
        return "FFCx needs the header files of Python; on Debian: apt install python3-dev"
    return f"{error}; see the messages of the compiler above"


def describe_processors() -> str:
    """Description of this machine's processors, /proc/cpuinfo; empty if that is hidden."""
    try:
        return Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return ""

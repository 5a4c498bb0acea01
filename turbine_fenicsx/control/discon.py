"""Controllers in the shape of Bladed's: a shared library with a routine DISCON.

The library lives in a process of its own: it may print, write files, and end that process, as
Fortran does where an input file is missing, and a second one can be loaded beside it. The records
of its swap array are those of Bladed as OpenFAST's ServoDyn fills them.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import IO

from turbine_fenicsx.control import discon_child
from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.mpi_environment import environment_without_mpi

PATIENCE = 60.0
"""Time in which the library must answer [s]."""

NAME = "control.SrvD"
"""Files of the library begin with this without its ending, as if OpenFAST had called it."""

LOG, ERRORS = "library.log", "library_errors.log"
"""What the library prints on its two outputs."""

STATUS, FIRST, NEXT, LAST = 1, 0.0, 1.0, -1.0
"""Record of the status, and its values."""

_CHECK_LENGTH = 250
"""Longest path that libraries in Fortran take."""


def check_library(library: Path, infile: Path) -> str:
    """A sentence if library or input file are missing or cannot be what they should be."""
    for what, path in (("library", library), ("input", infile)):
        if not path.is_file():
            return f"control.{what} = '{path}': there is no such file"
        if not os.access(path, os.R_OK):
            return f"control.{what} = '{path}': the file cannot be read"
    with library.open("rb") as file:
        if file.read(4) != b"\x7fELF":
            return f"control.library = '{library}': is no shared library of Linux"
    if not infile.stat().st_size:
        return f"control.input = '{infile}': the file is empty"
    if len(os.fsencode(infile.absolute())) > _CHECK_LENGTH:
        return (
            f"control.input = '{infile}': a controller reads paths of at most {_CHECK_LENGTH} "
            f"letters, this one has {len(os.fsencode(infile.absolute()))} from the root on"
        )
    return ""


class Discon:
    """A library with its input file in a process of its own; call it on one rank only.

    Args:
        library: The shared library.
        infile: Its input file, often called DISCON.IN.
        folder: Where it writes and prints; made if it is not there.
        pitch_limits: Smallest and largest pitch, Bladed's records 6 and 7 [rad].

    Raises:
        InputError: if a file is missing, or the process cannot be started.
    """

    def __init__(
        self,
        library: Path,
        infile: Path,
        folder: Path,
        pitch_limits: tuple[float, float] = (0.0, 1.570796),
    ) -> None:
        sentence = check_library(library, infile)
        if sentence:
            raise InputError(sentence)
        self._limits, self._library = pitch_limits, library
        folder.mkdir(exist_ok=True)
        self._errors = folder / ERRORS
        ours, theirs = os.pipe()
        # not a pipe, whose SIGPIPE PETSc would catch where the process has ended
        self._requests, theirs_too = socket.socketpair()
        files = [str(path.absolute()) for path in (library, infile)]
        command = [sys.executable, "-I", str(discon_child.__file__), *files, NAME, str(theirs)]
        with (folder / LOG).open("ab") as log, self._errors.open("ab") as errors:
            self._child = subprocess.Popen(
                command,
                cwd=folder,
                env=environment_without_mpi(),
                stdin=theirs_too.fileno(),
                stdout=log,
                stderr=errors,
                pass_fds=(theirs,),
                start_new_session=True,  # Ctrl-C is for the run, which still needs its controller
            )
        os.close(theirs)
        theirs_too.close()
        self._replies: IO[bytes] = os.fdopen(ours, "rb", buffering=0)
        self._last: Measurements | None = None

    def respond(self, measured: Measurements) -> Commands:
        """Commands of the library.

        Raises:
            InputError: if it reports an error, ends, or does not answer.
        """
        status = FIRST if measured.first else NEXT
        pitch_1, pitch_2, pitch_3, _, torque, yaw_rate = self._call(measured, status)
        self._last = measured
        return Commands(torque, (pitch_1, pitch_2, pitch_3), yaw_rate)

    def finish(self) -> None:
        """The last call, after which the process ends."""
        try:
            if self._last is not None and self._child.poll() is None:
                self._call(self._last, LAST)
        except InputError:  # the run has its results; the log says what went wrong
            pass
        finally:
            self._end()

    def _call(self, measured: Measurements, status: float) -> list[float]:
        """Call the library once."""
        records = self._fill(measured) | {STATUS: status}
        request = b"".join(discon_child.PAIR.pack(*pair) for pair in records.items())
        try:
            count = discon_child.COUNT.pack(len(records))
            self._requests.sendall(count + request, socket.MSG_NOSIGNAL)
            failed, *values, length = discon_child.REPLY.unpack(self._read(discon_child.REPLY.size))
            text = self._read(length).decode(errors="replace")
        except (ConnectionError, EOFError):
            raise InputError(self._tell_end(measured.time)) from None
        except TimeoutError:
            self._child.kill()
            self._end()
            raise InputError(
                f"the controller '{self._library}' has not answered within {PATIENCE:g} s at "
                f"t = {measured.time:g} s"
            ) from None
        if failed < 0:
            self._end()
            raise InputError(
                f"the controller '{self._library}' stops at t = {measured.time:g} s: "
                f"{text or 'it does not say why'}"
            )
        return values

    def _fill(self, m: Measurements) -> dict[int, float]:
        """Records of the swap array, counted from 1 as in Bladed's manual; others are zero."""
        low, high = self._limits
        return {
            2: m.time,
            3: m.dt,
            4: m.pitch[0],
            6: low,
            7: high,
            14: m.generator_torque * m.generator_speed,
            15: m.electrical_power,
            20: m.generator_speed,
            21: m.rotor_speed,
            23: m.generator_torque,
            24: m.yaw_error,
            27: m.wind_speed,
            28: 1.0,  # blades may have pitch angles of their own
            30: m.flap_moments[0],
            31: m.flap_moments[1],
            32: m.flap_moments[2],
            33: m.pitch[1],
            34: m.pitch[2],
            37: m.yaw,
            53: m.top_acceleration[0],
            54: m.top_acceleration[1],
            60: m.azimuth,
            61: 3.0,
            69: m.edge_moments[0],
            70: m.edge_moments[1],
            71: m.edge_moments[2],
        }

    def _read(self, length: int) -> bytes:
        """So many bytes of a reply; TimeoutError or EOFError if they do not come."""
        found = b""
        while len(found) < length:
            ready, _, _ = select.select([self._replies], [], [], PATIENCE)
            if not ready:
                raise TimeoutError
            piece = self._replies.read(length - len(found))
            if not piece:
                raise EOFError
            found += piece
        return found

    def _tell_end(self, time: float) -> str:
        """What is known of a process that has ended."""
        code = self._child.wait()
        self._end()
        lines = self._errors.read_text(errors="replace").strip().splitlines()
        said = f": {lines[-1].strip()}" if lines else ""
        if code == discon_child.NO_LIBRARY:
            return f"control.library = '{self._library}': cannot be loaded{said}"
        how = f"crashes ({signal.Signals(-code).name})" if code < 0 else "ends its process"
        return f"the controller '{self._library}' {how} at t = {time:g} s{said}"

    def _end(self) -> None:
        """End the process."""
        self._requests.close()
        self._replies.close()
        try:
            self._child.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()

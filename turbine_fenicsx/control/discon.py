"""Controllers in the shape of Bladed's: a shared library with a routine DISCON.

The library runs in a separate process. It may print, write files, and end that process, as Fortran
does where an input file is missing. A second library can be loaded beside it. The records of its
swap array are those of Bladed as OpenFAST's ServoDyn fills them.
"""

from __future__ import annotations

import logging
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

from turbine_fenicsx.control import discon_child
from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.foundation.errors import ForeignError, InputError
from turbine_fenicsx.foundation.mpi_environment import environment_without_mpi
from turbine_fenicsx.foundation.own_code import escape

log = logging.getLogger(__name__)

PATIENCE = 60.0
"""Time in which the library must answer [s]."""

NAME = "control.SrvD"
"""Files of the library begin with this without its ending, as if OpenFAST had called it."""

LOG, ERRORS = "library.log", "library_errors.log"
"""Output of the library on stdout and stderr."""

STATUS, FIRST, NEXT, LAST = 1, 0.0, 1.0, -1.0
"""Record of the status, and its values."""

CONTACTOR, BRAKE = 35, 36
"""Records of the generator contactor (0 is off) and of the shaft brake (0 is open)."""

MOST_WARNINGS = 20
"""A library with more different warnings puts numbers into them."""

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
    """A library with its input file in a separate process; call it on one rank only.

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
        # not a pipe, whose SIGPIPE PETSc would catch where the process has ended
        self._line, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        files = [str(path.absolute()) for path in (library, infile)]
        numbers = [str(theirs.fileno()), str(os.getpid())]
        command = [sys.executable, "-I", str(discon_child.__file__), *files, NAME, *numbers]
        with theirs, (folder / LOG).open("ab") as log_file, self._errors.open("ab") as errors:
            self._child = subprocess.Popen(
                command,
                cwd=folder,
                env=environment_without_mpi(),
                stdin=subprocess.DEVNULL,
                stdout=log_file,
                stderr=errors,
                pass_fds=(theirs.fileno(),),
                start_new_session=True,  # Ctrl-C is for the run, which still needs its controller
            )
        self._last: Measurements | None = None
        self._warned: set[str] = set()

    def respond(self, measured: Measurements) -> Commands:
        """Commands of the library.

        Raises:
            ForeignError: if it reports an error, ends, or does not answer.
        """
        status = FIRST if measured.first else NEXT
        contactor, brake, *pitch, torque, yaw_rate = self._call(measured, status)
        self._last = measured
        return Commands(
            torque if contactor else 0.0,
            (pitch[0], pitch[1], pitch[2]),
            yaw_rate,
            1.0 if brake else 0.0,
        )

    def finish(self) -> None:
        """The last call, after which the process ends.

        Raises:
            ForeignError: if it fails in this call.
        """
        try:
            if self._last is not None and self._child.poll() is None:
                self._call(self._last, LAST)
        finally:
            self._end()

    def _call(self, measured: Measurements, status: float) -> list[float]:
        """Call the library once; the values of `discon_child.REPLIES`."""
        records = self._fill(measured) | {STATUS: status}
        if status == FIRST:
            records |= {CONTACTOR: 1.0, BRAKE: 0.0}
        token, who = os.urandom(discon_child.TOKEN), f"the controller '{self._library}'"
        try:
            pairs = b"".join(discon_child.PAIR.pack(*pair) for pair in records.items())
            self._line.send(token + pairs, socket.MSG_NOSIGNAL)
            reply = self._receive(token)
        except TimeoutError:
            self._child.kill()
            self._end()
            raise ForeignError(
                f"{who} has not answered within {PATIENCE:g} s at t = {measured.time:g} s"
            ) from None
        except (OSError, EOFError):
            raise ForeignError(self._describe_end(measured.time)) from None
        failed, *values = discon_child.REPLY.unpack(reply[: discon_child.REPLY.size])
        text = escape(" ".join(reply[discon_child.REPLY.size :].decode(errors="replace").split()))
        if failed < 0:
            self._end()
            raise ForeignError(
                f"{who} stops at t = {measured.time:g} s: {text or 'it does not say why'}"
            )
        if failed > 0:
            self._warn(f"{who} warns", measured.time, text)
        return values

    def _receive(self, token: bytes) -> bytes:
        """The reply to a request, without its token; other packets are none."""
        deadline = time.monotonic() + PATIENCE
        while True:
            self._line.settimeout(max(deadline - time.monotonic(), 1e-3))
            packet = self._line.recv(discon_child.PACKET)
            if not packet:
                raise EOFError
            least = len(token) + discon_child.REPLY.size
            if packet.startswith(token) and len(packet) >= least:
                return packet.removeprefix(token)

    def _warn(self, who: str, time: float, text: str) -> None:
        """Show what the library warns of, each text once."""
        if text in self._warned or len(self._warned) > MOST_WARNINGS:
            return
        self._warned.add(text)
        if len(self._warned) > MOST_WARNINGS:
            log.warning("%s of more, which is not shown", who)
        else:
            log.warning("%s at t = %g s: %s", who, time, text or "it does not say of what")

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

    def _describe_end(self, time: float) -> str:
        """Description of a process that has ended."""
        self._end()
        code = self._child.returncode
        lines = self._errors.read_text(errors="replace").strip().splitlines()
        said = f": {escape(lines[-1].strip())}" if lines else ""
        if code == discon_child.NO_LIBRARY:
            return f"control.library = '{self._library}': cannot be loaded{said}"
        how = f"crashes ({signal.Signals(-code).name})" if code < 0 else "ends its process"
        return f"the controller '{self._library}' {how} at t = {time:g} s{said}"

    def _end(self) -> None:
        """End the process."""
        self._line.close()
        try:
            self._child.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()

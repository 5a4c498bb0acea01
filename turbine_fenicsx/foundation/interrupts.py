"""Signals that ask a run to stop."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from types import FrameType

from mpi4py import MPI

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
"""Ctrl-C; what batch systems send when time is up; and what mpirun hands on without killing."""


class Interrupt:
    """Says whether a signal has come.

    Attributes:
        received: Name of the signal; empty as long as there was none.
        at_once: Whether it ends the work at hand, see `end_immediately`.
    """

    received = ""
    at_once = False

    def __call__(self) -> bool:
        """Whether to stop."""
        return bool(self.received)


_catching: list[Interrupt] = []


@contextmanager
def catch_signals() -> Iterator[Interrupt]:
    """Catch the first of `SIGNALS`, so that the work at hand can be finished.

    A second one acts as usual.
    """
    interrupt = Interrupt()
    before = {number: signal.getsignal(number) for number in SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def catch(number: int, frame: FrameType | None) -> None:
        interrupt.received = signal.Signals(number).name
        restore()
        if interrupt.at_once:
            raise KeyboardInterrupt

    for number in SIGNALS:
        signal.signal(number, catch)
    _catching.append(interrupt)
    try:
        yield interrupt
    finally:
        _catching.remove(interrupt)
        restore()


@contextmanager
def end_immediately() -> Iterator[None]:
    """Let a signal end what is done here, also where signals are caught.

    For work without steps that is lost anyway unless it is finished.

    Raises:
        KeyboardInterrupt: when a signal comes, or has come already.
    """
    interrupt = _catching[-1] if _catching else Interrupt()
    before, interrupt.at_once = interrupt.at_once, True
    try:
        if interrupt.received:
            raise KeyboardInterrupt
        yield
    finally:
        interrupt.at_once = before


def end_immediately_alone(comm: MPI.Intracomm) -> AbstractContextManager[None]:
    """`end_immediately` on one rank; several would end at different places and deadlock.

    Those who started them end them.
    """
    return end_immediately() if comm.size == 1 else nullcontext()

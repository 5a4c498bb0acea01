"""Signals that ask a run to stop."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the command line catches signals before it starts MPI
    from mpi4py import MPI

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGHUP)
"""Ctrl-C; what batch systems send when time is up; what mpirun hands on without killing; and a
terminal that is closed, unless `nohup` lets the program ignore it."""

STUCK = 5.0
"""Time after a signal in which code of a user must return [s]."""


class Interrupt:
    """Says whether a signal has come.

    Attributes:
        received: Name of the signal; empty as long as there was none.
        at_once: Whether it ends the work at hand, see `end_immediately`.
        may_hang: Whether the work at hand may never end, see `end_if_stuck`.
    """

    received = ""
    at_once = False
    may_hang = False

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
    before = _list_handlers()

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def catch(number: int, frame: FrameType | None) -> None:
        interrupt.received = signal.Signals(number).name
        for other, handler in before.items():
            signal.signal(other, signal.SIG_DFL if handler is raise_interrupt else handler)
        if interrupt.at_once:
            raise KeyboardInterrupt
        if interrupt.may_hang:
            _set_alarm()

    for number in before:
        signal.signal(number, catch)
    _catching.append(interrupt)
    try:
        yield interrupt
    finally:
        _catching.remove(interrupt)
        restore()


@contextmanager
def end_quietly() -> Iterator[None]:
    """Treat all of `SIGNALS` as Ctrl-C, where no work has begun yet."""
    before = _list_handlers()
    for number in before:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, raise_interrupt)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def raise_interrupt(number: int, frame: FrameType | None) -> None:
    """Handler of a signal that acts as Ctrl-C."""
    raise KeyboardInterrupt


def _list_handlers() -> dict[signal.Signals, Any]:
    """Handlers of `SIGNALS`, except of a closed terminal that is to be ignored."""
    found = {number: signal.getsignal(number) for number in SIGNALS}
    if found[signal.SIGHUP] is signal.SIG_IGN:
        del found[signal.SIGHUP]
    return found


def _set_alarm() -> None:
    """Raise a KeyboardInterrupt in a while, unless the alarm is cleared before."""
    signal.signal(signal.SIGALRM, raise_interrupt)
    signal.setitimer(signal.ITIMER_REAL, STUCK)


@contextmanager
def end_if_stuck() -> Iterator[None]:
    """Let a signal end what is done here, should it not end soon by itself."""
    interrupt = _catching[-1] if _catching else Interrupt()
    before, interrupt.may_hang = interrupt.may_hang, True
    try:
        if interrupt.received:
            _set_alarm()
        yield
    finally:
        interrupt.may_hang = before
        if interrupt.received:
            signal.setitimer(signal.ITIMER_REAL, 0.0)


@contextmanager
def end_immediately() -> Iterator[None]:
    """Let a signal end what is done here, also where signals are caught.

    For work without steps that is lost anyway unless it is finished.
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

"""Signals that ask a run to stop."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
"""Ctrl-C; what batch systems send when time is up; and what mpirun hands on without killing."""


class Interrupt:
    """Says whether a signal has come.

    Attributes:
        received: Name of the signal; empty as long as there was none.
    """

    received = ""

    def __call__(self) -> bool:
        """Whether to stop."""
        return bool(self.received)


@contextmanager
def catching_signals() -> Iterator[Interrupt]:
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

    for number in SIGNALS:
        signal.signal(number, catch)
    try:
        yield interrupt
    finally:
        restore()

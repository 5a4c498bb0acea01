"""Progress while frames are drawn: a bar on a terminal, else one line every few seconds."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

EVERY = 10.0
"""Seconds between two lines."""


class Frames:
    """Counts frames on stderr, as a context.

    Args:
        total: Number of frames.
    """

    def __init__(self, total: int) -> None:
        self._total, self._drawn = total, 0
        self._last = time.perf_counter()
        self._bar: Any = None

    def __enter__(self) -> Frames:
        if sys.stderr.isatty():
            from tqdm import tqdm

            self._bar = tqdm(total=self._total, unit="frame", file=sys.stderr)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.close()

    def count(self) -> None:
        """Count one more."""
        self._drawn += 1
        if self._bar is not None:
            self._bar.update()
        elif time.perf_counter() - self._last > EVERY:
            self._last = time.perf_counter()
            print(f"frame {self._drawn} of {self._total}", file=sys.stderr, flush=True)

"""Timing by PETSc log events, which also show in PETSc's own -log_view."""

from __future__ import annotations

import functools

from petsc4py import PETSc

EVENTS = ("residual", "linear set-up", "linear solve", "balance", "output")
"""Parts of a run that are timed."""


@functools.cache
def event(name: str) -> PETSc.Log.Event:
    """The event of a part, a context manager."""
    return PETSc.Log.Event(f"turbine {name}")


def start() -> None:
    """Begin to measure."""
    PETSc.Log.begin()


def seconds() -> dict[str, float]:
    """Seconds spent in each part on this rank since the first `start` of this process."""
    return {name: float(event(name).getPerfInfo()["time"]) for name in EVENTS}

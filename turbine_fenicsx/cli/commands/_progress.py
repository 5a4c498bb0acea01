"""How far a command is, on stderr."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

PARTS = (
    "turbine_fenicsx.reduction",
    "turbine_fenicsx.turbine.blades",
    "turbine_fenicsx.turbine.components.tower",
    "turbine_fenicsx.turbine.case.turbulence",
)
"""Loggers of the modules that make a basis, or turbulence."""


@contextmanager
def show_making(comm: Any, quiet: bool) -> Iterator[None]:
    """Print a line for each part of a basis or a turbulence while it is made, on one rank.

    Args:
        comm: Communicator.
        quiet: Whether nothing is printed.
    """
    if quiet or comm.rank:
        yield
        return
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("%(message)s"))
    handler.addFilter(lambda record: record.levelno < logging.WARNING)  # others say these
    loggers = [logging.getLogger(name) for name in PARTS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.INFO)
        logger.addHandler(handler)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.removeHandler(handler)
            logger.setLevel(level)


def show_part(comm: Any, quiet: bool) -> Callable[[float], None]:
    """A function that shows on a terminal how much is done."""
    if quiet or comm.rank or not sys.stderr.isatty():
        return lambda part: None

    def show(part: float) -> None:
        end = "" if part < 1.0 else "\n"
        print(f"\r{100.0 * part:3.0f} %", end=end, file=sys.stderr, flush=True)

    return show

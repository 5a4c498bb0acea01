"""Lines on the making of a basis, on stderr."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_PARTS = (
    "turbine_fenicsx.reduction",
    "turbine_fenicsx.turbine.blades",
    "turbine_fenicsx.turbine.components.tower",
)
"""Loggers of the modules that make it."""


@contextmanager
def show_reduction(comm: Any, quiet: bool) -> Iterator[None]:
    """Print a line for each load path of a basis while it is made, on one rank.

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
    loggers = [logging.getLogger(name) for name in _PARTS]
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

"""Lines on what a run makes before its first step, on stderr."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
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

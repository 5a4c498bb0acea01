"""Matplotlib, which need not be there, and its figures as files."""

from __future__ import annotations

import os
import warnings
from typing import Any

from turbine_fenicsx.foundation.errors import InputError


def import_matplotlib() -> tuple[Any, Any]:
    """The module ``matplotlib`` and its class ``Figure``; a clear ImportError without it."""
    try:
        with warnings.catch_warnings():
            # A second Matplotlib, from the system, makes the 3D axes unusable; none are used.
            warnings.filterwarnings("ignore", message="Unable to import Axes3D")
            import matplotlib
            from matplotlib.figure import Figure
    except ImportError:
        raise ImportError("figures need Matplotlib: pip install matplotlib") from None
    return matplotlib, Figure


def save_figure(figure: Any, path: str | os.PathLike[str]) -> None:
    """Write a figure; raises InputError where that is not possible."""
    try:
        figure.savefig(path)
    except OSError as error:
        raise InputError(f"cannot write {os.fspath(path)!r}: {error.strerror or error}") from None

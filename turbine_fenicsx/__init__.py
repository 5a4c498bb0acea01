"""Energy-momentum dynamics of rigid and flexible bodies on FEniCSx, and wind turbines made of them.

The public names stand in ``__init__.pyi`` and are imported on first use, so that the command line
answers immediately.
"""

from __future__ import annotations

import ast
import importlib
from contextlib import suppress
from pathlib import Path
from typing import Any

from turbine_fenicsx._version import __version__ as __version__

with suppress(ImportError):  # DOLFINx from PyPI: its MPI must be there before petsc4py
    import dolfinx_solver  # noqa: F401


_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_PUBLIC = {
    alias.name: node.module
    for node in _STUB.body
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
}
__all__ = sorted(["__version__", *_PUBLIC])


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name not in _PUBLIC:
        from turbine_fenicsx.foundation.text_files import suggest

        hint = "" if name.startswith("_") else suggest(name, _PUBLIC)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{hint}")
    return getattr(importlib.import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    """Public names."""
    return __all__

"""Short lists of names for people who print an object."""

from __future__ import annotations

from collections.abc import Sequence

_MOST = 6
"""Names that a list shows at most."""


def list_names(names: Sequence[str]) -> str:
    """The number of names and the first of them, as in "8: a, b, c, d, e, f and 2 more"."""
    shown = ", ".join(names[:_MOST])
    rest = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return f"{len(names)}: {shown}{rest}"

"""Data that a checkpoint can hold and that come back as they were: no objects, no code."""

from __future__ import annotations

from typing import Any

DEPTH = 32
"""Lists in lists; deeper ones may contain themselves."""

_LARGEST = 2**63


def copy_plain(value: Any, where: str = "", depth: int = 0) -> Any:
    """A copy of numbers, text, None, lists and dictionaries; tuples become lists.

    Args:
        value: The data.
        where: What they are called in the message, as in ``["gains"][0]``.
        depth: How deep they lie.

    Raises:
        TypeError: for anything else; the message says where it is.
    """
    if depth > DEPTH:
        raise TypeError(f"{where} is deeper than {DEPTH} lists, or contains itself")
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        if not -_LARGEST <= value < _LARGEST:
            raise TypeError(f"{where} is an integer beyond 64 bits")
        return int(value)
    if isinstance(value, float):
        return float(value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, (list, tuple)):
        return [copy_plain(v, f"{where}[{k}]", depth + 1) for k, v in enumerate(value)]
    if isinstance(value, dict):
        if wrong := [type(key).__name__ for key in value if not isinstance(key, str)]:
            raise TypeError(f"{where} has a key of type {wrong[0]}, expected text")
        return {str(k): copy_plain(v, f"{where}[{k!r}]", depth + 1) for k, v in value.items()}
    hint = ", use .tolist()" if hasattr(value, "tolist") else ""
    raise TypeError(
        f"{where or 'the result'} is of type {type(value).__name__}{hint}; expected numbers, "
        "text, None, lists or dictionaries"
    )

"""TOML files: read whole, or refused in one sentence."""

from __future__ import annotations

import os
import tomllib
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote, read_text

DEEPEST = 20
"""Tables in tables in tables."""

_TOO_DEEP = "its lists or tables are nested too deeply"


def read_toml(path: str | os.PathLike[str], kind: str) -> dict[str, Any]:
    """Tables of a TOML file, with or without a byte order mark.

    Args:
        kind: What it is to the user, for example "case file".
    """
    text = read_text(path, kind)
    try:
        return parse_toml(text)
    except ValueError as error:
        raise InputError(f"{quote(str(path))} is not valid TOML: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of a TOML text."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    except ValueError:  # Python refuses whole numbers of thousands of digits
        raise ValueError("it holds a number with too many digits") from None
    level: list[Any] = [tables]
    for _ in range(DEEPEST):
        level = [v for t in level if isinstance(t, dict) for v in t.values()]
    if level:  # dotted keys may be of any length
        raise ValueError(_TOO_DEEP)
    return tables


def format_toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(format_toml, value))}]"
    if isinstance(value, float) and abs(value) >= 1e8:
        power = 9 if abs(value) >= 1e9 else 6
        return f"{value / 10**power:.12g}e{power}"
    return f"{value:.12g}"

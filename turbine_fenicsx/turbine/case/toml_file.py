"""TOML files and values from outside: read whole, or refused in one sentence."""

from __future__ import annotations

import os
import stat
import tomllib
from pathlib import Path
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.mistakes import quote

DEEPEST = 20
"""Tables in tables in tables."""

_TOO_DEEP = "its lists or tables are nested too deeply"

LARGEST = 10_000_000
"""Bytes of a file; the cases and studies of this world have a few thousand."""


def read_toml(path: str | os.PathLike[str], kind: str) -> dict[str, Any]:
    """Tables of a TOML file, with or without a byte order mark.

    Args:
        path: The file.
        kind: What it is to the user, for example "case file".

    Raises:
        InputError: with one sentence if it cannot be read or is no TOML.
    """
    name = quote(str(path))
    try:
        status = os.stat(path)
        if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):  # would not end
            raise InputError(f"cannot read the {kind} {name}: it is not a regular file")
        if status.st_size > LARGEST:
            raise InputError(
                f"cannot read the {kind} {name}: it has {status.st_size} bytes, expected at most "
                f"{LARGEST}"
            )
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"cannot read the {kind} {name}: it is not UTF-8 text") from None
    except OSError as error:
        raise InputError(f"cannot read the {kind} {name}: {error.strerror}") from None
    except InputError:
        raise
    except ValueError:  # a null byte, half a character
        raise InputError(f"cannot read the {kind} {name}: its name is not valid") from None
    try:
        return parse_toml(text)
    except ValueError as error:
        raise InputError(f"{name} is not valid TOML: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of a TOML text.

    Raises:
        ValueError: with one sentence if it is none.
    """
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

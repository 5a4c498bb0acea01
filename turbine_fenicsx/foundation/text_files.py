"""Text from outside: files read whole or refused in one sentence, values in a few words."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable
from io import TextIOWrapper
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import open_regular

MAX_SIZE = 10_000_000
"""Bytes of a file; cases and studies have a few thousand, turbines of windIO a million."""


def read_text(path: str | os.PathLike[str], kind: str) -> str:
    """Text of a file in UTF-8, with or without a byte order mark.

    Args:
        kind: What it is to the user, for example "case file".
    """
    name = quote(str(path))
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            if size > MAX_SIZE:
                raise InputError(
                    f"cannot read the {kind} {name}: it has {size} bytes, expected at most "
                    f"{MAX_SIZE}"
                )
            return TextIOWrapper(file, encoding="utf-8-sig").read()
    except UnicodeDecodeError:
        raise InputError(f"cannot read the {kind} {name}: it is not UTF-8 text") from None
    except OSError as error:
        raise InputError(f"cannot read the {kind} {name}: {error.strerror}") from None


def quote(value: Any) -> str:
    """A value as it stands in a sentence, on one line and not too long."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # whole numbers of thousands of digits, endless nesting
        return f"a {type(value).__name__} too large to show"
    return text if len(text) <= 80 else f"{text[:60]}...{text[-10:]}"


def suggest(name: str, known: Iterable[str]) -> str:
    """The end of a sentence about an unknown name: "; did you mean 'NeoHooke'?", or nothing."""
    by_lower = {other.lower(): other for other in known}
    nearest = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return f"; did you mean {by_lower[nearest[0]]!r}?" if nearest else ""

"""Values of a windIO file that know where they stand, so that messages can name it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any, NoReturn

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.foundation.types import Array

MAX_ENTRIES = 1000
"""Entries of a list of tables: layers, anchors, materials; turbines have some twenty."""

MAX_TEXT_LENGTH = 120
"""Characters of a name."""


@dataclass(frozen=True)
class Entry:
    """A value and its place.

    Args:
        value: What was read: a number, text, a list or a dictionary.
    """

    value: Any
    file: str
    place: str = ""

    def fail(self, sentence: str) -> NoReturn:
        """Refuse the value.

        Args:
            sentence: What is wrong, to follow the place.
        """
        raise ModelError(f"{self.file}: {self.place or 'the file'} {sentence}")

    def __contains__(self, key: str) -> bool:
        return isinstance(self.value, dict) and self.value.get(key) is not None

    def __getitem__(self, key: str) -> Entry:
        """The value of a key, which must be there."""
        if not isinstance(self.value, dict):
            self.fail(f"must be a table with the key {key!r}, got {_describe(self.value)}")
        if key not in self:
            self.fail(f"has no {key!r}")
        return Entry(self.value[key], self.file, f"{self.place}.{key}" if self.place else key)

    def get(self, key: str) -> Entry | None:
        """The value of a key, or None."""
        return self[key] if key in self else None

    def entries(self) -> Iterator[Entry]:
        """The tables of a list, which have names."""
        if not isinstance(self.value, list):
            self.fail(f"must be a list, got {_describe(self.value)}")
        if len(self.value) > MAX_ENTRIES:
            self.fail(f"must have at most {MAX_ENTRIES} entries, got {len(self.value)}")
        names: set[str] = set()
        for k, value in enumerate(self.value):
            entry = Entry(value, self.file, f"{self.place}[{k}]")
            name = entry["name"].text()
            if name in names:
                entry.fail(f"is a second one of the name {quote(name)}")
            names.add(name)
            yield Entry(value, self.file, f"{self.place}[{quote(name)}]")

    def text(self) -> str:
        """The value, which must be text."""
        if _is_number(self.value):  # a version, or a name of digits
            return f"{self.value:g}"
        if not isinstance(self.value, str) or not self.value.strip():
            self.fail(f"must be text, got {_describe(self.value)}")
        if len(self.value) > MAX_TEXT_LENGTH or not self.value.isprintable():
            self.fail(
                f"must be at most {MAX_TEXT_LENGTH} characters on one line, got {quote(self.value)}"
            )
        return self.value

    def number(self, least: float = -inf, most: float = inf) -> float:
        """The value, which must be a finite number between two others."""
        if not _is_number(self.value):
            self.fail(f"must be a finite number, got {_describe(self.value)}")
        if not least <= self.value <= most:
            where = f"between {least:g} and {most:g}" if most < inf else f"at or above {least:g}"
            self.fail(f"must lie {where}, got {self.value:g}")
        return float(self.value)

    def positive(self) -> float:
        """The value, which must be a positive number."""
        value = self.number()
        if value <= 0.0:
            self.fail(f"must be positive, got {value:g}")
        return value

    def numbers(self, size: int | None = None) -> Array:
        """The values of a list of finite numbers, (n,).

        Args:
            size: How many there must be; any number by default.
        """
        if not isinstance(self.value, list):
            self.fail(f"must be a list of numbers, got {_describe(self.value)}")
        for k, value in enumerate(self.value):
            if not _is_number(value):
                self.fail(f"must hold finite numbers, number {k + 1} is {_describe(value)}")
        if size is not None and len(self.value) != size:
            self.fail(f"must hold {size} numbers, got {len(self.value)}")
        return np.array(self.value, float)


def _is_number(value: Any) -> bool:
    return isinstance(value, float) and isfinite(value)


def _describe(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "a table"
    return quote(value)

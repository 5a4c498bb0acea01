"""Text files of OpenFAST and HAWC2: a value before its key, tables of numbers, remarks."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.files import name_file_in_errors, open_regular
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.foundation.types import Array

MAX_SIZE = 10_000_000
"""Maximum size of a file [bytes]."""

LARGEST = 1e30
"""Largest number of a file: its square and cube are finite."""

_REMARK = re.compile(r"[!#%;].*")
"""Start of a remark in files of OpenFAST and HAWC2, up to the end of the line."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?$|[+-]?(nan|inf|infinity)$", re.I)
"""A number of Fortran, with D for the exponent of double precision."""

_VALUE = re.compile(r"\s*(\"[^\"]*\"|'[^']*'|[^\s,]+)[\s,]+([^\s,]+)")


@dataclass(frozen=True)
class KeyedText:
    """A file of AeroDyn 15, or of another program."""

    path: str
    lines: list[str]
    what: str = "AeroDyn 15"

    @classmethod
    def read(cls, path: str | os.PathLike[str], what: str = "AeroDyn 15") -> KeyedText:
        """The lines of a file of at most `MAX_SIZE` bytes."""
        with name_file_in_errors("read", path), open_regular(path) as file:
            content = file.read(MAX_SIZE + 1)
        if len(content) > MAX_SIZE:
            most = MAX_SIZE // 1_000_000
            raise InputError(f"{os.fspath(path)} is larger than {most} MB, so no table")
        text = content.decode("utf-8", errors="replace")
        return cls(os.fspath(path), text.splitlines(), what)

    def fail(self, line: int, sentence: str) -> NoReturn:
        """Refuse a line, by its index."""
        raise InputError(f"{self.path}, line {line + 1}: {sentence}")

    def find(self, key: str) -> tuple[str, int] | None:
        """The value before a key, without quotes, and the index of its line; None without it."""
        for k, line in enumerate(self.lines):
            match = _VALUE.match(line)
            if match and match[2].lower() == key.lower():
                return match[1].strip("\"'"), k
        return None

    def find_count(self, key: str) -> tuple[int, int]:
        """The number of rows before a key, and the index of the line after it."""
        found = self.find(key)
        if found is None:
            raise InputError(f"{self.path} is no file of {self.what}: it has no {key}")
        text, k = found
        digits = text.isdecimal() and len(text) < 10
        if not digits or not 0 < int(text) <= len(self.lines):
            self.fail(k, f"{key} must be a number of rows that the file has, got {text[:40]!r}")
        return int(text), k + 1

    def read_numbers(self, line: int, count: int) -> list[float]:
        """The first numbers of a line, by its index."""
        words = _REMARK.sub("", self.lines[line]).replace(",", " ").split()
        numbers = _read_numbers(words)[:count]
        if len(numbers) < count or not all(abs(x) <= LARGEST for x in numbers):
            wanted = "a number" if count == 1 else f"{count} numbers"
            self.fail(line, f"expected {wanted}, got {quote(self.lines[line].strip())}")
        return numbers

    def read_table(self, first: int, count: int, least: int) -> Array:
        """A table of numbers; headers, empty lines and remarks are passed over.

        Args:
            first: Index of the first line that may belong to it.
            count: Number of rows.
            least: Minimum number of columns.

        Returns:
            Shape (count, columns), with as many columns as the first row.
        """
        rows: list[list[float]] = []
        for k in range(first, len(self.lines)):
            line = _REMARK.sub("", self.lines[k]).replace(",", " ")
            words = line.split()
            numbers = _read_numbers(words)
            if not words or (not rows and not numbers):
                continue  # an empty line, or a header
            needed = len(rows[0]) if rows else least
            if len(numbers) < needed:
                self.fail(
                    k,
                    f"a row of its table is wrong: expected {needed} numbers, got "
                    f"{quote(self.lines[k].strip())}",
                )
            if not all(abs(x) <= LARGEST for x in numbers):
                self.fail(k, f"the row has numbers that are not finite, or beyond {LARGEST:g}")
            rows.append(numbers)
            if len(rows) == count:
                break
        if len(rows) < count:
            raise InputError(
                f"{self.path}: its table must have {count} rows of at least {least} numbers, got "
                f"{len(rows)}"
            )
        return np.array([row[: len(rows[0])] for row in rows])


def _read_numbers(words: list[str]) -> list[float]:
    """The numbers at the beginning of a row; what follows them is a remark."""
    numbers = []
    for word in words:
        if not _NUMBER.match(word):
            break
        numbers.append(float(word.lower().replace("d", "e")))
    return numbers

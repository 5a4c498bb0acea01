"""The commands of htc files of HAWC2, and the files that they name.

HAWC2 runs in a folder above the htc file, mostly the next one, and names all files from there,
without regard to upper and lower case.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from turbine_fenicsx.foundation.keyed_text import LARGEST, KeyedText
from turbine_fenicsx.foundation.types import Array

ABOVE = 4
"""Folders above an htc file in which its files are sought."""

MOST = 50
"""Largest number of files that continue each other."""


@dataclass(frozen=True)
class Command:
    """A command of an htc file.

    Args:
        text: Its file.
        line: Index of its line.
        words: Its name in lower case, then its values.
    """

    text: KeyedText
    line: int
    words: tuple[str, ...]

    @property
    def name(self) -> str:
        """The first word."""
        return self.words[0]

    def fail(self, sentence: str) -> NoReturn:
        """Refuse the command with its file and line."""
        self.text.fail(self.line, sentence)

    def value(self, k: int = 1) -> str:
        """A value, counted from 1; empty if there is none."""
        return self.words[k] if k < len(self.words) else ""

    def whole(self, k: int) -> int:
        """A value that is a whole number."""
        if not re.fullmatch(r"\d{1,6}", self.value(k)):
            self.fail(f"expected a whole number, got {self.value(k)!r}")
        return int(self.value(k))

    def numbers(self, first: int, count: int) -> Array:
        """Some values that are numbers."""
        try:
            found = np.array([float(word) for word in self.words[first : first + count]])
        except ValueError:
            found = np.zeros(0)
        if len(found) < count or not np.all(np.abs(found) <= LARGEST):
            self.fail(f"expected {count} numbers, got {' '.join(self.words)!r}")
        return found


def read_commands(htc: Path) -> Iterator[Command]:
    """The commands of an htc file and of those that continue it, in their order.

    Raises:
        InputError: if more than `MOST` files continue each other.
        FileError: if a file cannot be read.
    """
    return _read_commands(htc, htc, [])


def _read_commands(path: Path, htc: Path, opened: list[Path]) -> Iterator[Command]:
    """The commands of a file that continues an htc file, after those that were opened before."""
    text = KeyedText.read(path, "HAWC2")
    opened.append(path)
    for k, line in enumerate(text.lines):
        words = line.split(";")[0].split()
        if not words:
            continue
        command = Command(text, k, (words[0].lower(), *words[1:]))
        if command.name == "exit":
            return
        if command.name != "continue_in_file":
            yield command
        elif len(opened) == MOST:
            command.fail(f"more than {MOST} files continue each other")
        else:
            yield from _read_commands(find_file(htc, command.value()), htc, opened)


def find_file(htc: Path, name: str) -> Path:
    """A file that an htc file names: as the name says if there is none."""
    parts = Path(name.replace("\\", "/")).parts
    places = [htc.parent, *htc.absolute().parents[1 : ABOVE + 1]]
    found = (_match(place, parts) for place in places)
    return next((path for path in found if path is not None), htc.parent.joinpath(*parts))


def _match(place: Path, parts: tuple[str, ...]) -> Path | None:
    """A file from a folder, without regard to upper and lower case."""
    for part in parts:
        exact = place / part
        if exact.exists():
            place = exact
            continue
        alike = [child for child in _list(place) if child.name.lower() == part.lower()]
        if not alike:
            return None
        place = min(alike)
    return place if place.is_file() else None


def _list(folder: Path) -> list[Path]:
    """Files and folders in a folder, none if it cannot be read."""
    try:
        return list(folder.iterdir())
    except OSError:
        return []

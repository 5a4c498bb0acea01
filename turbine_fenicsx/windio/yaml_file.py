"""YAML files that include others: `key: !include other.yaml`, relative to the file that has it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote, read_text
from turbine_fenicsx.windio.yaml_text import YamlError, list_includes, parse_counted

MAX_FILES = 50
"""Files that a file may include, by itself or through others."""

DEEPEST = 5
"""Files that include one another in a row."""

_ENDS = (".yaml", ".yml")


def read_yaml(path: str | os.PathLike[str]) -> Any:
    """Numbers, text, lists and dictionaries of a windIO file and the files that it includes."""
    return _Files().parse(Path(os.path.abspath(path)))[0]


def list_included(path: str | os.PathLike[str]) -> list[str]:
    """The files that a file includes, by itself or through others, those that exist.

    Files that are not valid include nothing: whoever reads them says what is wrong.
    """
    found = [os.path.abspath(path)]
    for file in found:  # which grows
        try:
            names = list_includes(read_text(file, "windIO file"))
        except (InputError, YamlError):
            continue
        for name in names:
            other = os.path.abspath(Path(file).parent / name)
            if other not in found and len(found) <= MAX_FILES and os.path.exists(other):
                found.append(other)
    return found[1:]


class _Files:
    """Included files, each of which is parsed once, with its number of values."""

    def __init__(self) -> None:
        self._open: list[Path] = []
        self._parsed: dict[Path, tuple[Any, int]] = {}

    def parse(self, path: Path) -> tuple[Any, int]:
        """The contents of a file, which may be an included one."""
        if path not in self._parsed:
            if len(self._parsed) + len(self._open) > MAX_FILES:
                raise YamlError(f"is one of more than {MAX_FILES} included files")
            if len(self._open) > DEEPEST:
                raise YamlError(f"is included through more than {DEEPEST} files")
            self._open.append(path)
            text = read_text(path, "included file" if len(self._open) > 1 else "windIO file")
            self._parsed[path] = parse_counted(text, lambda name: self._include(path.parent, name))
            self._open.pop()
        return self._parsed[path]

    def _include(self, folder: Path, name: str) -> tuple[Any, int]:
        path = Path(os.path.abspath(folder / name))
        if path.suffix.lower() not in _ENDS:
            raise YamlError(f"includes {quote(name)}, expected a file in .yaml")
        if path in self._open:
            raise YamlError(f"includes {quote(name)}, of which it is part")
        try:
            return self.parse(path)
        except YamlError as error:
            raise YamlError(f"includes {quote(name)}, which {error}") from None

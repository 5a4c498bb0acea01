"""Case files: one TOML file describes one run."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from turbine_fenicsx.case.files import place_files
from turbine_fenicsx.case.mistakes import Key, Mistake, find_mistakes, remove_keys
from turbine_fenicsx.case.toml_file import parse_toml, read_toml
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.case.consistency import describe_unused_keys, find_contradictions
from turbine_fenicsx.turbine.case.turbine_file import FILE, add_file, find_file
from turbine_fenicsx.turbine.case.warnings import find_warnings
from turbine_fenicsx.turbine.tables.event import name_events
from turbine_fenicsx.turbine.tables.tables import Tables


class Case(Tables):
    """One run."""

    @staticmethod
    def load(path: str | os.PathLike[str], overrides: Iterable[str] = ()) -> Case:
        """Read a case file.

        Args:
            path: TOML file.
            overrides: Changes such as ``"time.end=1.0"``.

        Returns:
            The case; the files that it names are made relative to the case file.

        Raises:
            InputError: with one sentence for every mistake.
        """
        return Draft.load(path, overrides).require_valid()

    @staticmethod
    def parse(data: Mapping[str, Any], folder: str | os.PathLike[str] | None = ".") -> Case:
        """Make a case from nested tables.

        Args:
            data: The tables.
            folder: Where ``turbine.file`` is looked for; None leaves it unread, for tables that
                are complete.

        Raises:
            InputError: with one sentence for every mistake.
        """
        return Draft.parse(data, folder).require_valid()

    @property
    def warnings(self) -> list[str]:
        """One sentence for every key that is set but has no effect, and for every likely slip."""
        return [*describe_unused_keys(self), *find_warnings(self)]


@dataclass(frozen=True)
class Draft:
    """A case that may hold mistakes.

    Args:
        case: The case, with defaults in the place of what is wrong.
        mistakes: All mistakes.
    """

    case: Case
    mistakes: tuple[Mistake, ...]

    @property
    def tables(self) -> set[str]:
        """The outermost tables that hold mistakes."""
        return {mistake.key[0] if mistake.key else "" for mistake in self.mistakes}

    def require_valid(self) -> Case:
        """The case, or an InputError with one sentence for every mistake."""
        if self.mistakes:
            raise InputError("\n".join(dict.fromkeys(m.sentence for m in self.mistakes)))
        return self.case

    @staticmethod
    def load(path: str | os.PathLike[str], overrides: Iterable[str] = ()) -> Draft:
        """Read a case file, see `Case.load`.

        Raises:
            InputError: if the file cannot be read or is no TOML.
        """
        data = name_events(read_toml(path, "case file"))
        found = []
        for override in overrides:
            try:
                _apply_override(data, override)
            except InputError as error:
                found.append(Mistake((), str(error)))
        data = place_files(data, Tables, Path(path).parent)
        draft = Draft.parse(data, Path(path).parent)
        return Draft(draft.case, (*found, *draft.mistakes, *_mesh_file(draft.case)))

    @staticmethod
    def parse(data: Mapping[str, Any], folder: str | os.PathLike[str] | None = ".") -> Draft:
        """Make a draft from nested tables, see `Case.parse`."""
        found: list[Mistake] = []
        file: list[Mistake] = []
        data = name_events(data)
        if find_file(data) is not None and folder is not None:
            try:
                data = add_file(data, folder)
            except InputError as error:
                file = [Mistake(FILE, f"turbine.file: {line}") for line in str(error).splitlines()]
                data = remove_keys(data, {FILE})
        try:
            case = Case.model_validate(data)
        except ValidationError as error:
            found = find_mistakes(error, data, Tables)
            wrong = {mistake.key for mistake in found}
            case = Case() if () in wrong else Case.model_validate(remove_keys(data, wrong))
        unread = {FILE} if file or folder is None else set()
        wrong = {mistake.key for mistake in found} | unread
        return Draft(case, (*file, *found, *find_contradictions(case, wrong)))


def apply_overrides(data: Mapping[str, Any], overrides: Iterable[str]) -> Case:
    """A case from nested tables with changes such as ``"time.end=1.0"``.

    Raises:
        InputError: with one sentence for every mistake.
    """
    tables = name_events(copy.deepcopy(dict(data)))
    for override in overrides:
        _apply_override(tables, override)
    return Case.parse(tables)


def _apply_override(data: dict[str, Any], override: str) -> None:
    """Apply one ``key=value`` to nested tables."""
    key, separator, text = override.partition("=")
    names = [name.strip() for name in key.split(".")]
    if not separator or not all(names):
        raise InputError(f"cannot read {quote(override)}: write --set section.key=value")
    try:
        tables = parse_toml(f"value = {text}")
        value = tables["value"] if len(tables) == 1 else text.strip()
    except ValueError:
        value = text.strip()
    table = data
    for name in names[:-1]:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise InputError(f"cannot set {quote(key.strip())}: {quote(name)} is not a table")
    table[names[-1]] = value


def _mesh_file(case: Case) -> list[Mistake]:
    """Mistakes that a first look at the mesh file shows."""
    if case.mesh.file is None or case.turbine.model == "rigid":
        return []
    from turbine_fenicsx.meshing import MeshError
    from turbine_fenicsx.meshing.read import check_header

    try:
        check_header(Path(case.mesh.file))
    except MeshError as error:
        key: Key = ("mesh", "file")
        return [Mistake(key, f"mesh.file: {error}")]
    return []

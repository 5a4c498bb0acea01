"""Case files: one TOML file describes one run."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import PrivateAttr, ValidationError

from turbine_fenicsx.case.contradictions import find_contradictions, list_checks
from turbine_fenicsx.case.files import Nested, place_files
from turbine_fenicsx.case.implausible_keys import find_implausible_keys
from turbine_fenicsx.case.mistakes import Mistake, find_mistakes, remove_keys
from turbine_fenicsx.case.rules import find_unused_keys, walk_sections
from turbine_fenicsx.case.section import Section
from turbine_fenicsx.case.toml_file import parse_toml, read_toml
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.turbine.case.beam_checks import BEAM_CHECKS
from turbine_fenicsx.turbine.case.file_doubts import doubt_files
from turbine_fenicsx.turbine.case.turbine_file import (
    FILE,
    TURBINE_CHECKS,
    add_file,
    list_origins,
)
from turbine_fenicsx.turbine.case.wind_checks import WIND_CHECKS
from turbine_fenicsx.turbine.tables.event import name_events
from turbine_fenicsx.turbine.tables.tables import Tables


class Case(Tables):
    """One run."""

    _folder: Path | None = PrivateAttr(default=None)

    @property
    def folder(self) -> Path | None:
        """Folder of the case file; None for a case from elsewhere."""
        return self._folder

    def __eq__(self, other: object) -> bool:
        """Whether all keys are equal, wherever the case files are."""
        names = type(self).model_fields
        return isinstance(other, Case) and all(getattr(self, x) == getattr(other, x) for x in names)

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
    def parse(data: Nested, folder: str | os.PathLike[str] | None = ".") -> Case:
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
        unused = [f"{k.name} has no effect {k.reason}" for k in find_unused_keys(self) if k.is_set]
        sections = (table for _, table in walk_sections(self) if isinstance(table, Section))
        doubts = [sentence for table in sections for sentence in table.find_doubts(self)]
        sizes = find_implausible_keys(self, list_origins(self)[0])
        return [*unused, *doubts, *sizes, *doubt_files(self)]


@dataclass(frozen=True)
class Draft:
    """A case that may hold mistakes.

    Args:
        case: The case, with defaults in the place of what is wrong.
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
        """Read a case file, see `Case.load`."""
        folder = Path(path).parent
        data = name_events(read_toml(path, "case file"))
        data, refused = _override(data, overrides)
        data = place_files(data, Tables, folder)
        draft = Draft.parse(data, folder)
        draft.case._folder = folder
        return Draft(draft.case, (*refused, *draft.mistakes, *_look_at_mesh(draft.case)))

    @staticmethod
    def parse(data: Nested, folder: str | os.PathLike[str] | None = ".") -> Draft:
        """Make a draft from nested tables, see `Case.parse`."""
        data = name_events(data)
        data, unread = (data, []) if folder is None else _add_file(data, folder)
        case, wrong = _validate(data)
        keys = {mistake.key for mistake in wrong}
        if unread or folder is None:
            keys.add(FILE)
        checks = (*list_checks(case), *TURBINE_CHECKS, *BEAM_CHECKS, *WIND_CHECKS)
        return Draft(case, (*unread, *wrong, *find_contradictions(case, checks, keys)))


def apply_overrides(data: Nested, overrides: Iterable[str]) -> Case:
    """A case from nested tables with changes such as ``"time.end=1.0"``."""
    tables, refused = _override(name_events(data), overrides)
    if refused:
        raise InputError(refused[0].sentence)
    return Case.parse(tables)


def _override(data: Nested, overrides: Iterable[str]) -> tuple[dict[str, Any], list[Mistake]]:
    """Nested tables with changes, and the mistakes in these."""
    changed, refused = copy.deepcopy(dict(data)), []
    for override in overrides:
        try:
            _set_key(changed, override)
        except InputError as error:
            refused.append(Mistake((), str(error)))
    return changed, refused


def _set_key(data: dict[str, Any], override: str) -> None:
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


def _add_file(data: Nested, folder: str | os.PathLike[str]) -> tuple[Nested, list[Mistake]]:
    """Nested tables with those of ``turbine.file`` below them, or mistakes of that file."""
    try:
        return add_file(data, folder), []
    except InputError as error:
        lines = str(error).splitlines()
    return remove_keys(data, {FILE}), [Mistake(FILE, f"turbine.file: {line}") for line in lines]


def _validate(data: Nested) -> tuple[Case, list[Mistake]]:
    """The case of nested tables, with defaults in the place of what is wrong, and what is."""
    try:
        return Case.model_validate(data), []
    except ValidationError as error:
        found = find_mistakes(error, data, Tables)
    wrong = {mistake.key for mistake in found}
    return Case() if () in wrong else Case.model_validate(remove_keys(data, wrong)), found


def _look_at_mesh(case: Case) -> list[Mistake]:
    """Mistakes that a first look at the mesh file shows."""
    if case.mesh.file is None or case.turbine.model == "rigid":
        return []
    from turbine_fenicsx.meshing import MeshError
    from turbine_fenicsx.meshing.read import check_header

    try:
        check_header(Path(case.mesh.file))
    except MeshError as error:
        return [Mistake(("mesh", "file"), f"mesh.file: {error}")]
    return []

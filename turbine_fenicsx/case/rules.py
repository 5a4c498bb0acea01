"""When a key counts, as marks in its type, such as ``Annotated[Metres, Only("drive", "spring")]``.

A key that is set but does not count is worth a warning, no more: cases are varied with
``--set turbine.model=rigid``, and a file may hold the constants of two materials. A key that must
not be set beside another is a mistake, see `NotBeside`.

Names without a dot are keys of the same table, others are dotted from the outermost table on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from turbine_fenicsx.case.mistakes import remove_keys
from turbine_fenicsx.case.toml_file import format_toml
from turbine_fenicsx.foundation.text_files import quote


def resolve(key: str, table: str) -> str:
    """The dotted name of a key as a rule or check of a table names it."""
    return key if "." in key or not table else f"{table}.{key}"


def find_value(case: BaseModel, key: str) -> Any:
    """Value of a dotted key; tables with names of the user's own are dictionaries."""
    found: Any = case
    for name in filter(None, key.split(".")):
        found = found[name] if isinstance(found, dict) else getattr(found, name)
    return found


class Rule:
    """Says when a key counts."""

    keys: tuple[str, ...] = ()
    """The keys it looks at, which a rule of a whole table leaves out."""

    def explain(self, case: Any, table: str) -> str:
        """Why the key does not count, such as 'with pitch.drive = "free"'; empty if it does.

        Args:
            table: Name of the table of the key.
        """
        raise NotImplementedError


class Only(Rule):
    """The key counts only if another has one of some values."""

    def __init__(self, key: str, *values: Any, say: str = "") -> None:
        self.keys, self._values, self._say = (key,), values, say

    def explain(self, case: Any, table: str) -> str:
        """The value that the other key has instead."""
        key = resolve(self.keys[0], table)
        value = find_value(case, key)
        if value in self._values:
            return ""
        without = f"without {key} = true" if self._values == (True,) else ""
        return self._say or without or f"with {key} = {format_toml(value)}"


class Unless(Only):
    """The key has no effect if another key has one of these values."""

    def explain(self, case: Any, table: str) -> str:
        """The value of the other key."""
        key = resolve(self.keys[0], table)
        value = find_value(case, key)
        return (self._say or f"with {key} = {format_toml(value)}") if value in self._values else ""


class With(Rule):
    """The key counts only if one of some others is given."""

    def __init__(self, *keys: str) -> None:
        self.keys = keys

    def explain(self, case: Any, table: str) -> str:
        """The keys of which none is given."""
        keys = [resolve(key, table) for key in self.keys]
        given = any(find_value(case, key) is not None for key in keys)
        return "" if given else f"without {' or '.join(keys)}"


class Beside(Rule):
    """The key does not count if another is given."""

    def __init__(self, key: str, say: str = "") -> None:
        self.keys, self._say = (key,), say

    def explain(self, case: Any, table: str) -> str:
        """The key that is given."""
        key = resolve(self.keys[0], table)
        return "" if find_value(case, key) is None else self._say or f"beside {key}"


class NotBeside(Beside):
    """The key must not be set if another is given, which names a file.

    Args:
        why: What the file has, for example "which has the shape of the blades".
    """

    def __init__(self, key: str, why: str) -> None:
        super().__init__(key)
        self._why = why

    def refuse(self, case: Any, table: str, key: str) -> str:
        """A sentence if the key is set beside the other; else nothing."""
        section, (other,) = find_value(case, table), self.keys
        if key not in section.model_fields_set or not self.explain(case, table):
            return ""
        file = quote(Path(find_value(case, other)).name)
        value = quote(getattr(section, key))
        return f"{table}.{key} = {value}: expected none beside {other} = {file}, {self._why}"


class AnyOf(Rule):
    """The key counts if it does by one of several rules."""

    def __init__(self, *rules: Rule, say: str = "") -> None:
        self.keys = tuple(key for rule in rules for key in rule.keys)
        self._rules, self._say = rules, say

    def explain(self, case: Any, table: str) -> str:
        """The reason of the first rule, if the key counts by none."""
        reasons = [rule.explain(case, table) for rule in self._rules]
        return (self._say or reasons[0]) if all(reasons) else ""


class If(Rule):
    """The key counts if a function of the case says so."""

    def __init__(self, counts: Callable[[Any], bool], say: str) -> None:
        self._counts, self._say = counts, say

    def explain(self, case: Any, table: str) -> str:
        """The reason as it was given."""
        return "" if self._counts(case) else self._say


@dataclass(frozen=True)
class UnusedKey:
    """A key, or a table, that does not count."""

    name: str
    reason: str
    is_set: bool


def walk_sections(section: BaseModel, name: str = "") -> Iterator[tuple[str, BaseModel]]:
    """A table and those inside it with their dotted names, in their order."""
    yield name, section
    for key in type(section).model_fields:
        for inner, table in _list_tables(section, name, key):
            yield from walk_sections(table, inner)


def _list_tables(section: BaseModel, name: str, key: str) -> Iterator[tuple[str, BaseModel]]:
    """The table of a key, or those with names of the user's own; none for other values."""
    value, dotted = getattr(section, key), resolve(key, name)
    tables = value if isinstance(value, dict) else {"": value}
    for own, table in tables.items():
        if isinstance(table, BaseModel):
            yield f"{dotted}.{own}".rstrip("."), table


def find_name(case: BaseModel, section: BaseModel) -> str:
    """Dotted name of a table of a case."""
    return next(name for name, table in walk_sections(case) if table is section)


def list_exclusions(case: BaseModel) -> Iterator[tuple[str, str, NotBeside]]:
    """Keys that must not be set beside others: the table, the key in it, and its mark."""
    for name, section in walk_sections(case):
        for key, field in type(section).model_fields.items():
            for mark in field.metadata:
                if isinstance(mark, NotBeside):
                    yield name, key, mark


def remove_refused_keys(case: BaseModel, data: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a case without the keys that must not be set, which are there as defaults."""
    refused = (
        resolve(key, name) for name, key, mark in list_exclusions(case) if mark.explain(case, name)
    )
    return remove_keys(data, {tuple(name.split(".")) for name in refused})


def find_unused_keys(
    case: BaseModel, section: BaseModel | None = None, name: str = ""
) -> Iterator[UnusedKey]:
    """Keys of a valid case that do not count, in their order.

    Args:
        section: The table in which they are looked for, and in those inside it; the case if None.
    """
    section = case if section is None else section
    whole: tuple[Rule, ...] = getattr(section, "rules", ())
    for key, field in type(section).model_fields.items():
        own = resolve(key, name)
        rules = [r for r in whole if own not in (resolve(other, name) for other in r.keys)]
        rules += [mark for mark in field.metadata if isinstance(mark, Rule)]
        reason = next(filter(None, (rule.explain(case, name) for rule in rules)), "")
        if reason:
            yield UnusedKey(own, reason, key in section.model_fields_set)
            continue
        for inner, table in _list_tables(section, name, key):
            yield from find_unused_keys(case, table, inner)

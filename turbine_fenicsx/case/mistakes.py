"""Mistakes in a case file, one sentence each: key, value, what is expected, nearest valid key."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote

Key = tuple[str, ...]
"""Names of the tables and of the key, from the outside in."""


@dataclass(frozen=True)
class Mistake:
    """A mistake.

    Args:
        key: The key, or the table if its value is not a table; empty for the whole case.
    """

    key: Key
    sentence: str


_WORDS = (
    (r"^Value error, ", ""),
    (r"[Ii]nput should( be)?", r"must\1"),
    (r"[Ff]ield required", "needs more entries"),
    (r"a valid tuple", "a list"),
    (r"a valid dictionary( or instance of \w+)?", "a table"),
    (r"a valid string", "text in quotes"),
    (r"a valid boolean", "true or false"),
    (r"a valid (?=integer)", "an "),
)
"""Pydantic's words for mistakes and ours."""

_SIMILAR = 0.7
"""Names at least as similar as this are suggested, those in the same table from 0.1 less on."""


Model = TypeVar("Model", bound=BaseModel)


def validate(model: type[Model], data: Any) -> Model:
    """A model of nested tables, or an InputError with one sentence for every mistake."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        sentences = [mistake.sentence for mistake in find_mistakes(error, data, model)]
        raise InputError("\n".join(sentences)) from None


def find_mistakes(error: ValidationError, data: Any, tables: type[BaseModel]) -> list[Mistake]:
    """Mistakes that pydantic found."""
    found: dict[tuple[Key, bool], Mistake] = {}
    for item in error.errors(include_url=False):
        names = tuple(str(name) for name in item["loc"])
        if item["type"] == "extra_forbidden":
            for key in _unknown_keys(names, item["input"], tables):
                text = f"unknown key {quote('.'.join(key))}{_find_hint(key, tables)}"
                found[key, True] = Mistake(names, text)
            continue
        if item["type"] == "missing":
            names = names[:-1]  # a list that is too short
        # A union adds the name of the member that failed to the location.
        names = tuple(n for n in names if n.isidentifier() or n.isdecimal())
        message = item["msg"]
        for theirs, ours in _WORDS:
            message = re.sub(theirs, ours, message)
        value = item["input"]
        text = "" if isinstance(value, dict | BaseModel) else f" = {quote(value)}"
        sentence = f"{'.'.join(names) or 'the case'}{text}: {message}"
        found.setdefault((names, False), Mistake(_key_of(names, data), sentence))
    return list(found.values())


def remove_keys(data: Any, keys: set[Key]) -> dict[str, Any]:
    """A copy of nested tables without some keys."""
    return {
        name: remove_keys(value, {key[1:] for key in keys if key[0] == name})
        if isinstance(value, dict)
        else value
        for name, value in data.items()
        if (str(name),) not in keys
    }


def _key_of(names: Key, data: Any) -> Key:
    """The part of a location that consists of keys of tables."""
    key: list[str] = []
    for name in names:
        if not isinstance(data, dict):
            break
        key.append(name)
        data = data.get(name)
    return tuple(key)


def _unknown_keys(names: Key, value: Any, tables: type[BaseModel]) -> list[Key]:
    """The keys to talk about: those inside of an unknown table unless its name is only misspelt."""
    if not isinstance(value, dict) or not value or _is_misspelt(names, set(value), tables):
        return [names]
    return [(*names, str(name)) for name in value]


def _is_misspelt(key: Key, keys: set[Any], tables: type[BaseModel]) -> bool:
    """Whether a known table has a similar name, and one of the keys."""
    nearest, likeness = _find_nearest(key, tables)
    inside: Any = tables
    for name in nearest:
        inside = _step_into(inside, name)
    return likeness >= _SIMILAR and bool(keys & set(getattr(inside, "model_fields", keys)))


def _find_nearest(key: Key, tables: type[BaseModel]) -> tuple[Key, float]:
    """The valid key, in any table, that is nearest to an unknown one, and how near it is."""

    def likeness(other: Key) -> float:
        same_table = 0.1 if other[:-1] == key[:-1] else 0.0
        return difflib.SequenceMatcher(None, key[-1].lower(), other[-1]).ratio() + same_table

    nearest = max(_known_keys(tables, key), key=likeness)
    return nearest, likeness(nearest)


def _find_hint(key: Key, tables: type[BaseModel]) -> str:
    """Hint at the valid key, in any table, that is nearest to an unknown one."""
    inside: Any = tables
    for name in key[:-1]:
        inside = _step_into(inside, name)
    if new := getattr(inside, "renamed", {}).get(key[-1]):
        return f"; it is called {'.'.join((*key[:-1], new))!r} now"
    nearest, likeness = _find_nearest(key, tables)
    if likeness >= _SIMILAR:
        return f"; did you mean {'.'.join(nearest)!r}?"
    fields = getattr(inside, "model_fields", None)
    if fields is None:
        return f"; there is no table {quote('.'.join(key[:-1]))}"
    where = f"[{'.'.join(key[:-1])}]" if key[:-1] else "a case file"
    return f"; {where} takes {', '.join(sorted(fields))}"


def _step_into(kind: Any, name: str) -> Any:
    """Type of what has a name in a table, or in a table of the user's names; None if unknown."""
    if get_origin(kind) is dict:
        return get_args(kind)[1]
    field = getattr(kind, "model_fields", {}).get(name)
    return field.annotation if field else None


def _known_keys(model: Any, near: Key, above: Key = ()) -> Iterator[Key]:
    """All valid keys, tables included; with names of the user's own only those near a key."""
    for name, field in model.model_fields.items():
        yield (*above, name)
        kind, place = field.annotation, (*above, name)
        if get_origin(kind) is dict and near[: len(place)] == place and len(near) > len(place):
            kind, place = get_args(kind)[1], near[: len(place) + 1]
        if hasattr(kind, "model_fields"):
            yield from _known_keys(kind, near, place)

"""Checks of keys against each other, which stand beside the keys in the classes of the tables.

A check is a method of a table that gets the whole case and returns a sentence, or nothing; its
decorator `check` names the keys that it looks at, the guilty one first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from operator import eq
from typing import Any, TypeVar

from pydantic import BaseModel

from turbine_fenicsx.case.mistakes import Key, Mistake
from turbine_fenicsx.case.rules import list_exclusions, resolve, walk_sections

Method = TypeVar("Method", bound=Callable[..., str])


@dataclass(frozen=True)
class Check:
    """A check of keys against each other.

    Args:
        keys: Dotted names of the keys that it looks at, the guilty one first.
        find: Returns a sentence, or nothing, for a case.
    """

    keys: tuple[str, ...]
    find: Callable[[Any], str]


def check(*keys: str) -> Callable[[Method], Method]:
    """Decorator of methods of a table that are checks.

    Args:
        keys: Keys that it looks at, the guilty one first. Names of keys of the table stand for
            these, others are dotted from the outermost table on; an empty one is the table itself.
    """

    def mark(method: Method) -> Method:
        method.checked_keys = keys  # type: ignore[attr-defined]
        return method

    return mark


def list_checks(case: BaseModel) -> Iterator[Check]:
    """Checks of all tables of a case: keys that exclude each other, then the methods."""
    for name, key, mark in list_exclusions(case):
        keys = (resolve(key, name), *mark.keys)
        yield Check(keys, partial(mark.refuse, table=name, key=key))
    for name, section in walk_sections(case):
        for method in _list_methods(type(section)):
            own = (_find_name(key, name, section) for key in method.checked_keys)
            yield Check(tuple(own), method.__get__(section))


def _list_methods(model: type) -> Iterator[Any]:
    """The checks of a table in their order, those of its base classes first."""
    for owner in reversed(model.__mro__[: model.__mro__.index(BaseModel)]):
        yield from (method for method in vars(owner).values() if hasattr(method, "checked_keys"))


def _find_name(key: str, table: str, section: BaseModel) -> str:
    """Dotted name of a key as a check of a table names it."""
    if not key:
        return table
    return resolve(key, table) if key in type(section).model_fields else key


def find_contradictions(
    case: BaseModel, checks: Iterable[Check], wrong: set[Key]
) -> Iterator[Mistake]:
    """Mistakes that take more than one key to see.

    Args:
        case: The tables, with defaults in the place of what is wrong by itself.
        wrong: The keys that are wrong by themselves; nothing is said that depends on them.
    """
    for each in checks:
        keys = [tuple(name.split(".")) for name in each.keys]
        # one key is, or is inside of, the other
        if any(all(map(eq, key, bad)) for key in keys for bad in wrong):
            continue
        sentence = each.find(case)
        if sentence:
            yield Mistake(keys[0], sentence)
            wrong = wrong | {keys[0]}

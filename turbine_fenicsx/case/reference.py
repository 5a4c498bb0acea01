"""The keys of a model as tables to read: units, defaults, what is allowed, what they mean."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from turbine_fenicsx.case.files import DataFile
from turbine_fenicsx.case.quantities import unit_of
from turbine_fenicsx.case.section import HUGE, Section
from turbine_fenicsx.case.toml_file import format_toml

_SIGNS = (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤"))


@dataclass(frozen=True)
class Key:
    """One key of a table.

    Args:
        unit: SI unit of a number; empty for what has none, "-" for plain numbers.
        default: As TOML; empty for none.
        allowed: Choices, range, number of entries.
    """

    name: str
    unit: str
    default: str
    allowed: str
    meaning: str


@dataclass(frozen=True)
class Table:
    """One table of a case file.

    Args:
        name: Such as "turbine.hub"; empty for what stands before all tables.
        text: What the table is about.
        keys: Its keys, in order.
    """

    name: str
    text: str
    keys: tuple[Key, ...]


def list_tables(model: type[Section]) -> list[Table]:
    """All tables of a model with their keys."""
    return list(_walk_tables("", model, model()))


def _walk_tables(name: str, model: type[Section], default: Section) -> Iterator[Table]:
    """A table, then those inside it."""
    keys, inner = [], []
    for key, field in model.model_fields.items():
        kind = field.annotation
        dotted = f"{name}.{key}" if name else key
        if get_origin(kind) is dict:  # tables with names of the user's own
            section = get_args(kind)[1]
            inner.append((f"{dotted}.NAME", section, section()))
        elif isinstance(kind, type) and issubclass(kind, Section):
            inner.append((dotted, kind, getattr(default, key)))
        else:
            types = [kind, *field.metadata]
            value = getattr(default, key)
            shown = "" if value is None else format_toml(value)
            meaning = " ".join((field.description or "").split())
            if not meaning:
                raise ValueError(f"{model.__name__}.{key} has no docstring below it")
            keys.append(Key(key, _find_unit(types), shown, _describe_range(types), meaning))
    yield Table(name, inspect.getdoc(model) or "", tuple(keys))
    for arguments in inner:
        yield from _walk_tables(*arguments)


def _walk_types(kind: Any) -> Iterator[Any]:
    """A type, its parts, and what annotates them."""
    if isinstance(kind, list):
        for part in kind:
            yield from _walk_types(part)
        return
    yield kind
    if get_origin(kind) is not Literal:
        marks = (*getattr(kind, "__metadata__", ()), *getattr(kind, "metadata", ()))
        for part in (*get_args(kind), *marks):
            yield from _walk_types(part)


def _find_unit(types: list[Any]) -> str:
    """Unit of a number; "-" for one without."""
    for part in _walk_types(types):
        symbol = getattr(part, "symbol", None) or unit_of(part)
        if symbol is not None:
            return symbol.replace("^2", "²").replace("^3", "³") or "-"
    return ""


def _describe_range(types: list[Any]) -> str:
    """Choices, range and number of entries."""
    parts = list(_walk_types(types))
    choices = [format_toml(c) for p in parts if get_origin(p) is Literal for c in get_args(p)]
    bounds = {
        (sign, getattr(part, name))
        for part in parts
        for name, sign in _SIGNS
        if getattr(part, name, None) is not None and abs(getattr(part, name)) < HUGE
    }
    if choices and float in parts:
        bounds = {(">", 0.0)}
    limits = [f"{sign} {value:g}" for sign, value in sorted(bounds, key=lambda b: b[1])]
    text = ", ".join([*dict.fromkeys(choices), *limits])
    for part in parts:
        if get_origin(part) is tuple:
            entries = get_args(part)
            things = "file names" if any(isinstance(p, DataFile) for p in parts) else "numbers"
            count = "list" if Ellipsis in entries else f"{len(entries)} {things}"
            return f"{count}, each {text}" if text else count
    if text:
        return text
    return "true, false" if bool in parts else "text" if str in parts else "any"


def strip_marks(text: str) -> str:
    """A docstring without backticks, for a terminal."""
    return re.sub(r"`+", "", text)

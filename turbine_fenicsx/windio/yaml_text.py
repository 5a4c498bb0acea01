"""YAML as windIO writes it: numbers, text, lists and tables; nothing in it is ever run."""

from __future__ import annotations

import re
from typing import Any

import yaml

DEEPEST = 30
"""Lists and tables in lists and tables; a windIO file has ten."""

LARGEST = 500_000
"""Values of a file, each alias counted as what it stands for; IEA-22 has fifty thousand."""

_NUMBER = re.compile(r"[-+]?(\d+|(\d+\.\d*|\.\d+)([eE][-+]?\d+)?|\d+[eE][-+]?\d+)")
_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -float("inf")),
}
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class YamlError(Exception):
    """A text that is no YAML, or none of ours; the message is a sentence without its name."""


def parse_yaml(text: str) -> Any:
    """Numbers, text, lists and dictionaries of a YAML 1.2 text.

    The parser's events are put together here, without recursion and without its constructors: deep
    nesting crashes those of libyaml, and aliases of aliases stand for more than fits into memory.

    Raises:
        YamlError: for what is no YAML; for tags, repeated keys, too many values.
    """
    builder = _Builder()
    try:
        for event in yaml.parse(text, Loader=_LOADER):
            builder.add(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f" in line {mark.line + 1}" if mark else ""
        raise YamlError(f"is not valid YAML: {error.problem or error.context}{where}") from None
    except yaml.YAMLError as error:  # characters that YAML does not allow
        raise YamlError(f"is not valid YAML: {str(error).splitlines()[0]}") from None
    return builder.value


class _Builder:
    """Values from the events of the parser."""

    def __init__(self) -> None:
        self.value: Any = None
        self._open: list[tuple[Any, str | None, int]] = []  # collections, anchors, sizes before
        self._keys: list[Any] = []  # of each open table the key whose value comes next
        self._anchors: dict[str, tuple[Any, int]] = {}
        self._size = 0
        self._documents = 0

    def add(self, event: Any) -> None:
        """Take in the next event."""
        line = event.start_mark.line + 1
        if isinstance(event, yaml.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                raise YamlError(f"holds a second document in line {line}")
        elif isinstance(event, yaml.SequenceStartEvent | yaml.MappingStartEvent):
            self._begin(event, line)
        elif isinstance(event, yaml.SequenceEndEvent | yaml.MappingEndEvent):
            self._end(line)
        elif isinstance(event, yaml.ScalarEvent):
            self._check_tag(event, line)
            self._grow(1, line)
            value = event.value
            if event.implicit[0] and not self._awaits_key():
                value = _resolve(value, line)
            if event.anchor:
                self._anchors[event.anchor] = (value, 1)
            self._put(value, line)
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._anchors:
                raise YamlError(f"uses {event.anchor!r} in line {line}, which stands for nothing")
            value, size = self._anchors[event.anchor]
            self._grow(size, line)
            self._put(value, line)

    def _begin(self, event: Any, line: int) -> None:
        self._check_tag(event, line)
        if self._awaits_key():
            raise YamlError(f"has a key in line {line} that is not text")
        if len(self._open) >= DEEPEST:
            raise YamlError(f"nests its lists and tables more than {DEEPEST} deep in line {line}")
        is_table = isinstance(event, yaml.MappingStartEvent)
        self._open.append(({} if is_table else [], event.anchor, self._size))
        self._keys.append(None)

    def _end(self, line: int) -> None:
        value, anchor, before = self._open.pop()
        self._keys.pop()
        self._grow(1, line)
        if isinstance(value, dict) and "<<" in value:
            _merge(value, line)
        if anchor:
            self._anchors[anchor] = (value, self._size - before)
        self._put(value, line)

    def _awaits_key(self) -> bool:
        return bool(self._open) and isinstance(self._open[-1][0], dict) and self._keys[-1] is None

    def _put(self, value: Any, line: int) -> None:
        if not self._open:
            self.value = value
        elif isinstance(self._open[-1][0], list):
            self._open[-1][0].append(value)
        elif self._keys[-1] is not None:
            self._open[-1][0][self._keys[-1]] = value
            self._keys[-1] = None
        elif not isinstance(value, str):
            raise YamlError(f"has a key in line {line} that is not text")
        elif value in self._open[-1][0]:
            raise YamlError(f"has the key {value[:60]!r} in line {line} twice")
        else:
            self._keys[-1] = value

    def _grow(self, size: int, line: int) -> None:
        self._size += size
        if self._size > LARGEST:
            raise YamlError(f"holds more than {LARGEST} values in line {line}")

    def _check_tag(self, event: Any, line: int) -> None:
        if event.tag is not None:
            raise YamlError(f"has the tag {event.tag[:60]!r} in line {line}, which is not read")


def _merge(table: dict[str, Any], line: int) -> None:
    """Take the keys of other tables that a table names under "<<" and does not have itself."""
    named = table.pop("<<")
    for other in named if isinstance(named, list) else [named]:
        if not isinstance(other, dict):
            raise YamlError(f"merges what is no table in line {line}")
        for key, value in other.items():
            table.setdefault(key, value)


def _resolve(text: str, line: int) -> Any:
    """What an unquoted scalar stands for in YAML 1.2, where 1e-5 is a number."""
    if text in _WORDS:
        return _WORDS[text]
    if not _NUMBER.fullmatch(text):
        return text
    if len(text) > 400:
        raise YamlError(f"holds a number with too many digits in line {line}")
    return float(text)

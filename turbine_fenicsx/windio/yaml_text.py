"""YAML as windIO writes it: numbers, text, lists and tables; nothing in it is ever run."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, ClassVar

import yaml

DEEPEST = 30
"""Lists and tables in lists and tables; a windIO file has ten."""

MAX_VALUES = 500_000
"""Values of a file, each alias counted as what it stands for; IEA-22 has fifty thousand."""

MAX_NUMBER_LENGTH = 400
"""Characters of a number."""

_TOO_MANY = f"holds more than {MAX_VALUES} values in line {{}}"
_INCLUDE = "!include"
_TAG = "tag:yaml.org,2002:"
_TAGS = {_TAG + name for name in ("null", "bool", "float", "str", "seq", "map", "merge")}
_PLAIN = {
    "null": (r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    "bool": (r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    "float": (
        r"[-+]?(\d+|(\d+\.\d*|\.\d+)([eE][-+]?\d+)?|\d+[eE][-+]?\d+|\.(inf|Inf|INF))"
        r"|\.(nan|NaN|NAN)",
        list("-+.0123456789"),
    ),
    "merge": (r"<<", ["<"]),
}
"""Types of unquoted text in YAML 1.2, where 1e-5 is a number, by its first characters."""


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """PyYAML's safe loader, with the plain text of YAML 1.2 in place of that of 1.1."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}
    included: dict[str, Any]  # contents of files by the names that the text has


for _name, (_pattern, _first) in _PLAIN.items():
    Loader.add_implicit_resolver(_TAG + _name, re.compile(f"(?:{_pattern})$"), _first)
Loader.add_constructor(_INCLUDE, lambda loader, node: loader.included[node.value])


class YamlError(Exception):
    """Invalid or refused YAML; the message is a sentence without the file's name."""


Include = Callable[[str], tuple[Any, int]]
"""Contents of an included file and their number of values, by its name in the text."""


def parse_yaml(text: str) -> Any:
    """Numbers, text, lists and dictionaries of a YAML 1.2 text."""
    return parse_counted(text)[0]


def parse_counted(text: str, include: Include | None = None) -> tuple[Any, int]:
    """The contents of a text as by `parse_yaml`, and their number of values.

    Args:
        include: Reads the files that the text includes; without it, ``!include`` is refused.
    """
    try:
        _check_events(text)
        loader = Loader(text)
        loader.included = {}
        node = loader.get_single_node()
        if node is None:
            return None, 0
        size = _Checks(loader.included, include).check(node)
        return loader.construct_document(node), size
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f" in line {mark.line + 1}" if mark else ""
        said = ": ".join(filter(None, (error.context, error.problem)))
        raise YamlError(f"is not valid YAML: {said}{where}") from None
    except yaml.YAMLError as error:  # characters that YAML does not allow
        raise YamlError(f"is not valid YAML: {str(error).splitlines()[0]}") from None


def list_includes(text: str) -> list[str]:
    """Names of the files that a text includes."""
    if _INCLUDE not in text:
        return []
    try:
        events = yaml.parse(text, Loader=Loader)
        scalars = (event for event in events if isinstance(event, yaml.ScalarEvent))
        return [scalar.value for scalar in scalars if scalar.tag == _INCLUDE]
    except yaml.YAMLError:
        raise YamlError("is not valid YAML") from None


def _check_events(text: str) -> None:
    """Refuse deep nesting and many values before anything is put together, which is recursive."""
    depth = size = 0
    for event in yaml.parse(text, Loader=Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        size += isinstance(event, yaml.NodeEvent)
        if depth > DEEPEST or size > MAX_VALUES:
            line = event.start_mark.line + 1
            deep = f"nests its lists and tables more than {DEEPEST} deep in line {line}"
            raise YamlError(deep if depth > DEEPEST else _TOO_MANY.format(line))


class _Checks:
    """Refuses unsupported nodes, and counts values.

    Args:
        include: Reads them; None refuses them.
    """

    def __init__(self, included: dict[str, Any], include: Include | None) -> None:
        self._included = included
        self._include = include
        self._sizes: dict[int, int] = {}  # of nodes that aliases may stand for, by identity

    def check(self, node: Any) -> int:
        """The number of values in text, a list or a table, whose keys become text."""
        line = node.start_mark.line + 1
        if id(node) in self._sizes:
            if self._sizes[id(node)] == 0:
                raise YamlError(f"has a list or a table in line {line} that is part of itself")
            return self._sizes[id(node)]
        self._sizes[id(node)], size = 0, 1
        if node.tag == _INCLUDE and self._include and isinstance(node, yaml.ScalarNode):
            self._included[node.value], size = self._include(node.value)
        elif node.tag not in _TAGS:
            raise YamlError(f"has the tag {node.tag[:60]!r} in line {line}, which is not read")
        elif node.tag == _TAG + "float" and len(node.value) > MAX_NUMBER_LENGTH:
            raise YamlError(f"holds a number with too many digits in line {line}")
        elif isinstance(node, yaml.SequenceNode):
            size += sum(self.check(value) for value in node.value)
        elif isinstance(node, yaml.MappingNode):
            keys: set[str] = set()
            for key, value in node.value:
                _check_key(key, keys)
                size += 1 + self.check(value)
        if size > MAX_VALUES:
            raise YamlError(_TOO_MANY.format(line))
        self._sizes[id(node)] = max(size, 1)
        return size


def _check_key(key: Any, before: set[str]) -> None:
    """Refuse keys that are not text or occur twice; numbers and words become text."""
    line = key.start_mark.line + 1
    if not isinstance(key, yaml.ScalarNode) or key.tag not in _TAGS:
        raise YamlError(f"has a key in line {line} that is not text")
    if key.value in before:
        raise YamlError(f"has the key {key.value[:60]!r} in line {line} twice")
    before.add(key.value)
    if key.tag != _TAG + "merge":
        key.tag = _TAG + "str"

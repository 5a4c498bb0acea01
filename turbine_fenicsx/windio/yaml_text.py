"""YAML as windIO writes it: numbers, text, lists and tables; nothing in it is ever run."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import yaml

DEEPEST = 30
"""Lists and tables in lists and tables; a windIO file has ten."""

MAX_VALUES = 500_000
"""Values of a file, each alias counted as what it stands for; IEA-22 has fifty thousand."""

MAX_NUMBER_LENGTH = 400
"""Characters of a number."""

_TOO_MANY = f"holds more than {MAX_VALUES} values in line {{}}"
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


for _name, (_pattern, _first) in _PLAIN.items():
    Loader.add_implicit_resolver(_TAG + _name, re.compile(f"(?:{_pattern})$"), _first)


class YamlError(Exception):
    """Invalid or refused YAML; the message is a sentence without the file's name."""


def parse_yaml(text: str) -> Any:
    """Numbers, text, lists and dictionaries of a YAML 1.2 text.

    Raises:
        YamlError: if it is not YAML, or has tags, repeated keys or too many values.
    """
    try:
        _check_events(text)
        loader = Loader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _check(node, {})
        return loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f" in line {mark.line + 1}" if mark else ""
        said = ": ".join(filter(None, (error.context, error.problem)))
        raise YamlError(f"is not valid YAML: {said}{where}") from None
    except yaml.YAMLError as error:  # characters that YAML does not allow
        raise YamlError(f"is not valid YAML: {str(error).splitlines()[0]}") from None


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


def _check(node: Any, sizes: dict[int, int]) -> int:
    """Refuse unsupported nodes, and return the number of values in a node.

    Args:
        node: Text, a list or a table; keys become text.
        sizes: Those of the nodes that aliases may stand for, by identity.
    """
    line = node.start_mark.line + 1
    if id(node) in sizes:
        if sizes[id(node)] == 0:
            raise YamlError(f"has a list or a table in line {line} that is part of itself")
        return sizes[id(node)]
    sizes[id(node)], size = 0, 1
    if node.tag not in _TAGS:
        raise YamlError(f"has the tag {node.tag[:60]!r} in line {line}, which is not read")
    if node.tag == _TAG + "float" and len(node.value) > MAX_NUMBER_LENGTH:
        raise YamlError(f"holds a number with too many digits in line {line}")
    if isinstance(node, yaml.SequenceNode):
        size += sum(_check(value, sizes) for value in node.value)
    elif isinstance(node, yaml.MappingNode):
        keys: set[str] = set()
        for key, value in node.value:
            _check_key(key, keys)
            size += 1 + _check(value, sizes)
    if size > MAX_VALUES:
        raise YamlError(_TOO_MANY.format(line))
    sizes[id(node)] = size
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

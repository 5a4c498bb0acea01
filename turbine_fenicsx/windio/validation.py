"""A windIO file against windIO's own schema, where that and jsonschema are installed."""

from __future__ import annotations

import os

from turbine_fenicsx.windio.files import find_windio
from turbine_fenicsx.windio.yaml_file import read_yaml

MAX_MESSAGES = 5
"""Sentences, the last with the number of further mistakes."""

_SCHEMA = ("schemas", "turbine", "turbine_schema.yaml")


def list_schema_mistakes(path: str | os.PathLike[str]) -> list[str]:
    """Objections of windIO's schema to a file that `read_turbine` reads.

    Keys that the schema does not know are not among it.

    Returns:
        A sentence each; none where nothing is wrong, or windIO or jsonschema is not installed.
    """
    try:
        from jsonschema import Draft7Validator
    except ImportError:
        return []
    windio = find_windio()
    schema = windio and windio.joinpath(*_SCHEMA)
    if schema is None or not schema.is_file():
        return []
    validator = Draft7Validator(read_yaml(schema))
    found = validator.iter_errors(read_yaml(path))
    told = [
        f"{os.path.basename(path)}: windIO's schema says of {error.json_path.removeprefix('$.')} "
        f"that {_shorten(error.message)}"
        for error in found
    ]
    if len(told) > MAX_MESSAGES:
        told[MAX_MESSAGES:] = [
            f"windIO's schema says so of {len(told) - MAX_MESSAGES} more entries"
        ]
    return told


def _shorten(message: str) -> str:
    """One line of a message, which may quote a whole table."""
    line = " ".join(message.split())
    return line if len(line) <= 160 else f"{line[:80]} ... {line[-70:]}"

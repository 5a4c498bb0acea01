"""The keys of a model as a JSON schema, by which editors complete and check case files."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, GetJsonSchemaHandler
from pydantic_core import CoreSchema

from turbine_fenicsx.case.section import HUGE

_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""Pydantic's names of bounds behind a conversion of units, and those of JSON schemas."""


class Also:
    """Marks a key that takes other kinds of values besides the one of its type."""

    def __init__(self, *kinds: str) -> None:
        self._kinds = kinds

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """The schema of the type or of the others."""
        return {"anyOf": [handler(schema), *({"type": kind} for kind in self._kinds)]}


def make_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """The JSON schema of all tables and keys of a model.

    Args:
        title: Name of the files that it describes.
    """
    schema: dict[str, Any] = _rename_bounds(model.model_json_schema())
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": title,
    }


def _rename_bounds(part: Any) -> Any:
    """A part of a schema with bounds that editors know, apart from those beyond all numbers."""
    if isinstance(part, list):
        return [_rename_bounds(item) for item in part]
    if not isinstance(part, dict):
        return part
    return {
        _BOUNDS.get(key, key): _rename_bounds(value)
        for key, value in part.items()
        if not (key in (*_BOUNDS, *_BOUNDS.values()) and abs(value) >= HUGE)
    }

"""A case in the words of a report: what has an effect, with units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from turbine_fenicsx.case.quantities import unit_of
from turbine_fenicsx.case.rules import find_unused_keys
from turbine_fenicsx.case.section import Section
from turbine_fenicsx.turbine.case.case import Case

_OPTIONAL = ("aero", "control", "drivetrain", "generator", "wind", "yaw")
"""Tables of what a turbine has only if its case says so."""


def describe_case(data: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a case without what is empty or has no effect, as the sizes of a rigid tower.

    Args:
        data: Nested tables, as ``case.json`` has them.

    Returns:
        Nested tables whose keys carry their SI units, for example ``length_[m]``.

    Raises:
        InputError: if it is no valid case.
    """
    case = Case.parse(data, None)
    unused = {key.name for key in find_unused_keys(case)}
    absent = {
        name for name in _OPTIONAL if not getattr(case, name).model_dump(exclude_defaults=True)
    }
    return _describe(case, unused | absent, "")


def _describe(section: Section, unused: set[str], above: str) -> dict[str, Any]:
    """One table."""
    found = {}
    for key, field in type(section).model_fields.items():
        value = getattr(section, key)
        if f"{above}{key}" in unused or value in ("", None):
            continue
        if isinstance(value, dict):
            tables = {
                name: _describe(table, unused, f"{above}{key}.{name}.")
                for name, table in value.items()
            }
            found.update({key: tables} if tables else {})
            continue
        if isinstance(value, Section):
            found[key] = _describe(value, unused, f"{above}{key}.")
            continue
        kind = (
            Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
        )
        unit = unit_of(kind)
        found[f"{key}_[{unit}]" if unit and not isinstance(value, str) else key] = value
    return found

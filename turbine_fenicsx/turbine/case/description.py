"""A case in the words of a report: what has an effect, with units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.consistency import idle_keys
from turbine_fenicsx.turbine.case.quantities import unit_of
from turbine_fenicsx.turbine.case.section import Section


def describe_case(data: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a case without what is empty or has no effect, as the sizes of a rigid tower.

    Args:
        data: Nested tables, as ``case.json`` has them.

    Returns:
        Nested tables whose keys carry their SI units, for example ``length_[m]``.

    Raises:
        InputError: if it is no valid case.
    """
    case = Case.parse(data)
    idle = {f"{table}.{key}".lstrip(".") for table, keys, _ in idle_keys(case) for key in keys}
    return _describe(case, idle, "")


def _describe(section: Section, idle: set[str], above: str) -> dict[str, Any]:
    """One table."""
    found = {}
    for key, field in type(section).model_fields.items():
        value = getattr(section, key)
        if f"{above}{key}" in idle or value in ("", None):
            continue
        if isinstance(value, Section):
            found[key] = _describe(value, idle, f"{above}{key}.")
            continue
        kind = (
            Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
        )
        unit = unit_of(kind)
        found[f"{key}_[{unit}]" if unit and not isinstance(value, str) else key] = value
    return found

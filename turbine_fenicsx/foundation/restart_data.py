"""Data from which a run resumes as if it had never stopped, independent of files and formats."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from turbine_fenicsx.foundation.types import Array


@dataclass
class RestartData:
    """Named data; parts of a program add theirs under unique names.

    Args:
        numbers: Whatever JSON can hold without loss, equal on all ranks.
        arrays: Arrays that are equal on all ranks.
        nodal: Values at the owned nodes of each flexible body, arrays of shape (n_owned, 3).
    """

    numbers: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, Array] = field(default_factory=dict)
    nodal: dict[str, tuple[Array, ...]] = field(default_factory=dict)

    def add(self, name: str, other: RestartData) -> None:
        """Add other data; their entries become ``name.entry``."""
        for mine, theirs in zip(self._parts(), other._parts(), strict=True):
            mine.update({f"{name}.{key}": value for key, value in theirs.items()})

    def part(self, name: str) -> RestartData:
        """Data added under a name; empty if there are none."""
        start = f"{name}."
        return RestartData(
            *(
                {k.removeprefix(start): v for k, v in part.items() if k.startswith(start)}
                for part in self._parts()
            )
        )

    def __bool__(self) -> bool:
        """Whether there is anything."""
        return any(self._parts())

    def _parts(self) -> tuple[dict[str, Any], ...]:
        """The three dictionaries."""
        return self.numbers, self.arrays, self.nodal

"""Study files: one TOML file names a case and what to change in it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from turbine_fenicsx.case.mistakes import validate
from turbine_fenicsx.case.toml_file import read_toml
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote


def flatten(table: Mapping[str, Any], start: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of nested tables."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from flatten(value, f"{start}{name}.")
        else:
            yield f"{start}{name}", value


def _flatten_value(value: Any) -> Any:
    """Nested tables with dotted keys; ``"time.step" = 1`` and ``time.step = 1`` are the same."""
    return dict(flatten(value)) if isinstance(value, Mapping) else value


def _check_reference(value: Any) -> Any:
    """Check the reference of a refinement."""
    number = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    if number or value in ("finest", "richardson"):
        return value
    raise ValueError("must be 'finest', 'richardson' or a number")


Names = Annotated[
    tuple[str, ...], BeforeValidator(lambda value: [value] if isinstance(value, str) else value)
]
Changes = Annotated[dict[str, Any], BeforeValidator(_flatten_value)]


class Convergence(BaseModel):
    """Refined key, quantities and their reference."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    key: str
    quantity: Names
    reference: Annotated[float | str, BeforeValidator(_check_reference)] = "finest"


class Curve(BaseModel):
    """Curve over a key that the study varies.

    Attributes:
        x: The key.
        y: Quantities, one panel each.
        reference: CSV file with a column named like the key and columns of quantities, relative to
            the study file.
        label: What the references are, for the legend.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    x: str
    y: Names
    reference: str | None = None
    label: str = "reference"


class Study(BaseModel):
    """A study; see `turbine_fenicsx.study.plan` for the runs it stands for.

    Attributes:
        case: Case file, relative to the study file.
        launcher: Command that starts the ranks if there are several.
        quantities: Columns of the table, with or without their units; all if empty.
        set: Changes of all runs by dotted key.
        grid: Lists of values by dotted key; all combinations are run.
        run: Changes of single runs by dotted key, each combined with the whole grid.
        average: Time at the end of each run over which columns of ``history.csv`` are averaged;
            their last values if None [s].
        curve: A picture of quantities over a key, if wanted.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    title: str = ""
    case: str
    processes: Annotated[int, Field(ge=1)] = 1
    ranks: Annotated[int, Field(ge=1)] = 1
    launcher: str = "mpirun -n {ranks}"
    quantities: Names = ()
    set: Changes = {}
    grid: Changes = {}
    run: list[Changes] = []
    average: Annotated[float, Field(gt=0.0)] | None = None
    convergence: Convergence | None = None
    curve: Curve | None = None

    @property
    def varied(self) -> list[str]:
        """Dotted keys that differ between runs, in the order of the file."""
        return list(dict.fromkeys([key for changes in self.run for key in changes] + [*self.grid]))

    @property
    def wanted(self) -> list[str]:
        """All quantities that are looked at."""
        found = list(self.quantities)
        found += self.convergence.quantity if self.convergence else ()
        return [*found, *(self.curve.y if self.curve else ())]

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Study:
        """Read a study file.

        Returns:
            The study, its case relative to the present directory.
        """
        data = read_toml(path, "study file")
        if isinstance(data.get("case"), str):
            data["case"] = str(Path(path).parent / data["case"])
        curve = data.get("curve")
        if isinstance(curve, dict) and isinstance(curve.get("reference"), str):
            curve["reference"] = str(Path(path).parent / curve["reference"])
        return Study.parse(data)

    @staticmethod
    def parse(data: Mapping[str, Any]) -> Study:
        """Make a study from nested tables."""
        study = validate(Study, data)
        mistakes = list(study._find_contradictions())
        if mistakes:
            raise InputError("\n".join(mistakes))
        return study

    def _find_contradictions(self) -> Iterator[str]:
        """Sentences about keys that do not fit together."""
        if not self.grid and not self.run:
            yield "the study varies nothing: give lists of values in [grid], or entries [[run]]"
        for key, values in self.grid.items():
            if not isinstance(values, list) or not values:
                yield f"grid.{key} = {quote(values)}: must be a list of values"
        in_runs = {key for changes in self.run for key in changes}
        for key in self.varied:
            if key in self.grid and key in in_runs:
                yield f"{key!r} stands in [grid] and in [[run]]; give it in one of them"
            if key in self.set:
                yield f"{key!r} stands in [set], which is for all runs, but differs between them"
        looked_at = {
            "convergence.key": self.convergence.key if self.convergence else None,
            "curve.x": self.curve.x if self.curve else None,
        }
        for name, varied in looked_at.items():
            if varied is not None and varied not in self.varied:
                yield (
                    f"{name} = {varied!r} is not varied; choose from "
                    f"{', '.join(self.varied) or 'nothing'}"
                )

"""Study files: one TOML file names a case and what to change in it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.case.mistakes import find_mistakes, quote
from turbine_fenicsx.turbine.case.toml_file import read_toml


def flatten(table: Mapping[str, Any], start: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of nested tables."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from flatten(value, f"{start}{name}.")
        else:
            yield f"{start}{name}", value


def _flat(value: Any) -> Any:
    """Nested tables with dotted keys; ``"time.step" = 1`` and ``time.step = 1`` are the same."""
    return dict(flatten(value)) if isinstance(value, Mapping) else value


def _several(value: Any) -> Any:
    """One name as a list of one."""
    return [value] if isinstance(value, str) else value


def _reference(value: Any) -> Any:
    """What a refinement is compared with."""
    number = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    if number or value in ("finest", "richardson"):
        return value
    raise ValueError("must be 'finest', 'richardson' or a number")


Names = Annotated[tuple[str, ...], BeforeValidator(_several)]
Changes = Annotated[dict[str, Any], BeforeValidator(_flat)]


class Convergence(BaseModel):
    """What is refined, what is looked at, and what it is compared with."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    key: str
    quantity: Names
    reference: Annotated[float | str, BeforeValidator(_reference)] = "finest"


class Study(BaseModel):
    """A study; see `turbine_fenicsx.study.plan` for the runs it stands for.

    Attributes:
        title: Title of the figure.
        case: Case file, relative to the study file.
        processes: How many runs at a time.
        ranks: MPI ranks of each run.
        launcher: Command that starts the ranks if there are several.
        quantities: Columns of the table, with or without their units; all if empty.
        set: Changes of all runs by dotted key.
        grid: Lists of values by dotted key; all combinations are run.
        run: Changes of single runs by dotted key, each combined with the whole grid.
        convergence: Observed orders of convergence, if wanted.
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
    convergence: Convergence | None = None

    @property
    def varied(self) -> list[str]:
        """Dotted keys that differ between runs, in the order of the file."""
        return list(dict.fromkeys([key for changes in self.run for key in changes] + [*self.grid]))

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Study:
        """Read a study file.

        Args:
            path: TOML file.

        Returns:
            The study, its case relative to the present directory.

        Raises:
            InputError: with one sentence for every mistake.
        """
        data = read_toml(path, "study file")
        if isinstance(data.get("case"), str):
            data["case"] = str(Path(path).parent / data["case"])
        return Study.parse(data)

    @staticmethod
    def parse(data: Mapping[str, Any]) -> Study:
        """Make a study from nested tables.

        Args:
            data: The tables.

        Raises:
            InputError: with one sentence for every mistake.
        """
        try:
            study = Study.model_validate(data)
        except ValidationError as error:
            sentences = [mistake.sentence for mistake in find_mistakes(error, data, Study)]
            raise InputError("\n".join(sentences)) from None
        mistakes = list(study._contradictions())
        if mistakes:
            raise InputError("\n".join(mistakes))
        return study

    def _contradictions(self) -> Iterator[str]:
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
        if self.convergence is not None and self.convergence.key not in self.varied:
            yield (
                f"convergence.key = {self.convergence.key!r} is not varied; choose from "
                f"{', '.join(self.varied) or 'nothing'}"
            )

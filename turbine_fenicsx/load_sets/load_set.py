"""Files of load sets: the turbine, its site, and the situations that are run."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from turbine_fenicsx.case.mistakes import validate
from turbine_fenicsx.case.quantities import Seconds, Speed, to_si
from turbine_fenicsx.case.section import Positive
from turbine_fenicsx.case.toml_file import read_toml
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote, suggest
from turbine_fenicsx.load_sets.situation import Situation, read_standard
from turbine_fenicsx.study.file import Changes
from turbine_fenicsx.turbine.tables.wind import Classes
from turbine_fenicsx.wind.gusts import REFERENCE_SPEEDS

MOST_WINDS = 1000
"""Wind speeds between cut-in and cut-out."""

FEWEST_BLOCKS = 5
"""Extremes at each wind speed from which those of a return period are found."""

NAMED = ("cut_in", "rated", "cut_out", "reference")
"""Words for wind speeds."""

ALL = "all"
"""Name of all situations together in tables, which none of them has."""

_NAME = re.compile(r"\w[\w.+-]*")  # of folders
_LETTERS = "letters, digits, '.', '_', '+' and '-' that begins with a letter or digit"

_WIND = re.compile(rf"(?:([\d.]+)\s+)?({'|'.join(NAMED)})(?:\s*([-+])\s*(.+))?")


class Lifetime(BaseModel):
    """How long a turbine stands, and in which winds.

    Attributes:
        years: Its life.
        mean_wind: Mean of the year at the hub; 0.2 V_ref of the class if None [m/s].
        shape: Exponent of Weibull's distribution of the wind speed; 2 is Rayleigh's [-].
        cycles: Equivalent cycles of the life [-].
        ultimate: Ultimate loads of those whose means count for fatigue, by column.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    years: Annotated[float, Field(gt=0.0, le=1000.0)] = 20.0
    mean_wind: Annotated[Speed, Positive] | None = None
    shape: Annotated[float, Field(ge=0.5, le=10.0)] = 2.0
    cycles: Annotated[float, Field(ge=1.0, le=1e12)] = 1e7
    ultimate: dict[str, Annotated[float, Field(gt=0.0)]] = {}


class Extremes(BaseModel):
    """How extremes of situations that evaluate extrapolation are found.

    Attributes:
        years: Return period.
        block: Duration of the blocks whose largest values count [s].
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    years: Annotated[float, Field(ge=0.01, le=1e6)] = 50.0
    block: Annotated[Seconds, Positive] = 60.0


class LoadSet(BaseModel):
    """A load set; its runs follow from it by `turbine_fenicsx.load_sets.plan`.

    Attributes:
        case: Case file of the turbine, relative to the file of the set.
        situations: Names of those that are run; all of the standard if empty.
        turbine_class: Class of the turbine and category of turbulence.
        turbulence: Its model.
        cut_in: Least wind speed of operation [m/s].
        cut_out: Largest one [m/s].
        wind_step: Distance of those between [m/s].
        rated: Wind speed from which the power is kept; found from the controller if None [m/s].
        seeds: How many winds each speed has, or numbers of winds that all speeds have.
        processes: How many runs at a time; all cores if None.
        launcher: Words before the command of each run, which start it elsewhere; none if empty.
        set: Changes of all runs by dotted key.
        situation: Changes of situations by name, and further ones.
        lifetime: For equivalent loads of the life.
        extremes: For loads of a return period.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    title: str = ""
    case: str
    situations: tuple[str, ...] = ()
    turbine_class: Classes = "IB"
    turbulence: Literal["kaimal", "mann"] = "kaimal"
    cut_in: Annotated[Speed, Positive] = 3.0
    cut_out: Annotated[Speed, Positive] = 25.0
    wind_step: Annotated[Speed, Positive] = 2.0
    rated: Annotated[Speed, Positive] | None = None
    seeds: Annotated[int, Field(ge=1, le=1000)] | tuple[int, ...] = 6
    processes: Annotated[int, Field(ge=1)] | None = None
    launcher: str = ""
    set: Changes = {}
    situation: dict[str, dict[str, Any]] = {}
    lifetime: Lifetime = Lifetime()
    extremes: Extremes = Extremes()

    @staticmethod
    def load(path: str | os.PathLike[str]) -> LoadSet:
        """Read a file.

        Returns:
            The set, its case relative to the present directory.

        Raises:
            InputError: with one sentence for every mistake.
        """
        data = read_toml(path, "file of a load set")
        if isinstance(data.get("case"), str):
            data["case"] = str(Path(path).parent / data["case"])
        return LoadSet.parse(data)

    @staticmethod
    def parse(data: Mapping[str, Any]) -> LoadSet:
        """Make a set from nested tables; raises as `load`."""
        found = validate(LoadSet, data)
        if mistakes := list(found._find_mistakes()):
            raise InputError("\n".join(mistakes))
        return found

    @property
    def chosen(self) -> dict[str, Situation]:
        """The situations that are run by name, in the order of the file."""
        tables = {**read_standard(), **self.situation}
        names = self.situations or tuple(tables)
        return {name: self._read(name) for name in names}

    @property
    def operating(self) -> list[float]:
        """Wind speeds of operation from cut-in to cut-out [m/s]."""
        n = int((self.cut_out - self.cut_in) / self.wind_step * (1.0 + 1e-9)) + 1
        return [round(float(x), 9) for x in self.cut_in + self.wind_step * np.arange(n)]

    @property
    def reference(self) -> float:
        """V_ref of the class [m/s]."""
        return REFERENCE_SPEEDS[self.turbine_class.rstrip("ABC+")]

    def find_winds(self, situation: Situation, rated: float) -> list[float]:
        """Wind speeds of a situation [m/s].

        Args:
            rated: Wind speed from which the power is kept [m/s].
        """
        speeds = self.cut_in, rated, self.cut_out, self.reference
        values = dict(zip(NAMED, speeds, strict=True))
        found: list[float] = []
        for wind in situation.winds:
            if wind == "operating":
                found += self.operating
            elif isinstance(wind, str) and (match := _WIND.fullmatch(wind.strip())):
                factor, name, sign, difference = match.groups()
                speed = float(factor or 1.0) * values[name]
                if difference:
                    speed += (1.0 if sign == "+" else -1.0) * to_si(difference, "m/s")
                found.append(round(speed, 9))
            else:
                found.append(to_si(wind, "m/s"))
        return found

    def _read(self, name: str) -> Situation:
        """A situation of the standard with changes, or one of the file."""
        data = {**read_standard().get(name, {}), **self.situation.get(name, {})}
        return validate(Situation, data)

    def _find_mistakes(self) -> Iterator[str]:
        """Sentences about what does not fit together."""
        known = {**read_standard(), **self.situation}
        for name in self.situations:
            if name not in known:
                yield f"situations: {quote(name)} is none{suggest(name, known)}"
        if len(set(self.situations)) < len(self.situations):
            yield "situations: each may stand there once"
        if isinstance(self.seeds, tuple) and len(set(self.seeds)) < len(self.seeds):
            yield f"seeds = {list(self.seeds)}: expected numbers that do not repeat"
        if isinstance(self.seeds, tuple) and not (self.seeds and min(self.seeds) >= 0):
            yield f"seeds = {list(self.seeds)}: expected numbers from 0 on"
        if not self.cut_in < self.cut_out:
            yield f"cut_out = {self.cut_out:g}: expected more than cut_in = {self.cut_in:g}"
            return
        if (self.cut_out - self.cut_in) / self.wind_step > MOST_WINDS:
            yield f"wind_step = {self.wind_step:g}: expected at most {MOST_WINDS} wind speeds"
            return
        for name in self.situations or known:
            if name == ALL or not _NAME.fullmatch(name):
                yield f"situation.{quote(name)}: expected a name of {_LETTERS}, but not {ALL!r}"
            elif name in known:
                yield from self._find_mistakes_of(name, known)

    def _find_mistakes_of(self, name: str, known: Mapping[str, Any]) -> Iterator[str]:
        """Sentences about a situation."""
        try:
            situation = self._read(name)
        except InputError as error:
            yield from (f"situation.{quote(name)}.{line}" for line in str(error).splitlines())
            return
        try:
            winds = self.find_winds(situation, 0.5 * (self.cut_in + self.cut_out))
        except (InputError, ValueError) as error:
            yield f"situation.{quote(name)}.winds: {error}"
            return
        for variant in situation.variants:
            if variant and not _NAME.fullmatch(variant):
                yield (
                    f"situation.{quote(name)}.variants: {quote(variant)} is none, expected names "
                    f"of {_LETTERS}"
                )
        if situation.per_year and len(situation.per_year) != len(winds):
            yield (
                f"situation.{quote(name)}.per_year: expected one number for each of its "
                f"{len(winds)} winds, got {len(situation.per_year)}"
            )
        if situation.uses is not None and situation.uses not in (self.situations or known):
            yield f"situation.{quote(name)} uses {quote(situation.uses)}, which is not run"
            return
        if situation.evaluates == "extrapolation":
            yield from self._find_blocks_lacking(name, situation)
        high = max(winds, default=0.0)
        if situation.start == "turning" and high > self.cut_out + 1e-9:
            yield (
                f"situation.{quote(name)}.winds: {high:g} m/s is above cut_out = "
                f"{self.cut_out:g} m/s, where the turbine does not produce power"
            )

    def _find_blocks_lacking(self, name: str, situation: Situation) -> Iterator[str]:
        """A sentence if the runs of a situation have too few blocks for extrapolation."""
        try:
            source = self._read(situation.uses) if situation.uses else situation
        except InputError:  # of which there is a sentence already
            return
        block, n = self.extremes.block, source.seeds or self.seeds
        number = (n if isinstance(n, int) else len(n)) * int(source.duration / block)
        if number < FEWEST_BLOCKS:
            yield (
                f"situation.{quote(name)}: extrapolation needs {FEWEST_BLOCKS} blocks of "
                f"extremes.block = {block:g} s at each speed, got {number}"
            )

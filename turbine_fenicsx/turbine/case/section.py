"""What the tables of a case file have in common: strictness, ranges, kinds of values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from turbine_fenicsx.turbine.case.quantities import EulerMoment, Whole, whole

HUGE = 1e30
"""No number of a case is larger, so that products of a few of them are finite."""

MAX_UNKNOWNS = 2**31
"""Displacements of a mesh; PETSc counts with 32 bits."""

Positive = Field(gt=0.0, le=HUGE)
NotNegative = Field(ge=0.0, le=HUGE)
Finite = Field(ge=-HUGE, le=HUGE)

Moment = Annotated[EulerMoment, Positive]
Degree = Annotated[Literal[1, 2], BeforeValidator(whole)]
Count = Annotated[Whole, Field(ge=1, le=100_000)]
Flag = Annotated[bool, Field(strict=True)]

IdleKeys = Iterator[tuple[str, tuple[str, ...], str]]
"""Tables, their keys without effect, and the reasons."""


class Section(BaseModel):
    """A table of a case file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)

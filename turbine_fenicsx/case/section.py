"""Base of the tables of a case file: strictness, ranges, kinds of values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from turbine_fenicsx.case.quantities import EulerMoment, Whole, require_number
from turbine_fenicsx.case.rules import Rule
from turbine_fenicsx.foundation.text_files import quote

HUGE = 1e30
"""No number of a case is larger, so that products of a few of them are finite."""

MAX_ELEMENTS = 1_000_000
"""Elements of a blade or of a tower."""

Positive = Field(gt=0.0, le=HUGE)
NotNegative = Field(ge=0.0, le=HUGE)
Finite = Field(ge=-HUGE, le=HUGE)

Moment = Annotated[EulerMoment, Positive]
Degree = Annotated[Literal[1, 2], BeforeValidator(require_number)]
Count = Annotated[Whole, Field(ge=1, le=100_000)]
Flag = Annotated[bool, Field(strict=True)]


class Section(BaseModel):
    """A table of a case file; unknown keys are errors.

    Docstrings below the keys say what they mean. Marks in their types say when they count
    (`turbine_fenicsx.case.rules`) and which of them name files (`turbine_fenicsx.case.files`).
    Methods can be checks (`turbine_fenicsx.case.contradictions`).
    """

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    rules: ClassVar[tuple[Rule, ...]] = ()
    """When the table counts, except for the keys that the rules look at."""

    renamed: ClassVar[Mapping[str, str]] = {}
    """New names of keys by their old ones."""

    def find_doubts(self, case: Any) -> Iterator[str]:
        """Sentences about values that are allowed but probably not meant."""
        yield from ()


def check_names(value: Any) -> Any:
    """Names that a user gives to tables are plain words, which can be parts of names of columns."""
    for name in value if isinstance(value, dict) else ():
        if not (isinstance(name, str) and name.isascii() and name.isidentifier()):
            raise ValueError(
                "expected names of letters, digits and _ that begin with a letter, got "
                f"{quote(str(name))}"
            )
    return value

"""Keys of a case with numbers that are allowed, but of unusual size."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
from pydantic import BaseModel

from turbine_fenicsx.case.quantities import Unit, unit_of
from turbine_fenicsx.case.rules import find_unused_keys, resolve, walk_sections
from turbine_fenicsx.foundation.plausible import Plausible


def find_implausible_keys(case: BaseModel, skip: Collection[str] = ()) -> Iterator[str]:
    """A sentence for each key of a case that counts and has an unusual number.

    Args:
        skip: Dotted names of keys that are not judged.
    """
    unused = {key.name for key in find_unused_keys(case)}
    for name, section in walk_sections(case):
        above = name.split(".")
        if any(".".join(above[:n]) in unused for n in range(1, len(above) + 1)):
            continue
        for key, field in type(section).model_fields.items():
            own = resolve(key, name)
            marks = [mark for mark in field.metadata if isinstance(mark, Plausible)]
            if not marks or key not in section.model_fields_set or own in unused or own in skip:
                continue
            units = (mark.symbol for mark in field.metadata if isinstance(mark, Unit))
            unit = next(units, unit_of(field.annotation)) or ""
            found = marks[0].find_outliers(np.ravel(getattr(section, key)).tolist())
            if found:
                advice = f"a bare number counts in {unit}" if unit else "it has no unit"
                yield marks[0].describe(own, found[0], unit, advice)

"""Quantities of a study over a key of its cases, beside reference values."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.case.quantities import Unit, unit_of
from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.postprocessing.plot_style import put_prefix_into_label
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.records.number_tables import read_columns
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.picture import STYLE, name_and_unit
from turbine_fenicsx.study.plan import Run
from turbine_fenicsx.study.results import find_quantity
from turbine_fenicsx.turbine.case.case import Case

DEGREES = ("deg", "°")
"""Units of degrees in a head."""

LARGEST_REFERENCE = 100_000
"""Rows of a table of references; more are a slip."""


def read_reference(path: str, x: str, y: Sequence[str]) -> dict[str, tuple[Array, Array]]:
    """Places and values of each quantity that a table of references has.

    Args:
        path: CSV file whose head names its columns.
        x: Name of the column of the places.

    Returns:
        By quantity, as `plot_curve` shows them: angles in degrees with the signs of OpenFAST.
        Columns in degrees have these already.
    """
    found = read_columns(path, "table of references", (x,))
    rows = len(found[x])
    if rows > LARGEST_REFERENCE or not all(np.isfinite(values).all() for values in found.values()):
        raise InputError(
            f"the table of references {path!r} needs finite numbers in at most {LARGEST_REFERENCE} "
            f"rows, got {rows} rows"
        )
    columns = {}
    for name, values in found.items():
        short, unit = split_unit(name)
        columns[short] = values * (1.0 if unit in DEGREES else find_scale(short)[0])
    wanted = {name: split_unit(name)[0] for name in y}
    return {name: (found[x], columns[short]) for name, short in wanted.items() if short in columns}


def find_scale(quantity: str) -> tuple[float, str]:
    """Factor with which a quantity is shown, and its unit then; empty if it stays as it is.

    Args:
        quantity: A column of a history with or without its unit.
    """
    short, unit = split_unit(quantity)
    (joint,) = names.ANGLE.find([f"{short}_[rad]"]) or ("",)
    if not joint and unit != "rad":
        return 1.0, ""
    return OPENFAST_SIGNS.get(joint, 1.0) * 180.0 / np.pi, "°"


def _find_unit(key: str) -> str:
    """SI unit of a dotted key of a case, in brackets; empty if it has none."""
    kind: Any = Case
    marks: list[Any] = []
    for name in key.split("."):
        field = getattr(kind, "model_fields", {}).get(name)
        if field is None:
            return ""
        kind, marks = field.annotation, field.metadata
    known = (x.symbol if isinstance(x, Unit) else unit_of(x) for x in (*marks, kind))
    unit = next(filter(None, known), None)
    return f" [{unit}]" if unit else ""


def plot_curve(
    study: Study, runs: Sequence[Run], results: Mapping[str, Mapping[str, float]], path: Path
) -> None:
    """Draw one panel per quantity: the runs as dots, the references as a line.

    Args:
        results: Results of the finished ones by name.
    """
    import matplotlib
    from matplotlib.figure import Figure

    curve = study.curve
    assert curve is not None
    done = [run for run in runs if run.name in results]
    references = (
        read_reference(curve.reference, curve.x, curve.y) if curve.reference is not None else {}
    )
    with matplotlib.rc_context(STYLE):
        size = (4.2 * len(curve.y) + 0.4, 4.0)
        figure = Figure(figsize=size, layout="constrained")
        for k, name in enumerate(curve.y):
            axes = figure.add_subplot(1, len(curve.y), k + 1)
            if name in references:
                axes.plot(*references[name], color="#999999", lw=1.5, label=curve.label)
            full, degrees = name, ""
            if done:
                full = find_quantity(results[done[0].name], name)
                x = [float(run.value(curve.x)) for run in done]
                scale, degrees = find_scale(full)
                y = [scale * results[run.name][full] for run in done]
                axes.plot(x, y, "o", color=PALETTE[0], ms=5.0, label="this study", clip_on=False)
            title, unit = name_and_unit(full)
            unit = f" [{degrees}]" if degrees else unit
            x_words = re.sub("[._]", " ", curve.x)
            axes.set(title=title, xlabel=f"{x_words}{_find_unit(curve.x)}", ylabel=f"{title}{unit}")
            if all(np.min(line.get_ydata()) >= 0.0 for line in axes.lines):
                axes.set_ylim(bottom=0.0)
            put_prefix_into_label(axes)
            axes.legend()
        if study.title:
            figure.suptitle(study.title, x=0.01, ha="left")
        figure.savefig(path)

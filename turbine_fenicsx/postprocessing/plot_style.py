"""How diagrams look: colours, lines, units with prefixes, legends.

Colours distinguish quantities, line styles runs; where there is one quantity only, colours and
markers distinguish runs as well.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.records.names import TIME
from turbine_fenicsx.records.output_folder import TimeSeries

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
_LETTERS = 55
"""How many letters stand beside each other above a panel; a sample of a colour takes five."""

_UNITS = {"J": 12, "W": 12, "N": 12, "N m": 12, "N m s": 12, "m": 0}
"""Units that take a prefix, and the exponent of the largest."""


@dataclass(frozen=True)
class Look:
    """How a run appears in a panel.

    Args:
        style: Line style.
        marker: Marker of single points.
        color: Colour where there is one quantity only.
        alone: Whether it is the only run in the figure.
        tolerance: Height of a line in panels of changes per step [kJ, kNms]; None for none.
        relative_tolerance: That height as a part of the largest energy or momentum of the run.
        degrees: Angles in degrees instead of radians.
    """

    style: Any = "-"
    marker: str = "o"
    color: str = PALETTE[0]
    alone: bool = True
    tolerance: float | None = None
    relative_tolerance: float | None = None
    degrees: bool = True


def draw_line(axes: Any, run: TimeSeries, y: NDArray[np.float64], look: Look, **how: Any) -> None:
    """Draw a line over time; a single row, which would be invisible, becomes a point."""
    marker = look.marker if np.count_nonzero(np.isfinite(y)) == 1 else ""
    axes.plot(run[TIME], y, linestyle=look.style, marker=marker, **how)


def draw_dots(
    axes: Any,
    run: TimeSeries,
    values: NDArray[np.float64],
    look: Look,
    largest: float,
    unit: str,
    **how: Any,
) -> None:
    """Draw changes per step over many decades, and the tolerance; zeros are not shown.

    Args:
        values: Changes per step, shape (n_rows,).
        largest: Largest energy or momentum of the run.
    """
    shown = np.where(values > 0.0, values, np.nan)
    axes.set_yscale("log")
    axes.plot(run[TIME], shown, linestyle="", marker=look.marker, ms=2.0, mew=0.0, **how)
    if axes.texts:
        return
    if look.tolerance is not None:
        words = f"tolerance {format_power(look.tolerance)} k{unit}"
        _draw_tolerance(axes, 1e3 * look.tolerance, words)
    elif look.relative_tolerance is not None and largest > 0.0:
        words = f"tolerance {format_power(look.relative_tolerance)} of the largest"
        _draw_tolerance(axes, look.relative_tolerance * largest, words)


def _draw_tolerance(axes: Any, level: float, words: str) -> None:
    """A dashed line with words on it; the panel extends upwards until they have room."""
    axes.axhline(level, color="#333333", lw=1.0, ls=(0, (6, 3)))
    axes.annotate(
        words,
        (1.0, level),
        (-2.0, 3.0),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
        fontsize=9.0,
    )


def make_room(axes: Any) -> None:
    """Extend a logarithmic panel upwards until the words on the tolerance line have room."""
    if not axes.texts:
        return
    level = axes.texts[0].xy[1]
    bottom, top = np.log10(axes.get_ylim())
    axes.set_ylim(top=10.0 ** max(top, np.log10(level) + 0.1 * (top - bottom)))


def format_power(x: float) -> str:
    """A positive number as a power of ten."""
    mantissa, exponent = f"{x:.3g}".split("e") if "e" in f"{x:.3g}" else (f"{x:.3g}", "")
    if not exponent:
        return mantissa
    factor = "" if mantissa == "1" else rf"{mantissa} \times "
    return f"${factor}10^{{{int(exponent)}}}$"


def put_prefix_into_label(axes: Any) -> None:
    """Very small or large numbers: a prefix of the unit in the label, or a power of ten."""
    quantity, _, unit = axes.get_ylabel().removesuffix("]").rpartition("[")
    largest = max(abs(y) for y in axes.get_ylim())
    exponent = 3 * int(np.floor(np.log10(largest) / 3.0)) if largest > 0.0 else 0
    if unit in _UNITS and min(_PREFIXES) <= exponent <= _UNITS[unit]:
        new = _PREFIXES[exponent] + unit
    elif 1e-3 <= largest < 1e5:
        return
    else:
        new = f"$10^{{{exponent}}}$ {unit}"
    factor = 10.0**exponent
    axes.yaxis.set_major_formatter(lambda y, _: f"{y / factor:.6g}".replace("-", "\u2212"))
    axes.set_ylabel(f"{quantity}[{new}]")


def merge_equal_lines(axes: Any) -> None:
    """Let one line stand for all of a kind that coincide, such as pitch 1, 2, 3."""
    kept: list[tuple[Any, str]] = []
    for line in axes.get_lines():
        kind, _, number = line.get_label().rpartition(" ")
        if not (kind and number.isdecimal()):
            continue
        for other, its_kind in kept:
            if kind == its_kind and _coincide(line.get_data(), other.get_data()):
                other.set_label(f"{other.get_label()}, {number}")
                line.remove()
                break
        else:
            kept.append((line, kind))


def _coincide(a: Any, b: Any) -> bool:
    """Whether two lines are one to the eye."""
    (x, y), (u, v) = a, b
    size = np.nanmax(np.abs(y), initial=0.0)
    return len(x) == len(u) and np.allclose(y, v, rtol=0.0, atol=1e-6 * size, equal_nan=True)


def add_quantity_legend(axes: Any, names: Sequence[str]) -> None:
    """Legend above the panel, right of its title: colours of quantities, but not of runs."""
    from matplotlib.lines import Line2D

    handles, labels = axes.get_legend_handles_labels()
    unique = {n: handle for n, handle in zip(labels, handles, strict=True) if n not in names}
    if len(unique) > 1 or any(", " in name for name in unique):
        shown = [re.sub(r"\\\w+|[${}_^]", "", name) for name in unique]
        beside = _LETTERS - len(axes.get_title("left"))
        columns = next(n for n in range(len(shown), 0, -1) if n == 1 or _width(shown, n) <= beside)
        axes.legend(
            [Line2D([], [], color=handle.get_color(), lw=2.0) for handle in unique.values()],
            list(unique),
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=columns,
        )


def _width(names: Sequence[str], columns: int) -> int:
    """Letters beside each other in a legend, which is filled column after column."""
    parts = np.array_split(np.array([len(name) + 5 for name in names]), columns)
    return sum(int(part.max()) for part in parts)


def add_run_legend(figure: Any, runs: Sequence[TimeSeries], looks: Sequence[Look]) -> None:
    """Legend at the top of the figure: line styles of runs, and markers where a panel has them."""
    from matplotlib.lines import Line2D

    names = [run.name for run in runs]
    shown_lines = [line.get_label() for axes in figure.axes for line in axes.get_lines()]
    by_color = all(label in names or label.startswith("_") for label in shown_lines)
    lines_of_runs = (x for axes in figure.axes for x in axes.get_lines() if x.get_label() in names)
    marked = any(line.get_marker() not in ("", "None") for line in lines_of_runs)
    lines = [
        Line2D(
            [],
            [],
            color=look.color if by_color else "#333333",
            linestyle=look.style,
            marker=look.marker if marked else "",
            markerfacecolor=look.color,
            markeredgecolor=look.color,
            markersize=5.0,
        )
        for look in looks
    ]
    width, height = figure.get_size_inches()
    entry = 0.65 + 0.075 * max(len(name) for name in names)  # about its width [in]
    columns = int(np.clip(width / entry, 1, len(runs)))
    # set as texts, since a label means something to Matplotlib: _ hides it, $ makes it a formula
    legend = figure.legend(
        lines, ["run"] * len(lines), loc="upper center", ncols=columns, handlelength=3.5
    )
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_parse_math(False)
        text.set_text(name)
    above = 0.1 + 0.17 * -(-len(runs) // columns)
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - above / height))

"""Diagrams of runs, drawn from their ``history.csv`` alone.

Which joint angles and tips there are differs between models and is found in the header of the file.
Colours tell quantities apart, line styles runs; where there is one quantity only, colours and
markers tell runs apart as well. Matplotlib is an extra and is imported when a figure is drawn.
Figures are made without pyplot, so that nothing global changes and no display is needed.
"""

import os
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.errors import InputError
from turbine_fenicsx.output_folder import TimeSeries, read_history

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of Okabe and Ito, which colour-blind readers can tell apart."""

PAPER_TOLERANCE = 1e-7
"""Of the paper's Newton iterations; its figures compare changes per step with it [kJ, kNms]."""

_LINE_STYLES = ("-", "--", ":", "-.", (0, (8, 2)), (0, (3, 1, 1, 1, 1, 1)))
_MARKERS = ("o", "s", "^", "D", "v", "P")
_STYLE = {
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.limits": (-3, 5),
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "legend.borderpad": 0.0,
    "legend.borderaxespad": 0.3,
    "legend.columnspacing": 1.0,
    "legend.handlelength": 1.2,
    "legend.handletextpad": 0.5,
    "pdf.fonttype": 42,  # outlines of letters that journals accept
    "savefig.dpi": 200,
}


@dataclass(frozen=True)
class Look:
    """How a run appears in a panel.

    Args:
        style: Line style.
        marker: Marker of single points.
        color: Colour where there is one quantity only.
        alone: Whether it is the only run in the figure.
        tolerance: Height of the tolerance line [kJ, kNms].
        degrees: Angles in degrees instead of radians.
    """

    style: Any = "-"
    marker: str = "o"
    color: str = PALETTE[0]
    alone: bool = True
    tolerance: float = PAPER_TOLERANCE
    degrees: bool = False


Panel = Callable[[Any, TimeSeries, Look], None]


def figures(runs: Sequence[TimeSeries]) -> dict[str, tuple[Panel, ...]]:
    """The diagrams that runs have something to show in: name of the figure to its panels."""
    found: dict[str, tuple[Panel, ...]] = {
        "energy": (_energies, _small_energies, _energy_steps, _energy_error),
        "angular_momentum": (_angular_momentum, _momentum_steps),
        "angles": (_angles,),
    }
    if any(run.named("tip_deflection_") for run in runs):
        found["tip_deflections"] = (_tip_deflections,)
    return found


def draw(
    runs: Sequence[TimeSeries],
    panels: Sequence[Panel],
    paths: Iterable[str | os.PathLike[str]],
    *,
    tolerance: float = PAPER_TOLERANCE,
    degrees: bool = False,
) -> list[Path]:
    """Draw runs on top of each other in panels, two side by side, and save the figure.

    Args:
        runs: Time series, at most six.
        panels: Panels, for example from `figures`.
        paths: Files to write; the suffix decides the format (png, pdf, svg).
        tolerance: Height of the tolerance line [kJ, kNms].
        degrees: Angles in degrees instead of radians.

    Returns:
        The files.

    Raises:
        ImportError: if Matplotlib is missing.
        InputError: if there are too many runs, a column is missing or a file cannot be written.
    """
    if len(runs) > len(PALETTE):
        raise InputError(f"{len(runs)} runs are too many for one figure, {len(PALETTE)} fit")
    try:
        with warnings.catch_warnings():
            # A second Matplotlib, from the system, makes the 3D axes unusable; none are used.
            warnings.filterwarnings("ignore", message="Unable to import Axes3D")
            import matplotlib
            from matplotlib.figure import Figure
    except ImportError:
        raise ImportError("figures need Matplotlib: pip install matplotlib") from None
    looks = [
        Look(style, marker, color, len(runs) == 1, tolerance, degrees)
        for style, marker, color in zip(_LINE_STYLES, _MARKERS, PALETTE, strict=True)
    ][: len(runs)]
    n_columns = min(2, len(panels))
    n_rows = -(-len(panels) // n_columns)
    start = min(run["time_[s]"][0] for run in runs)
    end = max(run["time_[s]"][-1] for run in runs)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(4.6 * n_columns, 2.9 * n_rows), layout="constrained")
        for i, panel in enumerate(panels):
            axes = figure.add_subplot(n_rows, n_columns, i + 1)
            for run, look in zip(runs, looks, strict=True):
                panel(axes, run, look)
            axes.set_xlabel("time [s]")
            if end > start:
                axes.set_xlim(start, end)
            if axes.get_yscale() == "log":
                _room_above(axes, tolerance)
            else:
                _factor_into_label(axes)
            _quantity_legend(axes, [run.name for run in runs])
        if len(runs) > 1:
            _run_legend(figure, runs, looks)
        for path in paths:
            try:
                figure.savefig(path)
            except OSError as error:
                raise InputError(
                    f"cannot write {os.fspath(path)!r}: {error.strerror or error}"
                ) from None
    return [Path(path) for path in paths]


def plot_summary(csv_path: str | os.PathLike[str], png: str | os.PathLike[str]) -> Path:
    """Draw the energies and the joint angles of one run.

    Args:
        csv_path: The ``history.csv`` of the run.
        png: Picture to write.

    Returns:
        ``png``.

    Raises:
        ImportError: if Matplotlib is missing.
        InputError: if a file cannot be read or written, holds no rows or lacks a column.
    """
    return draw([read_history(csv_path)], [_energies, _angles], [png])[0]


def _room_above(axes: Any, tolerance: float) -> None:
    """Extend a logarithmic panel upwards until the words on the tolerance line have room."""
    bottom, top = np.log10(axes.get_ylim())
    axes.set_ylim(top=10.0 ** max(top, np.log10(tolerance) + 0.1 * (top - bottom)))


def _factor_into_label(axes: Any) -> None:
    """Very small or large numbers: the power of ten goes into the brackets of the unit."""
    largest = max(abs(y) for y in axes.get_ylim())
    if 1e-3 <= largest < 1e5:
        return
    exponent = 3 * int(np.floor(np.log10(largest) / 3.0))
    axes.yaxis.set_major_formatter(lambda y, _: f"{y / 10.0**exponent:g}".replace("-", "\u2212"))
    quantity, unit = axes.get_ylabel().rsplit("[", 1)
    axes.set_ylabel(f"{quantity}[$10^{{{exponent}}}$ {unit}")


def _quantity_legend(axes: Any, names: Sequence[str]) -> None:
    """Legend above the panel, right of its title: colours of quantities, but not of runs."""
    from matplotlib.lines import Line2D

    handles, labels = axes.get_legend_handles_labels()
    unique = {n: line for n, line in zip(labels, handles, strict=True) if n not in names}
    if len(unique) > 1:
        axes.legend(
            [Line2D([], [], color=line.get_color(), lw=2.0) for line in unique.values()],
            list(unique),
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=len(unique) if len(unique) < 5 else 3,
        )


def _run_legend(figure: Any, runs: Sequence[TimeSeries], looks: Sequence[Look]) -> None:
    """Legend at the top of the figure: line styles of runs, and markers where a panel has them."""
    from matplotlib.lines import Line2D

    names = [run.name for run in runs]
    marked = any(line.get_label() in names for axes in figure.axes for line in axes.get_lines())
    lines = [
        Line2D(
            [],
            [],
            color="#333333",
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
    figure.legend(lines, names, loc="upper center", ncols=columns, handlelength=3.5)
    above = 0.1 + 0.17 * -(-len(runs) // columns)
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - above / height))


def _line(axes: Any, run: TimeSeries, y: NDArray[np.float64], look: Look, **how: Any) -> None:
    """A line over time; a single row, which would be invisible, becomes a point."""
    marker = look.marker if len(y) == 1 else ""
    axes.plot(run["time_[s]"], y, linestyle=look.style, marker=marker, **how)


def _dots(axes: Any, run: TimeSeries, values: NDArray[np.float64], look: Look, **how: Any) -> None:
    """Changes per step over many decades with the tolerance; zeros are not shown."""
    shown = np.where(values > 0.0, values, np.nan)
    axes.set_yscale("log")
    axes.plot(run["time_[s]"], shown, linestyle="", marker=look.marker, ms=2.0, mew=0.0, **how)
    if not axes.texts:
        axes.axhline(look.tolerance, color="#333333", lw=1.0, ls=(0, (6, 3)))
        axes.annotate(
            f"tolerance {_power(look.tolerance)}",
            (1.0, look.tolerance),
            (-2.0, 3.0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            ha="right",
            fontsize=9.0,
        )


def _power(x: float) -> str:
    """A positive number as a power of ten."""
    mantissa, exponent = f"{x:.3g}".split("e") if "e" in f"{x:.3g}" else (f"{x:.3g}", "")
    if not exponent:
        return mantissa
    factor = "" if mantissa == "1" else rf"{mantissa} \times "
    return f"${factor}10^{{{int(exponent)}}}$"


def _energies(axes: Any, run: TimeSeries, look: Look) -> None:
    """Total energy and its parts [kJ]."""
    _line(axes, run, _energy(run, "total"), look, color="black", lw=2.4, label="total")
    for name, color in zip(("kinetic", "strain", "potential"), PALETTE, strict=False):
        _line(axes, run, _energy(run, name), look, color=color, label=name)
    axes.set(title="Energies", ylabel="energy [kJ]")


def _small_energies(axes: Any, run: TimeSeries, look: Look) -> None:
    """Strain and potential energy on a scale of their own [kJ]."""
    for name, color in zip(("strain", "potential"), PALETTE[1:], strict=False):
        _line(axes, run, _energy(run, name), look, color=color, label=name)
    axes.set(title="Strain and potential", ylabel="energy [kJ]")


def _energy(run: TimeSeries, name: str) -> NDArray[np.float64]:
    """An energy [kJ]; the potential counts from where it starts, which may be far below zero."""
    energy = run[f"{name}_energy_[J]"]
    if name in ("total", "potential"):
        energy = energy - run["potential_energy_[J]"][:1].sum()  # nothing of a run of no steps
    return energy / 1e3


def _energy_steps(axes: Any, run: TimeSeries, look: Look) -> None:
    """What each step adds to the energy beyond the work of the loads [kJ]."""
    change = np.diff(run["total_energy_[J]"] - run["external_work_[J]"], prepend=np.nan)
    _dots(axes, run, np.abs(change) / 1e3, look, color=look.color, label=run.name)
    axes.set(title="Energy error per step", ylabel=r"$|\Delta H - \Delta W|$ [kJ]")


def _energy_error(axes: Any, run: TimeSeries, look: Look) -> None:
    """Total energy minus initial energy minus work [kJ]."""
    error = run["energy_error_[J]"] / 1e3
    _line(axes, run, error, look, color=look.color, label=run.name)
    axes.set(title="Energy error since the start", ylabel=r"$H - H_0 - W$ [kJ]")


def _angles(axes: Any, run: TimeSeries, look: Look) -> None:
    """Joint angles [rad] or [deg]."""
    unit, factor = ("°", 180.0 / np.pi) if look.degrees else ("rad", 1.0)
    for (name, angle), color in zip(run.named("angle_").items(), PALETTE * 9, strict=False):
        _line(axes, run, factor * angle, look, color=color, label=name.replace("_", " "))
    axes.set(title="Joint angles", ylabel=f"angle [{unit}]")


def _angular_momentum(axes: Any, run: TimeSeries, look: Look) -> None:
    """Angular momentum about the origin [kNms]."""
    for axis, color in zip("123", PALETTE, strict=False):
        values = run[f"angular_momentum_{axis}_[Nms]"] / 1e3
        _line(axes, run, values, look, color=color, label=f"$L_{axis}$")
    axes.set(title="Angular momentum", ylabel="about the origin [kNms]")


def _momentum_steps(axes: Any, run: TimeSeries, look: Look) -> None:
    """What each step adds to the angular momentum [kNms].

    The tower holds nacelle and weights, so that only the vertical component has to stay; of
    several runs it is the only one shown.
    """
    for axis, color in zip("123", PALETTE, strict=False):
        if look.alone or axis == "2":
            change = np.diff(run[f"angular_momentum_{axis}_[Nms]"], prepend=np.nan) / 1e3
            how = {"color": color, "label": rf"$\Delta L_{axis}$"}
            if not look.alone:
                how = {"color": look.color, "label": run.name}
            _dots(axes, run, np.abs(change), look, **how)
    shown = "i" if look.alone else "2"
    axes.set(title="Change per step", ylabel=rf"$|\Delta L_{shown}|$ [kNms]")


def _tip_deflections(axes: Any, run: TimeSeries, look: Look) -> None:
    """Deflections of the blade tips in their root frames [m]."""
    tips = run.named("tip_deflection_")
    for (name, tip), color in zip(tips.items(), PALETTE * 9, strict=False):
        _line(axes, run, tip, look, color=color, label=f"blade {name}")
    axes.set(title="Tip deflections", ylabel="in the root frame [m]")

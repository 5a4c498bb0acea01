"""Figures of a run, drawn from its ``history.csv`` alone.

Columns are named ``quantity_[unit]``; which joint angles and tips there are differs between models
and is found in the header. Matplotlib is an extra and is imported when a figure is drawn. Figures
are made without pyplot, so that nothing global changes and no display is needed.
"""

import csv
import os
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of Okabe and Ito, which colour-blind readers can tell apart."""

_LINE_STYLES = ("-", "--", ":", "-.")
_STYLE = {
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
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
    "savefig.dpi": 200,
}
_COLUMN = re.compile(r"(?P<quantity>.+)_\[(?P<unit>.+)\]$")


@dataclass(frozen=True)
class TimeSeries:
    """Time series of one run.

    Args:
        name: Shown in legends when several runs share a figure.
        columns: Column of ``history.csv`` to its values, each of shape (n_rows,).
    """

    name: str
    columns: dict[str, NDArray[np.float64]]

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """Values of one column, shape (n_rows,)."""
        if column not in self.columns:
            raise ValueError(f"history of '{self.name}' has no column '{column}'")
        return self.columns[column]

    def named(self, start: str) -> dict[str, NDArray[np.float64]]:
        """Columns whose name begins with ``start``, under the rest of their name, without unit."""
        found = {}
        for column, values in self.columns.items():
            match = _COLUMN.match(column)
            if match and match["quantity"].startswith(start):
                found[match["quantity"].removeprefix(start)] = values
        return found


def read_history(path: str | os.PathLike[str]) -> TimeSeries:
    """Read ``history.csv``; a last row that a crash has cut off is left out.

    Args:
        path: CSV file with one header line; empty fields become NaN.

    Returns:
        The time series, named after the folder of the file.

    Raises:
        OSError: if the file cannot be read.
        ValueError: if it holds no complete row, or something else than numbers.
    """
    path = Path(path)
    with open(path, newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    header = lines[0] if lines else []
    rows = [line for line in lines[1:] if len(line) == len(header)]
    if not rows:
        raise ValueError(f"{path} holds no rows")
    try:
        values = np.array([[float(x) if x.strip() else np.nan for x in row] for row in rows])
    except ValueError as problem:
        raise ValueError(f"{path}: {problem}") from None
    columns = {name.strip(): values[:, i] for i, name in enumerate(header)}
    return TimeSeries(path.resolve().parent.name, columns)


def plot_history(
    csv_paths: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out_path: str | os.PathLike[str],
) -> Path:
    """Draw energies, conservation, angles, angular momentum and tip deflections of runs.

    Args:
        csv_paths: One ``history.csv`` or several, which then differ by line style.
        out_path: Figure; its suffix decides the format (png, pdf, svg).

    Returns:
        ``out_path``.

    Raises:
        ImportError: if Matplotlib is missing.
        OSError: if a file cannot be read or written.
        ValueError: if a file holds no rows or lacks a column.
    """
    if isinstance(csv_paths, str | os.PathLike):
        csv_paths = [csv_paths]
    runs = [read_history(path) for path in csv_paths]
    panels = [_energies, _energy_steps, _energy_error, _angles, _angular_momentum]
    if any(run.named("tip_deflection_") for run in runs):
        panels.append(_tip_deflections)
    else:
        panels.append(_constraint_error)
    return _draw(runs, panels, out_path, n_columns=2)


def plot_summary(csv_path: str | os.PathLike[str], png: str | os.PathLike[str]) -> Path:
    """Draw the energies and the joint angles of one run.

    Args:
        csv_path: The ``history.csv`` of the run.
        png: Picture to write.

    Returns:
        ``png``.

    Raises:
        ImportError: if Matplotlib is missing.
        OSError: if a file cannot be read or written.
        ValueError: if the history holds no rows or lacks a column.
    """
    return _draw([read_history(csv_path)], [_energies, _angles], png, n_columns=2)


def _draw(
    runs: Sequence[TimeSeries],
    panels: Sequence[Callable[[Any, TimeSeries, str, str], None]],
    out: str | os.PathLike[str],
    n_columns: int,
) -> Path:
    """Lay out panels, draw every run in each, save."""
    try:
        with warnings.catch_warnings():
            # A second Matplotlib, from the system, makes the 3D axes unusable; none are used.
            warnings.filterwarnings("ignore", message="Unable to import Axes3D")
            import matplotlib
            from matplotlib.figure import Figure
            from matplotlib.lines import Line2D
    except ImportError:
        raise ImportError("figures need Matplotlib: pip install matplotlib") from None
    n_rows = -(-len(panels) // n_columns)
    styles = [_LINE_STYLES[i % len(_LINE_STYLES)] for i in range(len(runs))]
    start = min(run["time_[s]"][0] for run in runs)
    end = max(run["time_[s]"][-1] for run in runs)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(4.6 * n_columns, 2.9 * n_rows), layout="constrained")
        for i, panel in enumerate(panels):
            axes = figure.add_subplot(n_rows, n_columns, i + 1)
            for run, style, color in zip(runs, styles, PALETTE * len(runs), strict=False):
                panel(axes, run, style, color)
            axes.set_xlabel("time [s]")
            if end > start:
                axes.set_xlim(start, end)
            handles, labels = axes.get_legend_handles_labels()
            unique = dict(zip(labels, handles, strict=True))
            if len(unique) > 1:
                axes.legend(
                    [Line2D([], [], color=line.get_color(), lw=2.0) for line in unique.values()],
                    list(unique),
                    loc="lower right",
                    bbox_to_anchor=(1.0, 1.0),
                    ncols=len(unique) if len(unique) < 5 else 3,
                )
        if len(runs) > 1:
            lines = [Line2D([], [], color="#333333", linestyle=style) for style in styles]
            names = [run.name for run in runs]
            figure.legend(lines, names, loc="upper center", ncols=4, handlelength=3.0)
            above = 0.12 + 0.17 * -(-len(runs) // 4)
            figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - above / (2.9 * n_rows)))
        figure.savefig(out)
    return Path(out)


def _energies(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """Total energy and its parts [kJ]."""
    t = run["time_[s]"]
    axes.plot(t, run["total_energy_[J]"] / 1e3, style, color="black", lw=2.4, label="total")
    for name, part_color in zip(("kinetic", "strain", "potential"), PALETTE, strict=False):
        axes.plot(t, run[f"{name}_energy_[J]"] / 1e3, style, color=part_color, label=name)
    axes.set(title="Energies", ylabel="energy [kJ]")


def _energy_steps(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """What each step adds to the energy beyond the work of the loads [J]."""
    change = np.abs(np.diff(run["total_energy_[J]"] - run["external_work_[J]"]))
    _dots(axes, run, np.concatenate([[0.0], change]), color)
    axes.set(title="Energy error per step", ylabel=r"$|\Delta H - \Delta W|$ [J]")


def _energy_error(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """Total energy minus initial energy minus work [J]."""
    axes.plot(run["time_[s]"], run["energy_error_[J]"], color=color, label=run.name)
    axes.set(title="Energy error", ylabel=r"$H - H_0 - W$ [J]")


def _angles(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """Joint angles [rad]."""
    for (name, angle), own_color in zip(run.named("angle_").items(), PALETTE * 9, strict=False):
        axes.plot(run["time_[s]"], angle, style, color=own_color, label=name.replace("_", " "))
    axes.set(title="Joint angles", ylabel="angle [rad]")


def _angular_momentum(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """Angular momentum about the origin [kNms]."""
    for axis, own_color in zip("123", PALETTE, strict=False):
        values = run[f"angular_momentum_{axis}_[Nms]"] / 1e3
        axes.plot(run["time_[s]"], values, style, color=own_color, label=f"$L_{axis}$")
    axes.set(title="Angular momentum", ylabel="about the origin [kNms]")


def _tip_deflections(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """Deflections of the blade tips in their root frames [m]."""
    tips = run.named("tip_deflection_")
    for (name, tip), own_color in zip(tips.items(), PALETTE * 9, strict=False):
        axes.plot(run["time_[s]"], tip, style, color=own_color, label=f"blade {name}")
    axes.set(title="Tip deflections", ylabel="in the root frame [m]")


def _constraint_error(axes: Any, run: TimeSeries, style: str, color: str) -> None:
    """Largest violation of a constraint [-]."""
    _dots(axes, run, run["constraint_error_[-]"], color)
    axes.set(title="Constraint error", ylabel="largest violation [-]")


def _dots(axes: Any, run: TimeSeries, values: NDArray[np.float64], color: str) -> None:
    """Values over many decades; zeros are not shown."""
    shown = np.where(values > 0.0, values, np.nan)
    axes.plot(run["time_[s]"], shown, ".", ms=2.5, mew=0.0, color=color, label=run.name)
    if np.isfinite(shown).any():
        axes.set_yscale("log")

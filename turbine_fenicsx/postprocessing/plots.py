"""Diagrams of runs, drawn from their ``history.csv`` alone.

Which joint angles, tips and loads there are differs between models and is found in the header of
the file. Matplotlib is an extra and is imported when a figure is drawn. Figures are made without
pyplot, so that nothing global changes and no display is needed.
"""

import os
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from turbine_fenicsx.foundation.diagram_style import LINE_STYLES, MARKERS, PALETTE, STYLE
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import failure_panels as f
from turbine_fenicsx.postprocessing import panels as p
from turbine_fenicsx.postprocessing import power_balance
from turbine_fenicsx.postprocessing import wind_panels as w
from turbine_fenicsx.postprocessing.matplotlib_figures import import_matplotlib, save_figure
from turbine_fenicsx.postprocessing.panels import Panel
from turbine_fenicsx.postprocessing.plot_style import (
    Look,
    add_quantity_legend,
    add_run_legend,
    make_room,
    merge_equal_lines,
    put_prefix_into_label,
)
from turbine_fenicsx.records import names
from turbine_fenicsx.records.names import Family
from turbine_fenicsx.records.output_folder import TimeSeries, read_history

__all__ = ["PALETTE", "PAPER_TOLERANCE", "Look", "Panel", "choose_figures", "draw", "plot_summary"]

MOST_IN_TWO = 8
"""Panels that stand two side by side; more of them would be a strip."""

PAPER_TOLERANCE = 1e-7
"""Of the paper's Newton iterations; its figures compare changes per step with it [kJ, kNms]."""


def choose_figures(runs: Sequence[TimeSeries]) -> dict[str, tuple[Panel, ...]]:
    """The diagrams that runs have something to show in: name of the figure to its panels.

    Loads come first, and energies last.
    """

    def some(family: Family, **fields: object) -> bool:
        return any(run.of(family, **fields) for run in runs)

    found: dict[str, tuple[Panel, ...]] = {}
    if some(names.ROOT_MOMENT, axis="y"):
        found["root_moments"] = (p.root_flap, p.root_edge)
    if some(names.TIP_FLAP):
        found["tip_deflections"] = (p.tip_flap, p.tip_edge)
    elif some(names.TIP_DEFLECTION):
        found["tip_deflections"] = (p.tip_length,)
    if all(run.of(names.TOWER_TOP_DISPLACEMENT) for run in runs):
        found["tower"] = (p.tower_top, p.tower_base)
    if all(f.find_indices(run)[1] for run in runs):
        found["failure"] = (f.largest_index, f.worst_place)
    turbines = all(p.is_turbine(run) for run in runs)
    in_wind = turbines and all(w.has_wind(run) for run in runs)
    if in_wind:
        found["wind"] = w.choose_wind_panels(runs[0])
    if turbines:
        angles = (p.rotor_angle, p.yaw if w.pitch in found.get("wind", ()) else p.yaw_and_pitch)
        found["angles"] = angles if in_wind else (p.rotor_speed, *angles)
        if any(p.other_joints(run) for run in runs):
            found["angles"] = (*found["angles"], p.joint_angles)
    elif some(names.ANGLE):
        found["angles"] = (p.joint_angles,)
    if some(names.DISPLACEMENT):
        found["displacements"] = (p.displacements,)
    if any(power_balance.has_power_balance(run) for run in runs):
        terms = power_balance.choose_terms(runs)
        charts = (power_balance.powers, power_balance.works)
        found["power_balance"] = tuple(partial(chart, terms=terms) for chart in charts)
    found["energy"] = (p.energies, p.small_energies, p.energy_steps, p.energy_error)
    found["angular_momentum"] = (p.angular_momentum, p.momentum_steps)
    return found


def draw(
    runs: Sequence[TimeSeries],
    panels: Sequence[Panel],
    paths: Iterable[str | os.PathLike[str]],
    *,
    tolerance: float | None = None,
    relative_tolerance: float | None = None,
    degrees: bool = True,
    title: str = "",
) -> list[Path]:
    """Draw runs on top of each other in panels, two to four side by side, and save the figure.

    Args:
        runs: Time series, at most six.
        panels: Panels, for example from `choose_figures`.
        paths: Files to write; the suffix decides the format (png, pdf, svg).
        tolerance: Height of a line in panels of changes per step [kJ, kNms], for example
            `PAPER_TOLERANCE`; None for none.
        relative_tolerance: That height as a part of the largest energy or momentum of the first
            run.
        degrees: Angles in degrees instead of radians.
        title: Title of the figure.

    Returns:
        The files.

    Raises:
        ImportError: if Matplotlib is missing.
        InputError: if there are too many runs, a column is missing or a file cannot be written.
    """
    if len(runs) > len(PALETTE):
        raise InputError(f"{len(runs)} runs are too many for one figure, {len(PALETTE)} fit")
    matplotlib, Figure = import_matplotlib()
    looks = [
        Look(style, marker, color, len(runs) == 1, tolerance, relative_tolerance, degrees)
        for style, marker, color in zip(LINE_STYLES, MARKERS, PALETTE, strict=True)
    ][: len(runs)]
    with matplotlib.rc_context(STYLE):
        figure = _compose(Figure, runs, panels, looks, title)
        for path in paths:
            save_figure(figure, path)
    return [Path(path) for path in paths]


def _compose(
    Figure: Any,
    runs: Sequence[TimeSeries],
    panels: Sequence[Panel],
    looks: Sequence[Look],
    title: str = "",
) -> Any:
    """A figure of panels, two to four side by side, with their axes and legends."""
    n_columns = min(len(panels), 2 if len(panels) <= MOST_IN_TWO else 3 + (len(panels) > 15))
    n_rows = -(-len(panels) // n_columns)
    start = min(run[names.TIME][0] for run in runs)
    end = max(run[names.TIME][-1] for run in runs)
    size = (4.6 * n_columns, 2.9 * n_rows)
    figure = Figure(figsize=size, dpi=STYLE["savefig.dpi"], layout="constrained")
    for i, panel in enumerate(panels):
        axes = figure.add_subplot(n_rows, n_columns, i + 1)
        for run, look in zip(runs, looks, strict=True):
            panel(axes, run, look)
        axes.set_xlabel("time [s]")
        if end > start:
            axes.set_xlim(start, end)
        if axes.get_yscale() == "log":
            make_room(axes)
        else:
            put_prefix_into_label(axes)
        if len(runs) == 1:
            merge_equal_lines(axes)
        add_quantity_legend(axes, [run.name for run in runs])
    if len(runs) > 1:
        add_run_legend(figure, runs, looks)
    elif title:
        figure.suptitle(title, x=0.01, ha="left", parse_math=False)
    # once, instead of for each file, which would also be drawn twice for it
    figure.get_layout_engine().execute(figure)
    figure.set_layout_engine(None)
    return figure


def plot_summary(
    csv_path: str | os.PathLike[str], png: str | os.PathLike[str], title: str = ""
) -> Path:
    """Draw what one looks at first: root moments, tips, rotor speed or angles, energies.

    In wind these are the wind itself, root moments and tips or thrust and torque, power, rotor
    speed and pitch.
    """
    run = read_history(csv_path)
    loads: list[Panel] = [p.root_flap] if run.of(names.ROOT_MOMENT, axis="y") else []
    loads += [p.tip_flap] if run.of(names.TIP_FLAP) else []
    if w.has_wind(run) and p.is_turbine(run):
        further = [panel for panel in w.choose_wind_panels(run) if panel is not w.hub_wind]
        less = (w.thrust, w.torque)[: len(loads)]
        shown = [w.hub_wind, *loads, *(panel for panel in further if panel not in less)]
    elif p.is_turbine(run):
        pitches = any(name.startswith("pitch") for name in run.of(names.ANGLE))
        angles = [p.rotor_angle, *([p.yaw_and_pitch] if pitches else [])]
        shown = [*loads, p.rotor_speed, *([] if loads else angles), p.energies]
    else:
        shown = [*([p.joint_angles] if run.of(names.ANGLE) else []), p.energies]
    return draw([run], shown, [png], title=title)[0]

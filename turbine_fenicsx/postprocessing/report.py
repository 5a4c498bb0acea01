"""A run as one HTML page that needs no other file and no network.

Everything is read from the output folder. The page leaves out what is missing or cannot be drawn,
and says so; only ``history.csv`` is needed.
"""

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.fatigue import (
    FREQUENCY,
    GLASS_SLOPE,
    STEEL_SLOPE,
    find_fatigue,
    list_loads,
)
from turbine_fenicsx.postprocessing.life_page import format_life
from turbine_fenicsx.postprocessing.page import (
    embed_figure,
    fill_page,
    format_case,
    format_grid,
    format_label,
    format_note,
    format_tables,
    group_tables,
)
from turbine_fenicsx.postprocessing.panels import (
    ROUND_OFF,
    find_energy_steps,
    find_largest_energy,
    is_turbine,
)
from turbine_fenicsx.postprocessing.pictures import Look, find_nearest_step, render_times
from turbine_fenicsx.postprocessing.plots import choose_figures, draw
from turbine_fenicsx.postprocessing.worst_section import format_worst
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.records.names import split_unit
from turbine_fenicsx.records.output_folder import (
    TimeSeries,
    find_fields,
    need_folder,
    read_field_times,
    read_histories,
    read_solver_tolerance,
    read_tables,
)
from turbine_fenicsx.records.statistics import read_statistics
from turbine_fenicsx.records.worst_ply import find_worst_ply

_CAPTIONS = {
    "energy": "Energies; the error is the change of the total energy H beyond the work W of the "
    "loads and the dissipation D of dampers and the like. The dashed line is the tolerance of the "
    "solver times the largest energy.",
    "power_balance": "Power that forces bring in is above zero; power that they, the generator and "
    "losses take out is below. Energy stored in motion, height and strain goes out and comes back.",
    "wind": "The wind at the hub and what the rotor makes of it: power and torque of the air about "
    "the shaft, thrust along it, and the mechanical power of the generator; means of each step.",
    "angular_momentum": "Angular momentum about the origin. The tower of a turbine holds the "
    "horizontal components; the vertical one, L2, changes by the yaw torque alone.",
    "angles": "Angles and speeds of the joints; yaw and pitch of a turbine in the signs of "
    "OpenFAST.",
    "displacements": "Displacements of sliding joints.",
    "tip_deflections": "Deflections of the blade tips in the frames of what carries their roots.",
    "root_moments": "Moments of the blades on what carries their roots, means of each step.",
    "failure": "Failure index of the plies, in all blades, and the place of the largest.",
    "tower": "Displacement of the tower top, and moments of the tower on the ground.",
}
_SIZE = (1280, 960)
"""Of the pictures [pixels]."""


def report(
    folder: str | os.PathLike[str],
    times: Sequence[float] | None = None,
    scale: float = 1.0,
    pictures: bool = True,
    describe: Callable[[Mapping[str, Any]], Mapping[str, Any]] = dict,
    note: str = "",
) -> str:
    """Describe a run.

    Args:
        times: Times of the pictures [s]; four of the whole run if None.
        scale: Factor of the deformation in the pictures.
        describe: Makes the tables of the page from those of ``case.json``.
        note: HTML that comes before the moment nearest to failure.
    """
    folder = need_folder(folder)
    (history,) = read_histories([folder])
    summary, case = (read_tables(folder / f"{name}.json") for name in ("summary", "case"))
    title = str((case or {}).get("title") or history.name)
    end = history[names.TIME][-1]
    versions = dict((summary or {}).pop(names.VERSIONS, {}) if summary else {})
    warnings = (summary or {}).pop(names.WARNINGS, [])
    sections = {
        "Key figures": "".join(f"<p class='warning'>{escape(w)}</p>\n" for w in warnings)
        + format_tables({"": _find_key_figures(history)}),
        "Nearest to failure": note + format_worst(folder),
        "Life of the plies": format_life(folder),
        "Case": format_case(case, describe),
        "Diagrams": _draw_diagrams(history, read_solver_tolerance(folder)),
        "Statistics": _format_statistics(folder),
        "Fatigue": _format_fatigue(history),
        "Pictures": _draw_pictures(folder, times, Look(scale=scale, size=_SIZE))
        if pictures
        else "",
        "Model and results": format_tables(group_tables(summary, "run"))
        if summary
        else format_note("There is no summary.json: the run has not come to its end."),
        "Versions": format_tables({"": versions}, str) if versions else "",
    }
    return fill_page(
        title,
        f"{folder.resolve().name}, {len(history[names.TIME]) - 1} steps to t = {end:g} s",
        sections,
    )


def _find_key_figures(history: TimeSeries) -> dict[str, Any]:
    """Key numbers of a run."""
    error = np.abs(history[names.ENERGY_ERROR])
    steps = np.abs(find_energy_steps(history)[1:])
    largest = find_largest_energy(history)
    found = {
        "largest energy [MJ]": largest / 1e6,
        "largest energy error [J]": float(np.nanmax(error)),
        "... of the largest energy": float(np.nanmax(error)) / max(largest, 1e-300),
        "largest energy error of a step [J]": float(np.nanmax(steps, initial=0.0)),
    }
    tips = history.of(names.TIP_DEFLECTION)
    if tips:
        found["largest tip deflection [m]"] = float(max(np.nanmax(tip) for tip in tips.values()))
    moments = {
        "largest flap moment at a root [MN m]": history.of(names.ROOT_MOMENT, axis="y"),
        "largest fore-aft moment at the tower base [MN m]": history.of(names.TOWER_BASE_MOMENT),
    }
    for words, columns in moments.items():
        shown = [np.abs(x[1:]) for axis, x in columns.items() if axis == "y" or "flap" in words]
        if shown and shown[0].size:
            found[words] = 1e-6 * float(np.nanmax(shown))
    if names.MAX_STRESS in history.columns:
        stress = float(np.nanmax(history[names.MAX_STRESS]))
        found["largest Cauchy stress norm [MPa]"] = stress / 1e6
    worst = find_worst_ply(history)
    if worst is not None:
        found[f"largest failure index of plies ({worst.criterion}) [-]"] = worst.index
        found[f"... in {worst.panel.replace('_', ' ')}, from the root [m]"] = worst.place
        found["... at the time [s]"] = worst.time
    signs = OPENFAST_SIGNS if is_turbine(history) else {}
    for name, angle in history.of(names.ANGLE).items():
        end = float(angle[-1]) if abs(angle[-1]) > ROUND_OFF else 0.0
        degrees = signs.get(name, 1.0) * float(np.degrees(end)) + 0.0  # no -0
        found[f"{name.replace('_', ' ')} angle at the end [deg]"] = degrees
    return found


def _draw_diagrams(history: TimeSeries, tolerance: float | None) -> str:
    """The diagrams of `turbine_fenicsx.postprocessing.plots`."""
    texts = []
    with tempfile.TemporaryDirectory() as scratch:
        for name, panels in choose_figures([history]).items():
            try:
                (path,) = draw(
                    [history],
                    panels,
                    [Path(scratch) / f"{name}.png"],
                    relative_tolerance=tolerance,
                )
            except ImportError as error:
                return format_note(f"There are no diagrams: {error}.")
            kind = "narrow" if len(panels) == 1 else ""
            texts.append(embed_figure(path, _CAPTIONS[name], kind))
    return "".join(texts)


def _format_statistics(folder: Path) -> str:
    """Mean, deviation and extremes of the channels, if the run has come to its end."""
    found = read_statistics(folder)
    if not found:
        return ""
    head = ("", "mean", "deviation", "least", "at [s]", "largest", "at [s]")
    rows = [(format_label(each.column), *astuple(each)[1:]) for each in found]
    return (
        "<p>Channels of history.out, then columns of history.csv.</p>\n"
        f"<details><summary>{len(rows)} channels</summary>\n{format_grid(head, rows)}</details>\n"
    )


def _format_fatigue(history: TimeSeries) -> str:
    """Equivalent ranges of moments and strains, if there are any."""
    if not list_loads(history) or history[names.TIME][-1] <= history[names.TIME][0]:
        return ""
    try:
        found = find_fatigue(history)
    except (ImportError, InputError) as error:
        return format_note(f"Fatigue is left out: {error}.")
    ranges = dict(_in_words(each.column, next(iter(each.equivalent.values()))) for each in found)
    return (
        f"<p>Ranges whose cycles of {FREQUENCY:g} Hz would do the same damage. Slopes of the S-N "
        f"curve are {STEEL_SLOPE:g} for the tower, {GLASS_SLOPE:g} for blades.</p>\n"
        f"{format_tables({'': ranges})}"
    )


def _in_words(column: str, value: float) -> tuple[str, float]:
    """A column as words, and its value: moments are in MN m."""
    name, unit = split_unit(column)
    unit, factor = ("MN m", 1e-6) if unit == "Nm" else (unit, 1.0)
    return f"{name.replace('_', ' ')} [{unit}]", factor * value


def _draw_pictures(folder: Path, times: Sequence[float] | None, look: Look) -> str:
    """Pictures of the turbine."""
    fields = find_fields(folder)
    if not fields.exists():
        if times is not None:
            read_field_times(fields)  # says why there are none
        return format_note("There are no pictures: the run has written no fields.")
    written = read_field_times(fields)
    for t in times or ():
        find_nearest_step(written, t)  # a wrong time is an error, a missing library is not
    if times is None:
        times = sorted({float(t) for t in written[-1] * np.array([0.25, 0.5, 0.75, 1.0])})
        times = [max(t, float(written[0])) for t in times]
    with tempfile.TemporaryDirectory() as scratch:
        try:
            paths = render_times(fields, scratch, times, look)
        except InputError as error:
            reason = str(error).rpartition(f"{scratch}{os.sep}")[2]
            return format_note(f"There are no pictures: {reason}.")
        texts = [
            embed_figure(path, f"t = {path.stem.removeprefix('turbine_t')} s") for path in paths
        ]
    scaled = "" if look.scale == 1.0 else f" The deformation is scaled by {look.scale:g}."
    return (
        "<p>All pictures have the same scales of colours. A white tower is no part of the model."
        f"{scaled}</p>\n<div class='pictures'>{''.join(texts)}</div>\n"
    )

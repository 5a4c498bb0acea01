"""A run as one HTML page that needs no other file and no network.

Everything is read from the output folder. What is missing there, or cannot be drawn, is left out
with a sentence that says so; only ``history.csv`` is needed.
"""

import base64
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

import turbine_fenicsx
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.postprocessing.conventions import OPENFAST_SIGNS
from turbine_fenicsx.postprocessing.output_folder import (
    TimeSeries,
    field_times,
    need_folder,
    read_histories,
    read_tables,
    solver_tolerance,
)
from turbine_fenicsx.postprocessing.panels import is_turbine
from turbine_fenicsx.postprocessing.pictures import Look, nearest_step, render_times
from turbine_fenicsx.postprocessing.plots import draw, figures

_CAPTIONS = {
    "energy": "Energies; the error is what is added to the total energy H beyond the work W of the "
    "loads. The dashed line is the tolerance of the solver times the largest energy.",
    "angular_momentum": "Angular momentum about the origin. The tower of a turbine holds the "
    "horizontal components; the vertical one, L2, changes by the yaw torque alone.",
    "angles": "Angles and speeds of the joints; yaw and pitch of a turbine in the signs of "
    "OpenFAST.",
    "displacements": "Displacements of sliding joints.",
    "tip_deflections": "Deflections of the blade tips in the frames of what carries their roots.",
    "root_moments": "Moments of the blades on what carries their roots, means of each step.",
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
) -> str:
    """Describe a run.

    Args:
        folder: Output folder.
        times: Times of the pictures [s]; four of the whole run if None.
        scale: Factor of the deformation in the pictures.
        pictures: Whether there are any.
        describe: Makes the tables of the page from those of ``case.json``.

    Returns:
        The page.

    Raises:
        InputError: if there is no ``history.csv``, a file is broken, or a time is outside of the
            run.
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
        + _tables({"": _key_figures(history)}),
        "Case": _case(case, describe),
        "Diagrams": _diagrams(history, solver_tolerance(folder)),
        "Pictures": _pictures(folder, times, Look(scale=scale, size=_SIZE)) if pictures else "",
        "Model and results": _tables(_grouped(summary, "run"))
        if summary
        else _note("There is no summary.json: the run has not come to its end."),
        "Versions": _tables({"": versions}, str) if versions else "",
    }
    template = Template(Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=escape(title),
        subtitle=escape(
            f"{folder.resolve().name}, {len(history[names.TIME]) - 1} steps to t = {end:g} s; "
            f"written by turbine_fenicsx {turbine_fenicsx.__version__}."
        ),
        body="\n".join(
            f"<section><h2>{escape(name)}</h2>\n{text}</section>"
            for name, text in sections.items()
            if text
        ),
    )


def _key_figures(history: TimeSeries) -> dict[str, Any]:
    """What one asks first."""
    energy, error = history[names.TOTAL_ENERGY], np.abs(history[names.ENERGY_ERROR])
    steps = np.abs(np.diff(energy - history[names.EXTERNAL_WORK]))
    largest = float(
        max(np.nanmax(np.abs(history[n])) for n in (names.TOTAL_ENERGY, names.KINETIC_ENERGY))
    )
    found = {
        "largest energy [MJ]": largest / 1e6,
        "largest energy error [J]": float(np.nanmax(error)),
        "... of the largest energy": float(np.nanmax(error)) / max(largest, 1e-300),
        "largest energy error of a step [J]": float(np.nanmax(steps, initial=0.0)),
    }
    tips = history.of(names.TIP_DEFLECTION)
    if tips:
        found["largest tip deflection [m]"] = float(max(np.nanmax(tip) for tip in tips.values()))
    if names.MAX_STRESS in history.columns:
        stress = float(np.nanmax(history[names.MAX_STRESS]))
        found["largest Cauchy stress norm [MPa]"] = stress / 1e6
    signs = OPENFAST_SIGNS if is_turbine(history) else {}
    for name, angle in history.of(names.ANGLE).items():
        degrees = signs.get(name, 1.0) * float(np.degrees(angle[-1]))
        found[f"{name.replace('_', ' ')} angle at the end [deg]"] = degrees
    return found


def _case(
    case: Mapping[str, Any] | None, describe: Callable[[Mapping[str, Any]], Mapping[str, Any]]
) -> str:
    """The resolved case."""
    if case is None:
        return _note("There is no case.json in the output folder, so that the case is not shown.")
    try:
        return _tables(_grouped(describe(case), "case"))
    except InputError as error:
        note = _note(f"This is no valid case for this version, and shown as it is: {error}.")
        return note + _tables(_grouped(case, "case"))


def _grouped(tables: Mapping[str, Any], rest: str, above: str = "") -> dict[str, dict[str, Any]]:
    """Nested tables one after another; what is in none of them comes first, under ``rest``."""
    own = {k: v for k, v in tables.items() if not isinstance(v, Mapping)}
    found = {rest: own} if own else {}
    for name, inner in tables.items():
        if isinstance(inner, Mapping):
            full = f"{above}{name}"
            found |= _grouped(inner, full, f"{full}.")
    return found


def _tables(
    tables: Mapping[str, Mapping[str, Any]], label: Callable[[str], str] | None = None
) -> str:
    """Tables of two columns beside each other; empty ones are left out."""
    label = label or _label
    texts = []
    for name, rows in tables.items():
        caption = f"<caption>{escape(_label(name))}</caption>" if name else ""
        lines = "\n".join(
            f"<tr><th scope='row'>{escape(label(key))}</th><td>{escape(_text(value))}</td></tr>"
            for key, value in rows.items()
        )
        if rows:
            texts.append(f"<table>{caption}\n{lines}\n</table>")
    return f"<div class='tables'>\n{''.join(texts)}\n</div>\n"


def _label(key: str) -> str:
    """A key in words, its unit in brackets."""
    name, unit = names.split_unit(key)
    symbol = unit.replace("^2", "²").replace("^3", "³")
    words = name.replace("_", " ")
    return words if unit in ("", "-") else f"{words} [{symbol}]"


def _text(value: Any) -> str:
    """A value as a person would write it."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        return ", ".join(_text(item) for item in value)
    return str(value)


def _diagrams(history: TimeSeries, tolerance: float | None) -> str:
    """The diagrams of `turbine_fenicsx.postprocessing.plots`."""
    texts = []
    with tempfile.TemporaryDirectory() as scratch:
        for name, panels in figures([history]).items():
            try:
                (path,) = draw(
                    [history],
                    panels,
                    [Path(scratch) / f"{name}.png"],
                    relative_tolerance=tolerance,
                )
            except ImportError as error:
                return _note(f"There are no diagrams: {error}.")
            kind = "narrow" if len(panels) == 1 else ""
            texts.append(_figure(path, _CAPTIONS[name], kind))
    return "".join(texts)


def _pictures(folder: Path, times: Sequence[float] | None, look: Look) -> str:
    """Pictures of the turbine."""
    fields = folder / "fields.xdmf"
    if not fields.exists():
        if times is not None:
            field_times(fields)  # says why there are none
        return _note("There are no pictures: the run has written no fields.xdmf.")
    written = field_times(fields)
    for t in times or ():
        nearest_step(written, t)  # a wrong time is an error, a missing library is not
    if times is None:
        times = sorted({float(t) for t in written[-1] * np.array([0.25, 0.5, 0.75, 1.0])})
        times = [max(t, float(written[0])) for t in times]
    with tempfile.TemporaryDirectory() as scratch:
        try:
            paths = render_times(fields, scratch, times, look)
        except InputError as error:
            reason = str(error).rpartition(f"{scratch}{os.sep}")[2]
            return _note(f"There are no pictures: {reason}.")
        texts = [_figure(path, f"t = {path.stem.removeprefix('turbine_t')} s") for path in paths]
    scaled = "" if look.scale == 1.0 else f" The deformation is scaled by {look.scale:g}."
    return (
        "<p>All pictures have the same scales of colours. A white tower is no part of the model."
        f"{scaled}</p>\n<div class='pictures'>{''.join(texts)}</div>\n"
    )


def _figure(path: Path, caption: str, kind: str = "") -> str:
    """A PNG file inside the page."""
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return (
        f"<figure{kind and f' class={kind!r}'}><img alt='{escape(caption, quote=True)}' "
        f"src='data:image/png;base64,{data}'>\n<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def _note(text: str) -> str:
    """A sentence about what is missing."""
    return f"<p class='note'>{escape(text)}</p>\n"

"""Panels of a turbine in wind: what it takes out of the wind, and how it runs."""

from itertools import cycle
from typing import Any

import numpy as np

from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.postprocessing.panels import ROUND_OFF, Panel, rotor_speed
from turbine_fenicsx.postprocessing.plot_style import Look, draw_line
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.records.output_folder import TimeSeries

GENERATORS = ("generator", "motion_of_rotor")
"""Names under which a generator takes work, with a torque or a speed that it keeps."""


def has_wind(run: TimeSeries) -> bool:
    """Whether a run has loads of the wind."""
    return names.AERO_POWER in run.columns


def choose_wind_panels(run: TimeSeries) -> tuple[Panel, ...]:
    """The wind, power, thrust and speed, and pitch and torque where blades turn."""
    further = (pitch, torque) if _find_pitch(run) else ()
    return (hub_wind, power, thrust, rotor_speed, *further)


def power(axes: Any, run: TimeSeries, look: Look) -> None:
    """Power of the air on the rotor, and what the generator takes of it, before its losses."""
    how = {} if look.alone else {"color": look.color}
    label = "of the air" if look.alone else run.name
    draw_line(
        axes, run, run[names.AERO_POWER], look, **{"color": PALETTE[0], "label": label, **how}
    )
    works = run.of(names.WORK)
    taken = next((works[name] for name in GENERATORS if name in works), None)
    if look.alone and taken is not None:
        rate = -np.diff(taken, prepend=np.nan) / np.diff(run[names.TIME], prepend=np.nan)
        draw_line(axes, run, rate, look, color=PALETTE[1], label="of the generator")
    axes.set(title="Power", ylabel="power [W]")


def thrust(axes: Any, run: TimeSeries, look: Look) -> None:
    """Force of the air along the shaft."""
    draw_line(axes, run, run[names.AERO_THRUST], look, color=look.color, label=run.name)
    axes.set(title="Thrust", ylabel="along the shaft [N]")


def torque(axes: Any, run: TimeSeries, look: Look) -> None:
    """Torque of the air about the shaft."""
    draw_line(axes, run, run[names.AERO_TORQUE], look, color=look.color, label=run.name)
    axes.set(title="Torque", ylabel="about the shaft [N m]")


def hub_wind(axes: Any, run: TimeSeries, look: Look) -> None:
    """Wind where the hub was at the start, downwind."""
    wind = run[names.HUB_WIND(axis="x")]
    draw_line(axes, run, wind, look, color=look.color, label=run.name)
    axes.set(title="Wind at the hub", ylabel="downwind [m/s]")


def pitch(axes: Any, run: TimeSeries, look: Look) -> None:
    """Pitch of the blades, positive towards feather."""
    unit, factor = ("°", 180.0 / np.pi) if look.degrees else ("rad", 1.0)
    found = run.of(names.ANGLE)
    for name, color in zip(_find_pitch(run), cycle(PALETTE), strict=False):
        # a bearing that a drive holds has its round-off, which is no motion
        angle = np.where(np.abs(found[name]) < ROUND_OFF, 0.0, found[name])
        values = OPENFAST_SIGNS[name] * factor * angle
        draw_line(axes, run, values, look, color=color, label=name.replace("_", " "))
    axes.set(title="Pitch", ylabel=f"angle [{unit}]")


def _find_pitch(run: TimeSeries) -> list[str]:
    """Bearings of the blades."""
    return [name for name in run.of(names.ANGLE) if name in OPENFAST_SIGNS and "pitch" in name]

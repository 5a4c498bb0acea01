"""The panels of diagrams: what of ``history.csv`` is shown, in SI units before prefixes."""

from collections.abc import Callable
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.postprocessing.conventions import OPENFAST_SIGNS
from turbine_fenicsx.postprocessing.output_folder import TimeSeries
from turbine_fenicsx.postprocessing.plot_style import PALETTE, Look, dots, line

Panel = Callable[[Any, TimeSeries, Look], None]


def is_turbine(run: TimeSeries) -> bool:
    """Whether the joints are those of a turbine."""
    return {"yaw", "rotor"} <= set(run.named("angle_"))


def energies(axes: Any, run: TimeSeries, look: Look) -> None:
    """Total energy and its parts."""
    line(axes, run, _energy(run, "total"), look, color="black", lw=2.4, label="total")
    for name, color in zip(("kinetic", "strain", "potential"), PALETTE, strict=False):
        line(axes, run, _energy(run, name), look, color=color, label=name)
    axes.set(title="Energies", ylabel="energy [J]")


def small_energies(axes: Any, run: TimeSeries, look: Look) -> None:
    """Strain and potential energy on a scale of their own."""
    for name, color in zip(("strain", "potential"), PALETTE[1:], strict=False):
        line(axes, run, _energy(run, name), look, color=color, label=name)
    axes.set(title="Strain and potential", ylabel="energy [J]")


def _energy(run: TimeSeries, name: str) -> NDArray[np.float64]:
    """An energy [J]; the potential counts from where it starts, which may be far below zero."""
    energy = run[f"{name}_energy_[J]"]
    if name in ("total", "potential"):
        energy = energy - run["potential_energy_[J]"][:1].sum()  # nothing of a run of no steps
    return energy


def energy_steps(axes: Any, run: TimeSeries, look: Look) -> None:
    """What each step adds to the energy beyond the work of the loads."""
    change = np.diff(run["total_energy_[J]"] - run["external_work_[J]"], prepend=np.nan)
    largest = float(np.nanmax([np.abs(_energy(run, n)) for n in ("total", "kinetic")]))
    dots(axes, run, np.abs(change), look, largest, "J", color=look.color, label=run.name)
    axes.set(title="Energy error per step", ylabel=r"$|\Delta H - \Delta W|$ [J]")


def energy_error(axes: Any, run: TimeSeries, look: Look) -> None:
    """Total energy minus initial energy minus work."""
    line(axes, run, run["energy_error_[J]"], look, color=look.color, label=run.name)
    axes.set(title="Energy error since the start", ylabel=r"$H - H_0 - W$ [J]")


def angular_momentum(axes: Any, run: TimeSeries, look: Look) -> None:
    """Angular momentum about the origin."""
    for axis, color in zip("123", PALETTE, strict=False):
        values = run[f"angular_momentum_{axis}_[Nms]"]
        line(axes, run, values, look, color=color, label=f"$L_{axis}$")
    axes.set(title="Angular momentum", ylabel="about the origin [N m s]")


def momentum_steps(axes: Any, run: TimeSeries, look: Look) -> None:
    """What each step adds to the angular momentum.

    The tower holds nacelle and weights, so that only the vertical component has to stay; of
    several runs it is the only one shown.
    """
    components = {i: run[f"angular_momentum_{i}_[Nms]"] for i in "123"}
    largest = max(float(np.nanmax(np.abs(values))) for values in components.values())
    for axis, color in zip("123", PALETTE, strict=False):
        if look.alone or axis == "2":
            change = np.abs(np.diff(components[axis], prepend=np.nan))
            how = {"color": color, "label": rf"$\Delta L_{axis}$"}
            if not look.alone:
                how = {"color": look.color, "label": run.name}
            dots(axes, run, change, look, largest, "N m s", **how)
    shown = "i" if look.alone else "2"
    axes.set(title="Change per step", ylabel=rf"$|\Delta L_{shown}|$ [N m s]")


def joint_angles(axes: Any, run: TimeSeries, look: Look) -> None:
    """Joint angles of a model that is no turbine."""
    _angles(axes, run, look, list(run.named("angle_")))
    axes.set_title("Joint angles")


def rotor_angle(axes: Any, run: TimeSeries, look: Look) -> None:
    """Angle of the rotor since the start."""
    _angles(axes, run, look, ["rotor"])
    axes.set_title("Rotor angle")


def yaw_and_pitch(axes: Any, run: TimeSeries, look: Look) -> None:
    """Yaw and pitch, in the signs of OpenFAST."""
    names = [name for name in run.named("angle_") if name != "rotor"]
    _angles(axes, run, look, names)
    pitch = any(name.startswith("pitch") for name in names)
    axes.set_title("Yaw and pitch" if pitch else "Yaw")


def _angles(axes: Any, run: TimeSeries, look: Look, names: list[str]) -> None:
    """Angles, those of a turbine in the signs of OpenFAST."""
    signs = OPENFAST_SIGNS if is_turbine(run) else {}
    unit, factor = ("°", 180.0 / np.pi) if look.degrees else ("rad", 1.0)
    found = run.named("angle_")
    for name, color in zip(names, cycle(PALETTE), strict=False):
        values = signs.get(name, 1.0) * factor * found[name]
        line(axes, run, values, look, color=color, label=name.replace("_", " "))
    axes.set_ylabel(f"angle [{unit}]")


def rotor_speed(axes: Any, run: TimeSeries, look: Look) -> None:
    """Mean speed of the rotor over each step [rpm]."""
    rate = np.diff(run.named("angle_")["rotor"]) / np.diff(run["time_[s]"])
    speed = np.concatenate([[np.nan], rate * 30.0 / np.pi])
    line(axes, run, speed, look, color=look.color, label=run.name)
    axes.set(title="Rotor speed", ylabel="speed [rpm]")


def displacements(axes: Any, run: TimeSeries, look: Look) -> None:
    """Displacements of sliding joints."""
    found = run.named("displacement_")
    for (name, values), color in zip(found.items(), cycle(PALETTE), strict=False):
        line(axes, run, values, look, color=color, label=name.replace("_", " "))
    axes.set(title="Joint displacements", ylabel="displacement [m]")


def _per_blade(
    title: str, label: str, pattern: tuple[str, str], axes: Any, run: TimeSeries, look: Look
) -> None:
    """One quantity of all blades: columns that start with the one and end with the other."""
    start, end = pattern
    found = {n: v for n, v in run.named(start).items() if n.endswith(end)}
    for (name, values), color in zip(found.items(), cycle(PALETTE), strict=False):
        shown = values.copy()
        if "moment" in start:
            shown[:1] = np.nan  # a mean of the step before, of which there is none
        line(axes, run, shown, look, color=color, label=f"blade {name.removesuffix(end)}")
    axes.set(title=title, ylabel=label)


tip_flap = partial(_per_blade, "Tip, flapwise", "downwind [m]", ("tip_flap_", ""))
tip_edge = partial(_per_blade, "Tip, edgewise", "to the trailing edge [m]", ("tip_edge_", ""))
tip_length = partial(_per_blade, "Tip deflections", "deflection [m]", ("tip_deflection_", ""))
root_flap = partial(_per_blade, "Flap moment", "at the root, $M_y$ [N m]", ("root_moment_", "_y"))
root_edge = partial(_per_blade, "Edge moment", "at the root, $M_x$ [N m]", ("root_moment_", "_x"))


def _tower(
    title: str, label: str, columns: dict[str, str], axes: Any, run: TimeSeries, look: Look
) -> None:
    """Columns of the tower under their names."""
    for (column, name), color in zip(columns.items(), PALETTE, strict=False):
        shown = run[column].copy()
        if "moment" in column:
            shown[:1] = np.nan
        line(axes, run, shown, look, color=color, label=name)
    axes.set(title=title, ylabel=label)


tower_top = partial(
    _tower,
    "Tower top",
    "displacement [m]",
    {
        "tower_top_displacement_x_[m]": "fore-aft",
        "tower_top_displacement_y_[m]": "side to side",
    },
)
tower_base = partial(
    _tower,
    "Tower base",
    "moment [N m]",
    {
        "tower_base_moment_y_[Nm]": "fore-aft",
        "tower_base_moment_x_[Nm]": "side to side",
    },
)

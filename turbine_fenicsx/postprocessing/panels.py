"""Panels of diagrams: which columns of ``history.csv`` they show, in SI units."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import cycle, islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from turbine_fenicsx.foundation.diagram_style import PALETTE
from turbine_fenicsx.postprocessing.plot_style import Look, draw_dots, draw_line
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.records.names import Family
from turbine_fenicsx.records.output_folder import TimeSeries

Panel = Callable[[Any, TimeSeries, Look], None]

ROUND_OFF = 1e-12
"""Angles below are drawn as zero [rad]."""

_PARTS = {
    names.KINETIC_ENERGY: "kinetic",
    names.STRAIN_ENERGY: "strain",
    names.POTENTIAL_ENERGY: "potential",
}
"""Parts of the energy, and what they are called in legends."""


def is_turbine(run: TimeSeries) -> bool:
    """Whether the joints are those of a turbine."""
    return {"yaw", "rotor"} <= set(run.of(names.ANGLE))


def energies(axes: Any, run: TimeSeries, look: Look) -> None:
    """Total energy and its parts."""
    total = _energy(run, names.TOTAL_ENERGY)
    draw_line(axes, run, total, look, color="black", lw=2.4, label="total")
    for (column, label), color in zip(_PARTS.items(), PALETTE, strict=False):
        draw_line(axes, run, _energy(run, column), look, color=color, label=label)
    axes.set(title="Energies", ylabel="energy [J]")


def small_energies(axes: Any, run: TimeSeries, look: Look) -> None:
    """Strain and potential energy on a separate scale."""
    for (column, label), color in islice(zip(_PARTS.items(), PALETTE, strict=False), 1, None):
        draw_line(axes, run, _energy(run, column), look, color=color, label=label)
    axes.set(title="Strain and potential", ylabel="energy [J]")


def _energy(run: TimeSeries, column: str) -> NDArray[np.float64]:
    """An energy [J]; the potential counts from where it starts, which may be far below zero."""
    energy = run[column]
    if column in (names.TOTAL_ENERGY, names.POTENTIAL_ENERGY):
        energy = energy - run[names.POTENTIAL_ENERGY][:1].sum()  # nothing of a run of no steps
    return energy


def find_largest_energy(run: TimeSeries) -> float:
    """Largest of all energies of a run, to which errors count, see `Snapshot.stored_energy` [J]."""
    columns = (
        names.KINETIC_ENERGY,
        names.STRAIN_ENERGY,
        names.SPRING_ENERGY,
        names.POTENTIAL_ENERGY,
    )
    parts = [np.abs(_energy(run, column)) for column in columns if column in run.columns]
    return float(np.nanmax(parts))


def find_energy_steps(run: TimeSeries) -> NDArray[np.float64]:
    """Change of the energy per step beyond works minus losses, not-a-number first [J]."""
    lost = sum(run.of(names.DISSIPATION).values(), np.zeros(len(run[names.TIME])))
    beyond = run[names.TOTAL_ENERGY] - run[names.EXTERNAL_WORK] + lost
    return np.diff(beyond, prepend=np.nan)


def energy_steps(axes: Any, run: TimeSeries, look: Look) -> None:
    """Change of the energy per step beyond works minus losses."""
    change = find_energy_steps(run)
    largest = find_largest_energy(run)
    draw_dots(axes, run, np.abs(change), look, largest, "J", color=look.color, label=run.name)
    losses = r" + \Delta D" if run.of(names.DISSIPATION) else ""
    axes.set(title="Energy error per step", ylabel=rf"$|\Delta H - \Delta W{losses}|$ [J]")


def energy_error(axes: Any, run: TimeSeries, look: Look) -> None:
    """Total energy minus initial energy minus work, plus losses."""
    draw_line(axes, run, run[names.ENERGY_ERROR], look, color=look.color, label=run.name)
    losses = " + D" if run.of(names.DISSIPATION) else ""
    axes.set(title="Energy error since the start", ylabel=f"$H - H_0 - W{losses}$ [J]")


def angular_momentum(axes: Any, run: TimeSeries, look: Look) -> None:
    """Angular momentum about the origin."""
    for axis, color in zip("123", PALETTE, strict=False):
        values = run[names.ANGULAR_MOMENTUM(axis=axis)]
        draw_line(axes, run, values, look, color=color, label=f"$L_{axis}$")
    axes.set(title="Angular momentum", ylabel="about the origin [N m s]")


def momentum_steps(axes: Any, run: TimeSeries, look: Look) -> None:
    """Change of the angular momentum per step.

    The tower holds nacelle and weights, so that only the vertical component has to stay; of
    several runs it is the only one shown.
    """
    components = {i: run[names.ANGULAR_MOMENTUM(axis=i)] for i in "123"}
    if _is_loaded_at_end(run):  # then it changes, and the tolerance says nothing
        look = replace(look, tolerance=None, relative_tolerance=None)
    largest = max(float(np.nanmax(np.abs(values))) for values in components.values())
    for axis, color in zip("123", PALETTE, strict=False):
        if look.alone or axis == "2":
            change = np.abs(np.diff(components[axis], prepend=np.nan))
            how = {"color": color, "label": rf"$\Delta L_{axis}$"}
            if not look.alone:
                how = {"color": look.color, "label": run.name}
            draw_dots(axes, run, change, look, largest, "N m s", **how)
    shown = "i" if look.alone else "2"
    axes.set(title="Change per step", ylabel=rf"$|\Delta L_{shown}|$ [N m s]")


def _is_loaded_at_end(run: TimeSeries) -> bool:
    """Whether forces still do work in the last of the rows, as wind and generators do."""
    work = run[names.EXTERNAL_WORK]
    change, largest = np.abs(np.diff(work)[-1:]), np.nanmax(np.abs(work), initial=0.0)
    return bool(np.any(change > ROUND_OFF * largest))


def other_joints(run: TimeSeries) -> list[str]:
    """Joints with angles; those of a turbine without yaw, rotor and pitch."""
    known = OPENFAST_SIGNS if is_turbine(run) else {}
    return [name for name in run.of(names.ANGLE) if name not in known]


def joint_angles(axes: Any, run: TimeSeries, look: Look) -> None:
    """Angles of joints that every model has, under fixed names."""
    joints = other_joints(run)
    _draw_angles(axes, run, look, joints)
    axes.set_title("Joint angles" if len(joints) != 1 else f"Angle of {joints[0]}")


def rotor_angle(axes: Any, run: TimeSeries, look: Look) -> None:
    """Angle of the rotor since the start."""
    _draw_angles(axes, run, look, ["rotor"])
    axes.set_title("Rotor angle")


def yaw_and_pitch(axes: Any, run: TimeSeries, look: Look) -> None:
    """Yaw and pitch, in the signs of OpenFAST."""
    joints = [name for name in run.of(names.ANGLE) if name in OPENFAST_SIGNS and name != "rotor"]
    _draw_angles(axes, run, look, joints)
    pitch = any(name.startswith("pitch") for name in joints)
    axes.set_title("Yaw and pitch" if pitch else "Yaw")


def yaw(axes: Any, run: TimeSeries, look: Look) -> None:
    """Yaw alone, in the sign of OpenFAST."""
    _draw_angles(axes, run, look, ["yaw"])
    axes.set_title("Yaw")


def _draw_angles(axes: Any, run: TimeSeries, look: Look, joints: list[str]) -> None:
    """Angles, those of a turbine in the signs of OpenFAST."""
    signs = OPENFAST_SIGNS if is_turbine(run) else {}
    unit, factor = ("°", 180.0 / np.pi) if look.degrees else ("rad", 1.0)
    found = run.of(names.ANGLE)
    for name, color in zip(joints, cycle(PALETTE), strict=False):
        # a bearing that is held has its round-off, which is no motion
        angle = np.where(np.abs(found[name]) < ROUND_OFF, 0.0, found[name])
        values = signs.get(name, 1.0) * factor * angle
        draw_line(axes, run, values, look, color=color, label=name.replace("_", " "))
    axes.set_ylabel(f"angle [{unit}]")


def rotor_speed(axes: Any, run: TimeSeries, look: Look) -> None:
    """Mean speed of the rotor over each step [rpm]."""
    rate = np.diff(run.of(names.ANGLE)["rotor"]) / np.diff(run[names.TIME])
    speed = np.concatenate([[np.nan], rate * 30.0 / np.pi])
    draw_line(axes, run, speed, look, color=look.color, label=run.name)
    axes.set(title="Rotor speed", ylabel="speed [rpm]")


def displacements(axes: Any, run: TimeSeries, look: Look) -> None:
    """Displacements of sliding joints."""
    found = run.of(names.DISPLACEMENT)
    for (name, values), color in zip(found.items(), cycle(PALETTE), strict=False):
        draw_line(axes, run, values, look, color=color, label=name.replace("_", " "))
    axes.set(title="Joint displacements", ylabel="displacement [m]")


def _draw_per_blade(
    title: str, label: str, family: Family, axis: str, axes: Any, run: TimeSeries, look: Look
) -> None:
    """One quantity of all blades, along an axis if it has some."""
    found = run.of(family, axis=axis) if axis else run.of(family)
    for (name, values), color in zip(found.items(), cycle(PALETTE), strict=False):
        draw_line(
            axes, run, _leave_out_first(family, values), look, color=color, label=f"blade {name}"
        )
    axes.set(title=title, ylabel=label)


def _leave_out_first(family: Family, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values; the first load is left out, since loads are means of the steps before."""
    if family not in (names.ROOT_MOMENT, names.TOWER_BASE_MOMENT):
        return values
    shown = values.copy()
    shown[:1] = np.nan
    return shown


tip_flap = partial(_draw_per_blade, "Tip, flapwise", "downwind [m]", names.TIP_FLAP, "")
tip_edge = partial(_draw_per_blade, "Tip, edgewise", "to the trailing edge [m]", names.TIP_EDGE, "")
tip_length = partial(_draw_per_blade, "Tip deflections", "deflection [m]", names.TIP_DEFLECTION, "")
root_flap = partial(
    _draw_per_blade, "Flap moment", "at the root, $M_y$ [N m]", names.ROOT_MOMENT, "y"
)
root_edge = partial(
    _draw_per_blade, "Edge moment", "at the root, $M_x$ [N m]", names.ROOT_MOMENT, "x"
)


def _draw_tower(
    title: str,
    label: str,
    family: Family,
    directions: dict[str, str],
    axes: Any,
    run: TimeSeries,
    look: Look,
) -> None:
    """Components of a quantity of the tower, by axis, and what they are called."""
    for (axis, name), color in zip(directions.items(), PALETTE, strict=False):
        shown = _leave_out_first(family, run[family(axis=axis)])
        draw_line(axes, run, shown, look, color=color, label=name)
    axes.set(title=title, ylabel=label)


tower_top = partial(
    _draw_tower,
    "Tower top",
    "displacement [m]",
    names.TOWER_TOP_DISPLACEMENT,
    {"x": "fore-aft", "y": "side to side"},
)
tower_base = partial(
    _draw_tower,
    "Tower base",
    "moment [N m]",
    names.TOWER_BASE_MOMENT,
    {"y": "fore-aft", "x": "side to side"},
)

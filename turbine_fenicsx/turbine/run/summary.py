"""Summary of a run, as ``summary.json`` and as a short table."""

from __future__ import annotations

from math import degrees
from typing import Any

import numpy as np

from turbine_fenicsx.foundation import timing
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.versions import list_versions
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES, HUB, OPENFAST_SIGNS
from turbine_fenicsx.simulation.energy_check import (
    Conserving,
    allowed_energy_error,
    weight_round_off,
)
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.time_stepping.newton import NewtonStepper
from turbine_fenicsx.turbine.components.component import Turbine
from turbine_fenicsx.turbine.components.flexible_blades import BODY
from turbine_fenicsx.turbine.components.pitch import RINGS

_TURNING = {HUB, *RINGS, *BLADES, BODY}
"""Bodies that turn about the shaft."""


class Statistics:
    """Collects extremes and means over a run; an observer that checkpoints know."""

    name = "statistics"
    _SUMS = (
        "worst_energy_error",
        "largest_energy",
        "worst_constraint",
        "newton",
        "krylov",
        "steps",
    )

    def __init__(self) -> None:
        self.worst_energy_error = self.largest_energy = self.worst_constraint = 0.0
        self.newton = self.krylov = self.steps = self.steps_before = 0
        self.last: Snapshot | None = None

    def start(self, snapshot: Snapshot, resumed: bool) -> None:
        """Count the first state."""
        self._take_worst(snapshot)

    def observe(self, snapshot: Snapshot) -> None:
        """Count a step."""
        self._take_worst(snapshot)
        assert snapshot.report is not None
        self.steps += 1
        self.newton += snapshot.report.newton_iterations
        self.krylov += snapshot.report.krylov_iterations

    def _take_worst(self, snapshot: Snapshot) -> None:
        self.worst_energy_error = max(self.worst_energy_error, abs(snapshot.energy_error))
        self.largest_energy = max(self.largest_energy, snapshot.stored_energy)
        self.worst_constraint = max(self.worst_constraint, snapshot.constraint_error)
        self.last = snapshot

    def save(self) -> RestartData:
        """Statistics so far."""
        return RestartData({name: getattr(self, name) for name in self._SUMS})

    def restore(self, data: RestartData) -> None:
        """Resume from what was seen in an earlier run."""
        for name in self._SUMS:
            setattr(self, name, data.numbers[name])
        self.steps_before = self.steps

    def finish(self) -> None:
        """There is no file to close."""


def list_masses(turbine: Turbine) -> dict[str, float]:
    """Masses of all bodies [kg]. Collective."""
    system = turbine.system
    found = {body.name: float(body.mass) for body in system.rigid_bodies}
    for block in system.flexible_models:
        own = float(block.nodal_mass @ block.is_point)
        found[block.body.name] = float(system.comm.allreduce(own))
    return found


def rotor_inertia(turbine: Turbine) -> float:
    """Moment of inertia of hub and blades about the shaft [kg m^2]. Collective.

    It is the angular momentum about the shaft of the rotor that turns at one radian per second.
    """
    system = turbine.system
    state = system.initial_state()
    layout = turbine.rotor.layout
    centre, axis = np.asarray(layout.centre), layout.axes[2]
    state.q_dot[:] = 0.0
    for body, first in system.first_coordinate.items():
        if body.name in _TURNING:
            q = state.q[first : first + 12].reshape(4, 3).copy()
            q[0] = np.asarray(body.position) - centre
            state.q_dot[first : first + 12] = np.cross(axis, q).ravel()
    for block, v in zip(system.flexible_models, state.v, strict=True):
        v.array[:] = 0.0
        if block.body.name in _TURNING:
            v.array[:] = np.cross(axis, block.positions - block.is_point[:, None] * centre).ravel()
    balance = system.balance(state)
    about_centre = balance.angular - np.cross(centre, balance.linear)
    inertia = float(about_centre @ axis)
    state.destroy()
    return inertia


def count_unknowns(turbine: Turbine) -> dict[str, int]:
    """Numbers of unknowns of each block."""
    system, rigid = turbine.system, turbine.system.rigid_model
    return {
        "displacements": sum(3 * f.size_global for f in system.flexible_models),
        "coupling_multipliers": sum(c.C.getSize()[0] for c in system.coupling_blocks),
        "rigid_coordinates": rigid.n_q,
        "joint_angles": rigid.n_T,
        "rigid_and_joint_multipliers": rigid.n_constraints + rigid.n_T + rigid.n_relations,
    }


def summarise(
    turbine: Turbine,
    statistics: Statistics,
    seconds: float,
    simulation: Simulation,
) -> dict[str, Any]:
    """Everything worth keeping about a run. Collective.

    Args:
        seconds: Wall time of the time loop, since the run continued if it did [s].
        simulation: The run, for what its steps and its solver count.
    """
    steps, steps_now = (
        max(n, 1) for n in (statistics.steps, statistics.steps - statistics.steps_before)
    )
    parts = timing.seconds()
    parts["other"] = max(seconds - sum(parts.values()), 0.0)
    last = statistics.last
    assert last is not None
    mass = list_masses(turbine)
    stepper = simulation.stepper
    tolerance = stepper.energy_tolerance if isinstance(stepper, Conserving) else None
    allowed = {}
    if tolerance is not None:
        allowed[names.ALLOWED_ENERGY_ERROR] = _find_allowed_error(
            turbine, statistics, list(mass.values()), tolerance
        )
    factors = stepper.factors if isinstance(stepper, NewtonStepper) else (0, 0)
    return {
        names.VERSIONS: list_versions(),
        "components": turbine.component_names,
        "ranks": turbine.system.comm.size,
        "unknowns": count_unknowns(turbine),
        **_mesh_sizes(turbine),
        "masses_[kg]": mass,
        "rotor_inertia_[kgm2]": rotor_inertia(turbine),
        "steps": statistics.steps,
        "halved_steps": simulation.halvings,
        "solver_fallbacks": simulation.stepper.fallbacks,
        "factors": dict(zip(("number", "components_of_bodies"), factors, strict=True)),
        names.END_TIME: last.state.time,
        names.WORST_ENERGY_ERROR: statistics.worst_energy_error,
        **allowed,
        names.LARGEST_ENERGY: statistics.largest_energy,
        "worst_constraint_error_[-]": statistics.worst_constraint,
        "angular_momentum_[Nms]": [float(x) for x in last.balance.angular],
        "angles_[rad]": {
            name: float(angle)
            for name, angle in zip(
                turbine.system.joint_coordinate_names, last.state.joint_coordinates, strict=True
            )
        },
        "mean_newton_iterations": statistics.newton / steps,
        "mean_krylov_iterations": statistics.krylov / steps,
        names.WALL_TIME: last.wall_time,
        "time_per_step_[s]": seconds / steps_now,
        "time_per_step_by_part_[s]": {name: t / steps_now for name, t in parts.items()},
    }


def _find_allowed_error(
    turbine: Turbine, statistics: Statistics, masses: list[float], tolerance: float
) -> float:
    """Largest error of the energy balance that tolerance and round-off explain [J]."""
    assert statistics.last is not None
    reach = float(np.abs(statistics.last.state.q).max(initial=0.0))
    energy, steps = statistics.largest_energy, statistics.steps
    allowed = allowed_energy_error(energy, min(masses), steps, tolerance)
    return allowed + weight_round_off(turbine.system.gravity, sum(masses), reach)


def _mesh_sizes(turbine: Turbine) -> dict[str, dict[str, float] | None]:
    """Size and quality of each mesh."""
    others = {f"{body}_mesh": m for body, m in turbine.meshes.items() if body != BODY}
    meshes = {"mesh": turbine.meshes.get(BODY), **others}
    return {
        name: None
        if mesh is None
        else {
            "nodes": mesh.report.nodes,
            "cells": mesh.report.cells,
            "worst_quality": mesh.report.worst_quality,
        }
        for name, mesh in meshes.items()
    }


def format_table(s: dict[str, Any]) -> str:
    """The summary as a few lines to read."""
    scale = max(s[names.LARGEST_ENERGY], 1e-300)
    momentum = ", ".join(f"{x / 1e3:.6g}" for x in s["angular_momentum_[Nms]"])
    angles = ", ".join(
        f"{name} {OPENFAST_SIGNS.get(name, 1.0) * degrees(x) + 0.0:+.4f}"
        for name, x in s["angles_[rad]"].items()
    )
    sizes = s["unknowns"]
    spent = s["time_per_step_by_part_[s]"]
    shares = ", ".join(f"{k} {1e3 * t:.1f}" for k, t in spent.items() if t > 0.0)
    factors, parts = s["factors"].values()
    rows = [
        ("unknowns", f"{sum(sizes.values())} ({sizes['displacements']} displacements)"),
        ("steps", f"{s['steps']} to t = {s[names.END_TIME]:g} s, {s['halved_steps']} halved"),
        (
            "energy balance error",
            f"{s[names.WORST_ENERGY_ERROR]:.1e} J, {s[names.WORST_ENERGY_ERROR] / scale:.1e} of "
            "the largest energy",
        ),
        ("constraint error", f"{s['worst_constraint_error_[-]']:.1e}"),
        ("angular momentum", f"({momentum}) kNms"),
        ("angles [deg]", angles),
        *_describe_plies(s.get(names.WORST_PLY)),
        (
            "iterations per step",
            f"{s['mean_newton_iterations']:.2f} Newton"
            + _describe_fallbacks(s["solver_fallbacks"]),
        ),
        *([("factors", f"{factors} for {parts} blades or other parts")] if parts > 1 else []),
        ("time per step", f"{1e3 * s['time_per_step_[s]']:.1f} ms ({shares})"),
    ]
    return "\n".join(f"  {name:<22}{text}" for name, text in rows)


def _describe_plies(worst: dict[str, Any] | None) -> list[tuple[str, str]]:
    """Where plies come nearest to failure, if the history has failure indices."""
    if worst is None:
        return []
    text = (
        f"{worst['index']:.3g} ({worst['criterion']}), {worst['panel']} at {worst['place']:.4g} m, "
        f"t = {worst['time']:.4g} s"
    )
    return [("failure of plies", text)]


def _describe_fallbacks(number: int) -> str:
    """How often another linear solver or start took over, if it did."""
    times = "once" if number == 1 else f"{number} times"
    return f", another solver or start took over {times}" if number else ""

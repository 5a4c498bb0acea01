"""Whether the energy balance of a run is as good as its tolerance promises.

A step multiplied by its increments is the balance of energy: what is missing in it is the residual
times the velocity. The residual is the tolerance times the terms of the step at most, which are
inertia, M (du + dt v), and the forces that go with it. So a step adds at most eight times the
tolerance times the kinetic energy from inertia, and as much from each of the other terms. Norms
over bodies and meshes of unequal masses are larger than the sums they stand for. All this is put
into one factor of a hundred.

Forces of stiff bodies are not better than their round-off, and steps end there, which no
tolerance can improve. Up to 4e-8 of the energy was lost like this, in a very stiff and viscous
block; what loses more than `ROUND_OFF` is hidden by it. A hundred random cases stayed below 2e-9.

Positions are not better than their round-off either, which grows with the distance from the origin.
Bodies that rest far away have no energy but the work of their weight along it.
"""

from __future__ import annotations

import warnings
from typing import Any, Protocol, runtime_checkable

import numpy as np

from turbine_fenicsx.foundation.errors import ModelWarning
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.system import MultibodySystem

FACTOR = 100.0
"""Energy error of a step over the tolerance times the largest energy, at most."""

ROUND_OFF = 1e-7
"""Share of the largest energy that round-off may cost."""

LARGEST_SHARE = 1e-3
"""Maximum error of the balance relative to the largest energy, at any tolerance."""

POSITION_ROUND_OFF = 100.0 * float(np.finfo(float).eps)
"""Round-off of positions in a run, relative to the largest."""

REST_SPEED = 1e-5
"""Speed below which a body is at rest and its energy is noise [m/s]."""


@runtime_checkable
class Conserving(Protocol):
    """Additional interface of steppers whose steps close the energy balance."""

    @property
    def energy_tolerance(self) -> float | None:
        """Tolerance of its equations; None if energy is not conserved after all."""


class EnergyWatch:
    """The worst energy error of a run and its largest energy, to be judged when it is over."""

    def __init__(self) -> None:
        self.worst = self.largest = self.moved = self.reach = 0.0

    def take(self, snapshot: Snapshot) -> None:
        """Look at a state; works and losses count too, as they may exceed what is stored."""
        self.reach = max(self.reach, float(np.abs(snapshot.state.q).max(initial=0.0)))
        moved = (np.abs(snapshot.works).sum(), np.abs(snapshot.dissipated).sum())
        self.worst = max(self.worst, abs(snapshot.energy_error))
        self.largest = max(self.largest, snapshot.stored_energy)
        self.moved = max(self.moved, *map(float, moved))

    def warn(self, system: MultibodySystem, stepper: Any, steps: int) -> None:
        """Warn of a balance that is wrong. Collective.

        Args:
            stepper: What made the steps; one that is not `Conserving` promises nothing.
            steps: Number of steps since t = 0.
        """
        tolerance = stepper.energy_tolerance if isinstance(stepper, Conserving) else None
        if tolerance is None:
            return
        masses = [float(body.mass) for body in system.rigid_bodies if body.mass]
        own = [float(m.nodal_mass @ m.is_point) for m in system.flexible_models]
        masses += [float(mass) for mass in system.comm.allreduce(np.array(own))]
        energy = max(self.largest, self.moved)
        allowed = allowed_energy_error(energy, min(masses, default=0.0), steps, tolerance)
        allowed += weight_round_off(system.gravity, sum(masses), self.reach)
        if self.worst > allowed:
            text = describe_imbalance(self.worst, allowed, self.largest)
            on_rank0(system.comm, lambda: warnings.warn(text, ModelWarning, stacklevel=5))


def allowed_energy_error(energy: float, mass: float, steps: int, tolerance: float) -> float:
    """The largest energy error that tolerance and round-off explain [J].

    Args:
        energy: Largest energy of any kind in the run [J].
        mass: Mass of the lightest body [kg].
        steps: Number of steps.
    """
    share = min(max(ROUND_OFF, FACTOR * steps * tolerance), LARGEST_SHARE)
    return share * energy + mass * REST_SPEED**2


def weight_round_off(gravity: Array, mass: float, reach: float) -> float:
    """Work of the weight along the round-off of positions [J].

    Args:
        gravity: Acceleration of gravity, shape (3,) [m/s^2].
        mass: Of all bodies [kg].
        reach: Largest coordinate of a position [m].
    """
    return mass * float(np.linalg.norm(gravity)) * POSITION_ROUND_OFF * reach


def judge_energy(summary: dict[str, Any]) -> str:
    """Complaint about the balance of a run, a sentence; empty if it is right.

    A scheme that does not conserve energy promises nothing.
    """
    if names.ALLOWED_ENERGY_ERROR not in summary:
        return ""
    error, allowed = summary[names.WORST_ENERGY_ERROR], summary[names.ALLOWED_ENERGY_ERROR]
    if error <= allowed:
        return ""
    return describe_imbalance(error, allowed, summary[names.LARGEST_ENERGY])


def describe_imbalance(error: float, allowed: float, largest: float) -> str:
    """The sentence about a balance that is wrong [J]."""
    shares = [write_share(part / max(largest, 1e-300)) for part in (error, allowed)]
    return (
        f"the energy balance is wrong by {error:.2g} J, {shares[0]} the largest energy, where "
        f"tolerance and round-off explain {shares[1]} it: do not trust this run; "
        "solver.tolerance is too large, a law or a force of your own is wrong, or constants are so "
        "far apart (stiffness, viscosity, masses) that round-off hides the motion"
    )


def write_share(share: float) -> str:
    """A part of something in per cent, with two digits that count and without an exponent."""
    if share >= 10.0:
        return f"{share:.2g} times" if share < 1e3 else "more than a thousand times"
    return f"{np.format_float_positional(100.0 * share, 2, fractional=False, trim='-')} % of"

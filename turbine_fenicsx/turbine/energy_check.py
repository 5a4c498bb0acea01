"""Whether the energy balance of a run is as good as its tolerance promises.

A step multiplied by its increments is the balance of energy: what is missing in it is the residual
times the velocity. The residual is the tolerance times the terms of the step at most, which are
inertia, M (du + dt v), and the forces that go with it. So a step adds not more than eight times the
tolerance times the kinetic energy from inertia, and as much from each of the other terms; norms
over bodies and meshes of unequal masses are larger than the sums they stand for. All this is put
into one factor of a hundred.

Forces of stiff bodies are not better than their round-off, and steps end there, which no
tolerance can improve. Up to 4e-8 of the energy was lost like this, in a very stiff and viscous
block; what loses more than `ROUND_OFF` is hidden by it.
"""

from __future__ import annotations

from typing import Any

from turbine_fenicsx.postprocessing import names

FACTOR = 100.0
"""Energy error of a step over the tolerance times the largest energy, at most."""

ROUND_OFF = 1e-5
"""Share of the largest energy that round-off may cost."""

LARGEST_SHARE = 0.1
"""What is lost beyond this share of the largest energy is wrong at any tolerance."""

STILL = 1e-5
"""What moves slower than this is at rest, and its energy is noise [m/s]."""


def allowed_energy_error(energy: float, mass: float, steps: int, tolerance: float) -> float:
    """The largest energy error that tolerance and round-off explain [J].

    Args:
        energy: Largest energy of any kind in the run [J].
        mass: Mass of the lightest body [kg].
        steps: Number of steps.
        tolerance: `SolverOptions.tolerance`.
    """
    share = min(max(ROUND_OFF, FACTOR * steps * tolerance), LARGEST_SHARE)
    return share * energy + mass * STILL**2


def judge_energy(summary: dict[str, Any]) -> str:
    """What is wrong with the balance of a run, a sentence; empty if nothing is.

    A scheme that does not conserve energy promises nothing.

    Args:
        summary: What `summary.json` holds.
    """
    if names.ALLOWED_ENERGY_ERROR not in summary:
        return ""
    error, allowed = summary[names.WORST_ENERGY_ERROR], summary[names.ALLOWED_ENERGY_ERROR]
    if error <= allowed:
        return ""
    return (
        f"the energy balance is wrong by {error:.2g} J, {_share(error, summary)} of the largest "
        f"energy, where tolerance and round-off explain {_share(allowed, summary)}: do not trust "
        "this run; solver.tolerance is too large, or constants are so far apart (stiffness, "
        "viscosity, masses) that round-off hides the motion"
    )


def _share(part: float, summary: dict[str, Any]) -> str:
    """A part of the largest energy in words."""
    return f"{100.0 * part / max(summary[names.LARGEST_ENERGY], 1e-300):.2g} %"

"""Energy-momentum dynamics of rigid and flexible bodies on FEniCSx, and wind turbines made of them.

The public names are imported on first use, so that the command line answers at once.
"""

from __future__ import annotations

import importlib
from contextlib import suppress
from typing import Any

with suppress(ImportError):  # DOLFINx from PyPI: its MPI must be there before petsc4py
    import dolfinx_solver  # noqa: F401

__version__ = "0.1.0"

_PUBLIC = {
    "AffineVector": "quadratic",
    "Balance": "system",
    "BladeGeometry": "meshing",
    "Case": "turbine.case",
    "Constant": "time_functions",
    "Coupling": "coupling",
    "Cylindrical": "joints",
    "EnergyMomentumSolver": "solver",
    "EnergyMomentumStep": "energy_momentum",
    "FlexibleBody": "flexible_body",
    "FollowerForce": "loads",
    "Gravity": "loads",
    "Hat": "time_functions",
    "History": "observers.history",
    "JointDamper": "elements",
    "JointReaction": "observers.joint_reactions",
    "JointReactions": "observers.joint_reactions",
    "JointSpring": "elements",
    "JointTorque": "loads",
    "KelvinVoigt": "materials",
    "MooneyRivlin": "materials",
    "MultibodySystem": "system",
    "NeoHooke": "materials",
    "NodeForce": "loads",
    "OrthotropicSVK": "materials",
    "Planar": "joints",
    "Point": "observers.points",
    "PointDamper": "elements",
    "PointForce": "loads",
    "PointSpring": "elements",
    "Points": "observers.points",
    "PrescribedMotion": "joints",
    "Pressure": "loads",
    "Prismatic": "joints",
    "Quadratic": "quadratic",
    "Ramp": "time_functions",
    "Revolute": "joints",
    "Rigid": "joints",
    "RigidBody": "rigid_body",
    "Simulation": "simulation",
    "Sine": "time_functions",
    "SolverOptions": "solver",
    "Spherical": "joints",
    "StVenantKirchhoff": "materials",
    "State": "state",
    "StepFailure": "solver",
    "SurfaceTraction": "loads",
    "Table": "time_functions",
    "Torque": "loads",
    "TransverselyIsotropic": "materials",
    "Universal": "joints",
    "cell_field": "cell_fields",
    "dot": "quadratic",
    "equilibrium": "statics",
    "initial_motion": "start",
    "joint_channel": "observers.joint_reactions",
    "point_channel": "observers.points",
}

__all__ = sorted(["__version__", *_PUBLIC])


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_PUBLIC[name]}"), name)


def __dir__() -> list[str]:
    """Public names."""
    return __all__

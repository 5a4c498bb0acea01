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
    "AffineVector": "foundation.quadratic",
    "Balance": "system.system",
    "BladeGeometry": "meshing",
    "Case": "turbine.case.case",
    "Constant": "forces.time_functions",
    "Coupling": "bodies.coupling",
    "Cylindrical": "joints",
    "EnergyMomentumSolver": "time_stepping.solver",
    "EnergyMomentumStep": "time_stepping.energy_momentum",
    "FlexibleBody": "bodies.flexible_body",
    "FollowerForce": "forces",
    "Gravity": "forces",
    "Hat": "forces.time_functions",
    "History": "simulation.observers.history",
    "JointDamper": "forces",
    "JointReaction": "simulation.observers.joint_reactions",
    "JointReactions": "simulation.observers.joint_reactions",
    "JointSpring": "forces",
    "JointTorque": "forces",
    "KelvinVoigt": "materials",
    "MooneyRivlin": "materials",
    "MultibodySystem": "system.system",
    "NeoHooke": "materials",
    "NodeForce": "forces",
    "OrthotropicSVK": "materials",
    "Planar": "joints",
    "Point": "simulation.observers.points",
    "PointDamper": "forces",
    "PointForce": "forces",
    "PointSpring": "forces",
    "Points": "simulation.observers.points",
    "PrescribedMotion": "joints",
    "Pressure": "forces",
    "Prismatic": "joints",
    "Quadratic": "foundation.quadratic",
    "Ramp": "forces.time_functions",
    "Revolute": "joints",
    "Rigid": "joints",
    "RigidBody": "bodies.rigid_body",
    "Simulation": "simulation.simulation",
    "Sine": "forces.time_functions",
    "SolverOptions": "time_stepping.solver",
    "Spherical": "joints",
    "StVenantKirchhoff": "materials",
    "State": "system.state",
    "StepFailure": "time_stepping.solver",
    "SurfaceTraction": "forces",
    "Table": "forces.time_functions",
    "Torque": "forces",
    "TransverselyIsotropic": "materials",
    "Universal": "joints",
    "cell_field": "materials.cell_fields",
    "dot": "foundation.quadratic",
    "equilibrium": "analysis.statics",
    "initial_motion": "system.start",
    "joint_channel": "simulation.observers.joint_reactions",
    "point_channel": "simulation.observers.points",
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

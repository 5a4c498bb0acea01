"""Energy-momentum dynamics of rigid and flexible bodies on FEniCSx, and wind turbines made of them.

The public names are imported on first use, so that the command line answers at once.
"""

from __future__ import annotations

import importlib
from contextlib import suppress
from typing import TYPE_CHECKING, Any

with suppress(ImportError):  # DOLFINx from PyPI: its MPI must be there before petsc4py
    import dolfinx_solver  # noqa: F401

__version__ = "0.2.0"

if TYPE_CHECKING:  # the types of the public names, for mypy and editors
    from turbine_fenicsx.analysis.campbell import Campbell as Campbell
    from turbine_fenicsx.analysis.campbell import campbell as campbell
    from turbine_fenicsx.analysis.damped_modes import damped_modes as damped_modes
    from turbine_fenicsx.analysis.matrices import SystemMatrices as SystemMatrices
    from turbine_fenicsx.analysis.matrices import system_matrices as system_matrices
    from turbine_fenicsx.analysis.mode import Mode as Mode
    from turbine_fenicsx.analysis.mode import Modes as Modes
    from turbine_fenicsx.analysis.mode import Motion as Motion
    from turbine_fenicsx.analysis.mode import Whirl as Whirl
    from turbine_fenicsx.analysis.modes import modes as modes
    from turbine_fenicsx.analysis.statics import equilibrium as equilibrium
    from turbine_fenicsx.analysis.turning import turning_equilibrium as turning_equilibrium
    from turbine_fenicsx.analysis.turning_modes import turning_modes as turning_modes
    from turbine_fenicsx.bodies.coupling import Coupling as Coupling
    from turbine_fenicsx.bodies.flexible_body import FlexibleBody as FlexibleBody
    from turbine_fenicsx.bodies.rigid_body import RigidBody as RigidBody
    from turbine_fenicsx.forces import FollowerForce as FollowerForce
    from turbine_fenicsx.forces import Gravity as Gravity
    from turbine_fenicsx.forces import JointDamper as JointDamper
    from turbine_fenicsx.forces import JointSpring as JointSpring
    from turbine_fenicsx.forces import JointTorque as JointTorque
    from turbine_fenicsx.forces import LineLoad as LineLoad
    from turbine_fenicsx.forces import NodeForce as NodeForce
    from turbine_fenicsx.forces import PointDamper as PointDamper
    from turbine_fenicsx.forces import PointForce as PointForce
    from turbine_fenicsx.forces import PointSpring as PointSpring
    from turbine_fenicsx.forces import Pressure as Pressure
    from turbine_fenicsx.forces import RigidSectionLoads as RigidSectionLoads
    from turbine_fenicsx.forces import RigidStations as RigidStations
    from turbine_fenicsx.forces import SectionLoads as SectionLoads
    from turbine_fenicsx.forces import SectionMotion as SectionMotion
    from turbine_fenicsx.forces import StationLine as StationLine
    from turbine_fenicsx.forces import SurfaceTraction as SurfaceTraction
    from turbine_fenicsx.forces import Torque as Torque
    from turbine_fenicsx.forces.force import StepTimes as StepTimes
    from turbine_fenicsx.forces.surface_point import SurfacePoint as SurfacePoint
    from turbine_fenicsx.forces.time_functions import Constant as Constant
    from turbine_fenicsx.forces.time_functions import Hat as Hat
    from turbine_fenicsx.forces.time_functions import Ramp as Ramp
    from turbine_fenicsx.forces.time_functions import Sine as Sine
    from turbine_fenicsx.forces.time_functions import Table as Table
    from turbine_fenicsx.foundation.errors import ModelError as ModelError
    from turbine_fenicsx.foundation.errors import ModelWarning as ModelWarning
    from turbine_fenicsx.foundation.errors import StepFailure as StepFailure
    from turbine_fenicsx.foundation.quadratic import AffineVector as AffineVector
    from turbine_fenicsx.foundation.quadratic import Quadratic as Quadratic
    from turbine_fenicsx.foundation.quadratic import dot as dot
    from turbine_fenicsx.foundation.restart_data import RestartData as RestartData
    from turbine_fenicsx.joints import Cylindrical as Cylindrical
    from turbine_fenicsx.joints import Planar as Planar
    from turbine_fenicsx.joints import PrescribedMotion as PrescribedMotion
    from turbine_fenicsx.joints import Prismatic as Prismatic
    from turbine_fenicsx.joints import Revolute as Revolute
    from turbine_fenicsx.joints import Rheonomic as Rheonomic
    from turbine_fenicsx.joints import Rigid as Rigid
    from turbine_fenicsx.joints import Spherical as Spherical
    from turbine_fenicsx.joints import Universal as Universal
    from turbine_fenicsx.joints.relation import JointRelation as JointRelation
    from turbine_fenicsx.joints.relation import gear_pair as gear_pair
    from turbine_fenicsx.joints.relation import screw as screw
    from turbine_fenicsx.materials import KelvinVoigt as KelvinVoigt
    from turbine_fenicsx.materials import MooneyRivlin as MooneyRivlin
    from turbine_fenicsx.materials import NeoHooke as NeoHooke
    from turbine_fenicsx.materials import OrthotropicSVK as OrthotropicSVK
    from turbine_fenicsx.materials import StVenantKirchhoff as StVenantKirchhoff
    from turbine_fenicsx.materials import TransverselyIsotropic as TransverselyIsotropic
    from turbine_fenicsx.materials.cell_fields import cell_field as cell_field
    from turbine_fenicsx.meshing import BladeGeometry as BladeGeometry
    from turbine_fenicsx.postprocessing.data_frame import read_run as read_run
    from turbine_fenicsx.simulation.checkpoint import Checkpoints as Checkpoints
    from turbine_fenicsx.simulation.observer import Observer as Observer
    from turbine_fenicsx.simulation.observer import RestartableObserver as RestartableObserver
    from turbine_fenicsx.simulation.observers.fields import Fields as Fields
    from turbine_fenicsx.simulation.observers.gauges import Gauge as Gauge
    from turbine_fenicsx.simulation.observers.gauges import Gauges as Gauges
    from turbine_fenicsx.simulation.observers.gauges import gauge_channel as gauge_channel
    from turbine_fenicsx.simulation.observers.history import Channel as Channel
    from turbine_fenicsx.simulation.observers.history import History as History
    from turbine_fenicsx.simulation.observers.joint_reactions import JointReaction as JointReaction
    from turbine_fenicsx.simulation.observers.joint_reactions import (
        JointReactions as JointReactions,
    )
    from turbine_fenicsx.simulation.observers.joint_reactions import joint_channel as joint_channel
    from turbine_fenicsx.simulation.observers.points import Point as Point
    from turbine_fenicsx.simulation.observers.points import Points as Points
    from turbine_fenicsx.simulation.observers.points import point_channel as point_channel
    from turbine_fenicsx.simulation.simulation import Simulation as Simulation
    from turbine_fenicsx.simulation.snapshot import Snapshot as Snapshot
    from turbine_fenicsx.system.body_fields import BodyFields as BodyFields
    from turbine_fenicsx.system.start import initial_motion as initial_motion
    from turbine_fenicsx.system.state import State as State
    from turbine_fenicsx.system.system import Balance as Balance
    from turbine_fenicsx.system.system import MultibodySystem as MultibodySystem
    from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum as EnergyMomentum
    from turbine_fenicsx.time_stepping.energy_momentum import (
        EnergyMomentumStep as EnergyMomentumStep,
    )
    from turbine_fenicsx.time_stepping.generalised_alpha import GeneralisedAlpha as GeneralisedAlpha
    from turbine_fenicsx.time_stepping.newton import SolverOptions as SolverOptions
    from turbine_fenicsx.time_stepping.stepper import Stepper as Stepper
    from turbine_fenicsx.time_stepping.stepper import StepReport as StepReport
    from turbine_fenicsx.turbine.case.case import Case as Case
    from turbine_fenicsx.turbine.component import Assembly as Assembly
    from turbine_fenicsx.turbine.component import Channels as Channels
    from turbine_fenicsx.turbine.component import Component as Component
    from turbine_fenicsx.turbine.component import Turbine as Turbine
    from turbine_fenicsx.turbine.model import build_turbine as build_turbine
    from turbine_fenicsx.turbine.model import list_components as list_components
    from turbine_fenicsx.turbine.run import restart_case as restart_case
    from turbine_fenicsx.turbine.run import run_case as run_case

_PUBLIC = {
    "AffineVector": "foundation.quadratic",
    "Assembly": "turbine.component",
    "Balance": "system.system",
    "BladeGeometry": "meshing",
    "BodyFields": "system.body_fields",
    "Case": "turbine.case.case",
    "Channel": "simulation.observers.history",
    "Channels": "turbine.component",
    "Checkpoints": "simulation.checkpoint",
    "Component": "turbine.component",
    "Constant": "forces.time_functions",
    "Coupling": "bodies.coupling",
    "Cylindrical": "joints",
    "EnergyMomentum": "time_stepping.energy_momentum",
    "EnergyMomentumStep": "time_stepping.energy_momentum",
    "Fields": "simulation.observers.fields",
    "FlexibleBody": "bodies.flexible_body",
    "FollowerForce": "forces",
    "Gauge": "simulation.observers.gauges",
    "Gauges": "simulation.observers.gauges",
    "GeneralisedAlpha": "time_stepping.generalised_alpha",
    "Gravity": "forces",
    "Hat": "forces.time_functions",
    "History": "simulation.observers.history",
    "JointDamper": "forces",
    "JointReaction": "simulation.observers.joint_reactions",
    "JointReactions": "simulation.observers.joint_reactions",
    "JointRelation": "joints.relation",
    "JointSpring": "forces",
    "JointTorque": "forces",
    "KelvinVoigt": "materials",
    "LineLoad": "forces",
    "Mode": "analysis.mode",
    "ModelError": "foundation.errors",
    "ModelWarning": "foundation.errors",
    "Modes": "analysis.mode",
    "Motion": "analysis.mode",
    "MooneyRivlin": "materials",
    "MultibodySystem": "system.system",
    "NeoHooke": "materials",
    "NodeForce": "forces",
    "Observer": "simulation.observer",
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
    "RestartData": "foundation.restart_data",
    "RestartableObserver": "simulation.observer",
    "Revolute": "joints",
    "Rheonomic": "joints",
    "Rigid": "joints",
    "RigidBody": "bodies.rigid_body",
    "RigidSectionLoads": "forces",
    "RigidStations": "forces",
    "SectionLoads": "forces",
    "SectionMotion": "forces",
    "Simulation": "simulation.simulation",
    "Sine": "forces.time_functions",
    "Snapshot": "simulation.snapshot",
    "SolverOptions": "time_stepping.newton",
    "Spherical": "joints",
    "StVenantKirchhoff": "materials",
    "State": "system.state",
    "StepFailure": "foundation.errors",
    "StepReport": "time_stepping.stepper",
    "StationLine": "forces",
    "StepTimes": "forces.force",
    "Stepper": "time_stepping.stepper",
    "SurfacePoint": "forces.surface_point",
    "SurfaceTraction": "forces",
    "Table": "forces.time_functions",
    "Torque": "forces",
    "TransverselyIsotropic": "materials",
    "Turbine": "turbine.component",
    "Universal": "joints",
    "build_turbine": "turbine.model",
    "cell_field": "materials.cell_fields",
    "dot": "foundation.quadratic",
    "equilibrium": "analysis.statics",
    "turning_equilibrium": "analysis.turning",
    "Campbell": "analysis.campbell",
    "Whirl": "analysis.mode",
    "campbell": "analysis.campbell",
    "damped_modes": "analysis.damped_modes",
    "turning_modes": "analysis.turning_modes",
    "SystemMatrices": "analysis.matrices",
    "system_matrices": "analysis.matrices",
    "read_run": "postprocessing.data_frame",
    "gauge_channel": "simulation.observers.gauges",
    "gear_pair": "joints.relation",
    "initial_motion": "system.start",
    "joint_channel": "simulation.observers.joint_reactions",
    "list_components": "turbine.model",
    "modes": "analysis.modes",
    "point_channel": "simulation.observers.points",
    "screw": "joints.relation",
    "restart_case": "turbine.run",
    "run_case": "turbine.run",
}

__all__ = sorted(["__version__", *_PUBLIC])


if not TYPE_CHECKING:  # else every misspelt name would be there, with the type Any

    def __getattr__(name: str) -> Any:
        """Import a public name on first use."""
        if name not in _PUBLIC:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{__name__}.{_PUBLIC[name]}"), name)


def __dir__() -> list[str]:
    """Public names."""
    return __all__

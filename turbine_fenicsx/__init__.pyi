"""The public names, and where they are; types for mypy and editors."""

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
from turbine_fenicsx.bodies.placement import Placement as Placement
from turbine_fenicsx.bodies.reduced_body import ReducedBasis as ReducedBasis
from turbine_fenicsx.bodies.reduced_body import ReducedBody as ReducedBody
from turbine_fenicsx.bodies.rigid_body import RigidBody as RigidBody
from turbine_fenicsx.bodies.surface_frame import SurfaceFrame as SurfaceFrame
from turbine_fenicsx.forces.body_force import BodyForce as BodyForce
from turbine_fenicsx.forces.follower_force import FollowerForce as FollowerForce
from turbine_fenicsx.forces.force import StepTimes as StepTimes
from turbine_fenicsx.forces.gravity import Gravity as Gravity
from turbine_fenicsx.forces.joint_damper import JointDamper as JointDamper
from turbine_fenicsx.forces.joint_spring import JointSpring as JointSpring
from turbine_fenicsx.forces.joint_torque import JointTorque as JointTorque
from turbine_fenicsx.forces.node_force import NodeForce as NodeForce
from turbine_fenicsx.forces.point_damper import PointDamper as PointDamper
from turbine_fenicsx.forces.point_force import PointForce as PointForce
from turbine_fenicsx.forces.point_spring import PointSpring as PointSpring
from turbine_fenicsx.forces.pressure import Pressure as Pressure
from turbine_fenicsx.forces.rayleigh_damping import HeldPart as HeldPart
from turbine_fenicsx.forces.rayleigh_damping import RayleighDamping as RayleighDamping
from turbine_fenicsx.forces.rigid_section_loads import RigidSectionLoads as RigidSectionLoads
from turbine_fenicsx.forces.rigid_section_loads import RigidStations as RigidStations
from turbine_fenicsx.forces.section_loads import LineLoad as LineLoad
from turbine_fenicsx.forces.section_loads import SectionLoads as SectionLoads
from turbine_fenicsx.forces.section_loads import SectionMotion as SectionMotion
from turbine_fenicsx.forces.section_loads import StationLine as StationLine
from turbine_fenicsx.forces.surface_point import SurfacePoint as SurfacePoint
from turbine_fenicsx.forces.surface_traction import SurfaceTraction as SurfaceTraction
from turbine_fenicsx.forces.time_functions import Constant as Constant
from turbine_fenicsx.forces.time_functions import Hat as Hat
from turbine_fenicsx.forces.time_functions import Ramp as Ramp
from turbine_fenicsx.forces.time_functions import Sine as Sine
from turbine_fenicsx.forces.time_functions import Table as Table
from turbine_fenicsx.forces.torque import Torque as Torque
from turbine_fenicsx.foundation.errors import ModelError as ModelError
from turbine_fenicsx.foundation.errors import ModelWarning as ModelWarning
from turbine_fenicsx.foundation.errors import StepFailure as StepFailure
from turbine_fenicsx.foundation.quadratic import AffineVector as AffineVector
from turbine_fenicsx.foundation.quadratic import Quadratic as Quadratic
from turbine_fenicsx.foundation.quadratic import dot as dot
from turbine_fenicsx.foundation.restart_data import RestartData as RestartData
from turbine_fenicsx.joints.cylindrical import Cylindrical as Cylindrical
from turbine_fenicsx.joints.planar import Planar as Planar
from turbine_fenicsx.joints.prescribed_motion import PrescribedMotion as PrescribedMotion
from turbine_fenicsx.joints.prismatic import Prismatic as Prismatic
from turbine_fenicsx.joints.relation import JointRelation as JointRelation
from turbine_fenicsx.joints.relation import gear_pair as gear_pair
from turbine_fenicsx.joints.relation import screw as screw
from turbine_fenicsx.joints.revolute import Revolute as Revolute
from turbine_fenicsx.joints.rheonomic import Rheonomic as Rheonomic
from turbine_fenicsx.joints.rigid import Rigid as Rigid
from turbine_fenicsx.joints.spherical import Spherical as Spherical
from turbine_fenicsx.joints.universal import Universal as Universal
from turbine_fenicsx.materials.cell_fields import cell_field as cell_field
from turbine_fenicsx.materials.kelvin_voigt import KelvinVoigt as KelvinVoigt
from turbine_fenicsx.materials.law_check import check_material as check_material
from turbine_fenicsx.materials.mooney_rivlin import MooneyRivlin as MooneyRivlin
from turbine_fenicsx.materials.neo_hooke import NeoHooke as NeoHooke
from turbine_fenicsx.materials.orthotropic import OrthotropicSVK as OrthotropicSVK
from turbine_fenicsx.materials.principal import squared_stretches as squared_stretches
from turbine_fenicsx.materials.st_venant_kirchhoff import StVenantKirchhoff as StVenantKirchhoff
from turbine_fenicsx.materials.transversely_isotropic import (
    TransverselyIsotropic as TransverselyIsotropic,
)
from turbine_fenicsx.meshing import BladeGeometry as BladeGeometry
from turbine_fenicsx.meshing.load import load_msh as load_msh
from turbine_fenicsx.postprocessing.data_frame import read_run as read_run
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile as VtkHdfFile
from turbine_fenicsx.reduction.basis_file import read_basis as read_basis
from turbine_fenicsx.reduction.basis_file import write_basis as write_basis
from turbine_fenicsx.reduction.judge import judge as judge
from turbine_fenicsx.reduction.load_path import LoadPath as LoadPath
from turbine_fenicsx.reduction.reduce_body import reduce_body as reduce_body
from turbine_fenicsx.reduction.smooth_loads import smooth_loads as smooth_loads
from turbine_fenicsx.reduction.verdict import Verdict as Verdict
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
from turbine_fenicsx.time_stepping.solver_options import SolverOptions as SolverOptions
from turbine_fenicsx.time_stepping.stepper import Stepper as Stepper
from turbine_fenicsx.time_stepping.stepper import StepReport as StepReport
from turbine_fenicsx.turbine.case.case import Case as Case
from turbine_fenicsx.turbine.components.component import Assembly as Assembly
from turbine_fenicsx.turbine.components.component import Channels as Channels
from turbine_fenicsx.turbine.components.component import Component as Component
from turbine_fenicsx.turbine.components.component import Turbine as Turbine
from turbine_fenicsx.turbine.components.model import build_turbine as build_turbine
from turbine_fenicsx.turbine.components.model import list_components as list_components
from turbine_fenicsx.turbine.run.run import restart_case as restart_case
from turbine_fenicsx.turbine.run.run import run_case as run_case

__version__: str

"""Recorded runs and the assertions about conservation that all verification tests share."""

from dataclasses import dataclass, field

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import (
    Case,
    EnergyMomentum,
    MultibodySystem,
    Simulation,
    SolverOptions,
    Stepper,
)
from turbine_fenicsx.turbine.components.model import Turbine
from turbine_fenicsx.turbine.run.run import make_stepper

comm = MPI.COMM_WORLD


@dataclass
class Record:
    """Time series of a run; an observer. After the run every entry is an array over time."""

    time: list = field(default_factory=list)
    kinetic: list = field(default_factory=list)
    strain: list = field(default_factory=list)
    potential: list = field(default_factory=list)
    total: list = field(default_factory=list)
    energy_error: list = field(default_factory=list)
    linear: list = field(default_factory=list)
    angular: list = field(default_factory=list)
    joint_coordinates: list = field(default_factory=list)
    multipliers: list = field(default_factory=list)
    q: list = field(default_factory=list)
    constraint_error: list = field(default_factory=list)
    newton: list = field(default_factory=list)

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, snapshot):
        b, s = snapshot.balance, snapshot.state
        self.time.append(s.time)
        self.kinetic.append(b.kinetic)
        self.strain.append(b.strain)
        self.potential.append(b.potential)
        self.total.append(b.total)
        self.energy_error.append(snapshot.energy_error)
        self.linear.append(b.linear.copy())
        self.angular.append(b.angular.copy())
        self.joint_coordinates.append(s.joint_coordinates.copy())
        self.multipliers.append(s.multipliers.copy())
        self.q.append(s.q.copy())
        self.constraint_error.append(snapshot.constraint_error)
        self.newton.append(snapshot.report.newton_iterations if snapshot.report else 0)

    def finish(self):
        for name, values in vars(self).items():
            setattr(self, name, np.array(values))

    @property
    def largest_energy(self):
        return max(np.max(np.abs(e)) for e in (self.kinetic, self.strain, self.potential))

    def after(self, time):
        """Indices of the steps that begin at a time or later."""
        return self.time >= time * (1.0 - 1e-9)


def run(system: MultibodySystem, dt: float, end: float, scheme=None, **options) -> Record:
    """Run a system, with options of the scheme and of its solver."""
    stepper = EnergyMomentum(system, **(scheme or {}), options=SolverOptions(**options))
    return run_with(stepper, dt, end)


def run_turbine(case: Case, turbine: Turbine, dt: float, end: float) -> Record:
    """Run a turbine as its case says."""
    return run_with(make_stepper(case, turbine.system), dt, end)


def run_with(stepper: Stepper, dt: float, end: float) -> Record:
    """Run and free a stepper; no step may be halved, so that dt is what the test says."""
    record = Record()
    simulation = Simulation(stepper.system, dt, end, [record], stepper)
    simulation.run()
    stepper.destroy()
    assert simulation.halvings == 0
    return record


def mass_and_centre(system: MultibodySystem):
    """Total mass [kg] and initial centre of mass [m]. Collective."""
    masses = [body.mass for body in system.rigid_bodies]
    moment = sum((b.mass * np.asarray(b.position, float) for b in system.rigid_bodies), np.zeros(3))
    for block in system.flexible_models:
        masses.append(system.comm.allreduce(block.nodal_mass.sum()))
        moment = moment + system.comm.allreduce(block.nodal_mass @ block.positions)
    return sum(masses), moment / sum(masses)


def assert_energy_is_balanced(r: Record, unloaded_from: float, tolerance: float) -> None:
    """Energy minus work is constant, and energy itself once the loads have ended.

    Args:
        r: The run.
        unloaded_from: Time from which on no load acts but gravity [s].
        tolerance: Relative to the largest energy of any kind.
    """
    scale = r.largest_energy
    assert np.max(np.abs(r.energy_error)) <= tolerance * scale
    assert np.max(np.abs(np.diff(r.total[r.after(unloaded_from)]))) <= tolerance * scale


def assert_momenta_are_balanced(
    r: Record, mass: float, centre: np.ndarray, gravity: np.ndarray, tolerance: float
) -> None:
    """Linear and angular momentum of a system without ground follow from its weight alone.

    The centre of mass moves on a parabola, so that both are polynomials in time, which the
    scheme meets without error: dp/dt = m g, dL/dt = x_c(t) x m g.
    """
    t = r.time[:, None]
    weight = mass * gravity
    p = r.linear[0] + weight * t
    moment = np.cross(centre, weight) * t + np.cross(r.linear[0], weight) / mass * t**2 / 2
    L = r.angular[0] + moment
    speed = np.sqrt(2.0 * np.max(r.kinetic) / mass)
    assert np.max(np.abs(r.linear - p)) <= tolerance * mass * speed
    assert np.max(np.abs(r.angular - L)) <= tolerance * np.max(np.abs(r.angular))


def assert_constraints_hold(r: Record, tolerance: float = 1e-12) -> None:
    """All constraints hold to ``tolerance`` [m, -] at the end of every step."""
    assert np.max(r.constraint_error) <= tolerance

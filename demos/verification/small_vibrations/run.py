"""Frequencies of small vibrations: beams, pendulums, turbines.

All errors are relative, the largest of some frequencies.

A clamped beam of square section, 150 times as long as wide, against the frequencies of Bernoulli
and Euler: each is there twice. Poisson's ratio is zero, because the clamp of a solid keeps its
section from getting narrower. The solid's own physics, shear and rotary inertia, lowers the eighth
frequency by 17 (h/l)^2 = 8e-4.

A clamped beam 10 times as long as wide, and a free block, against a plain script of DOLFINx and
SLEPc with the same mesh and elements; the block's six motions without stiffness are found as such.

Pendulums and a row of four-bar linkages that hangs, with six redundant constraints: rigid bodies
with all their directors, constraints and constraint forces, which are what gives a pendulum its
stiffness, against equations with one or two angles.

The paper's turbine with yaw and rotor held by prescribed motions vibrates like its blades, clamped
each by itself. With rigid blades on the flexible tower, yaw and rotor held, it is a tower with one
rigid body on its top, whose mass and inertia are added up by hand. With flexible blades on the
tower, yaw and rotor free, it starts to move in its first mode for a run in time without gravity;
zero crossings of the tower's top give the frequency. A step of midpoint type lowers it,
w = 2/dt tan(w_run dt/2).
"""

import tomllib
from pathlib import Path

from mpi4py import MPI

import numpy as np
from dolfinx import mesh
from published import Row, load, references

import turbine_fenicsx
from turbine_fenicsx import (
    Case,
    Constant,
    Coupling,
    FlexibleBody,
    Gravity,
    MultibodySystem,
    PrescribedMotion,
    Revolute,
    RigidBody,
    Simulation,
    StVenantKirchhoff,
    build_turbine,
    modes,
)

G = 9.81  # [m/s^2]
YOUNG, DENSITY = 210e9, 7850.0  # of steel
WIDTH = 0.1  # of beams [m]
SLENDER = ((15.0, WIDTH, WIDTH), (72, 1, 1))  # edges [m], elements
BEAM = ((1.0, WIDTH, WIDTH), (10, 1, 1))
BLOCK = ((0.5, 0.3, 0.2), (5, 3, 2))
TOWER = {"flexible": True, "elements": [8, 1, 8], "degree": 2}
AMPLITUDE = 1e-3  # velocity of the run, in masses 1 kg [m/s]
STEPS_PER_PERIOD, PERIODS = 40, 3


def lame(poisson):
    """Lame constants of steel with any ratio of Poisson [Pa]."""
    mu = 0.5 * YOUNG / (1.0 + poisson)
    return 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu


def solid(size, elements, comm, poisson=0.3):
    """A brick of steel that begins at the origin."""
    cells = mesh.create_box(comm, [(0.0, 0.0, 0.0), size], elements, mesh.CellType.hexahedron)
    return FlexibleBody("solid", cells, StVenantKirchhoff(*lame(poisson)), DENSITY, 2)


def clamp(body):
    """The coupling that holds it there."""
    root = mesh.locate_entities_boundary(body.mesh, 2, lambda x: np.isclose(x[0], 0.0))
    return Coupling("root", body, root, None)


def frequencies(system, count):
    """The lowest frequencies [Hz]."""
    found = modes(system, count=count)
    values = np.array([m.frequency for m in found.modes])
    found.destroy()
    found.state.destroy()
    return values


def error(values, expected):
    """Largest relative error."""
    return float(np.max(np.abs(np.divide(values, expected) - 1.0)))


def slender_beam(comm):
    """The slender beam as a system."""
    body = solid(*SLENDER, comm, poisson=0.0)
    return MultibodySystem(comm, [body, clamp(body)])


def beam_error(comm):
    """Error of the slender beam."""
    found = frequencies(slender_beam(comm), 8)
    stiffness, mass = YOUNG * WIDTH**4 / 12.0, DENSITY * WIDTH**2
    beam = load("small_vibrations", "exact").clamped_beam(4, stiffness, mass, SLENDER[0][0])
    return {"slender": error(found, np.repeat(beam, 2))}


def plain_errors(comm):
    """Errors of the clamped beam and of the free block, and the motions of this without stiffness.

    The plain script cannot do without a shift for the block; it is about the square of the first
    frequency.
    """
    plain = load("small_vibrations", "plain")
    body = solid(*BEAM, comm)
    root = clamp(body)
    found = frequencies(MultibodySystem(comm, [body, root]), 8)
    beam = plain.frequencies(body.mesh, lame(0.3), DENSITY, 8, 0.0, clamped=root.facets)
    body = solid(*BLOCK, comm)
    free = modes(MultibodySystem(comm, [body]), count=12)
    block = plain.frequencies(body.mesh, lame(0.3), DENSITY, 12, 1e7)
    return {
        "beam": error(found, beam),
        "block_rigid": float(sum(m.is_rigid for m in free.modes)),
        "block": error([m.frequency for m in free.modes[6:]], block[6:]),
    }


def pendulum_errors(comm):
    """Errors of systems of rigid bodies under gravity."""
    exact, down = load("small_vibrations", "exact"), Gravity((0.0, -G, 0.0))
    body = RigidBody("body", 3.0, (0.4, 0.7, 0.2), position=(0.3, -1.2, 0.5))
    pin = Revolute("pin", None, body, point=(0.3, 0.0, 0.5), axis=(0.0, 0.0, 1.0))
    one = exact.pendulum(3.0, 1.2, 0.4 + 0.7, G)
    rod = {"mass": 1.0, "euler": (0.5 / 12.0, 0.5 / 12.0, 0.0)}  # J3 = 1/12, length 1
    a, b = (RigidBody(name, position=(0, y, 0), **rod) for name, y in (("a", -0.5), ("b", -1.5)))
    hinges = [
        Revolute("upper", None, a, point=(0, 0, 0), axis=(0, 0, 1)),
        Revolute("lower", a, b, point=(0, -1, 0), axis=(0, 0, 1)),
    ]
    rods = load("four_bar")
    systems = {
        "pendulum": ([body, pin, down], one),
        "double_pendulum": ([a, b, *hinges, down], exact.double_pendulum(1.0, G)),
        "four_bar": (
            [*rods.linkage(), Gravity((0.0, rods.G, 0.0))],
            exact.four_bars(rods.WINDOWS, rods.LENGTH, rods.G),
        ),
    }
    return {
        name: error(frequencies(MultibodySystem(comm, parts), np.size(value)), value)
        for name, (parts, value) in systems.items()
    }


def turbine(comm, **tables):
    """The paper's turbine with stiff blades and without gravity, with other tables of the case."""
    path = Path(turbine_fenicsx.__file__).parent / "demos" / "hybrid_stiff.toml"
    case = tomllib.loads(path.read_text(encoding="utf-8")) | {"loads": {"gravity": "0 m/s^2"}}
    return build_turbine(Case.parse(case | tables), comm)


def held(built):
    """The parts of a turbine, with all its joints held."""
    names = built.system.joint_coordinate_names
    return [*built.parts, *(PrescribedMotion(name, Constant(0.0)) for name in names)]


def locked_error(comm):
    """Error of the turbine with locked joints, to clamped blades."""
    built = turbine(comm)
    roots = [p for p in built.parts if isinstance(p, Coupling)]
    blades = list(dict.fromkeys(p.flexible for p in roots))
    clamps = [Coupling(p.name, p.flexible, p.facets, None) for p in roots]
    locked, clamped = (MultibodySystem(comm, p) for p in (held(built), [*blades, *clamps]))
    return {"locked": error(frequencies(locked, 12), frequencies(clamped, 12))}


def tower_error(comm):
    """Error of the turbine with rigid blades on its tower, to one body on a tower."""
    built = turbine(comm, turbine={"model": "rigid"}, tower=TOWER)
    bodies = built.system.rigid_bodies
    mass = sum(b.mass for b in bodies)
    centre = sum(b.mass * np.asarray(b.position) for b in bodies) / mass
    J = np.zeros((3, 3))
    for b in bodies:
        D, d = np.asarray(b.directors), np.asarray(b.position) - centre
        J += np.sum(b.euler) * np.eye(3) - D @ np.diag(b.euler) @ D.T
        J += b.mass * (d @ d * np.eye(3) - np.outer(d, d))
    top = RigidBody.from_inertia("top", mass, J, position=centre)
    parts = [p for p in built.parts if isinstance(p, FlexibleBody)] + [top]
    for p in built.parts:
        if isinstance(p, Coupling):
            carrier = None if p.rigid is None else top
            parts.append(Coupling(p.name, p.flexible, p.facets, carrier))
    turbine_modes = frequencies(MultibodySystem(comm, held(built)), 6)
    return {"tower": error(turbine_modes, frequencies(MultibodySystem(comm, parts), 6))}


class Sway:
    """Observer of a coordinate: time and value of all steps."""

    def __init__(self, coordinate):
        self.coordinate, self.rows = coordinate, []

    def start(self, snapshot, resumed):
        """Keep the first value."""
        self.observe(snapshot)

    def observe(self, snapshot):
        """Keep a value."""
        self.rows.append((snapshot.state.time, snapshot.state.q[self.coordinate]))

    def finish(self):
        """There is no file to close."""

    def frequency(self):
        """From the first to the last zero crossing, by interpolation."""
        t, x = np.array(self.rows).T
        x = x - x[0]
        k = np.flatnonzero(x[1:-1] * x[2:] < 0.0) + 1
        crossings = np.append(0.0, t[k] - x[k] * (t[k + 1] - t[k]) / (x[k + 1] - x[k]))
        return 0.5 * (len(crossings) - 1) / crossings[-1]


def run_error(comm):
    """Error of the first mode of the turbine on its tower, to a run in time."""
    system = turbine(comm, tower=TOWER).system
    found = modes(system, count=4)
    first = next(m for m in found.modes if not m.is_rigid)
    start = system.initial_state()
    start.q_dot[:] = AMPLITUDE * first.real.q
    for v, u in zip(start.v, first.real.u, strict=True):
        u.copy(v)
        v.scale(AMPLITUDE)
    places = np.arange(start.q.size) // 3 % 4 == 0
    largest = np.argmax(np.abs(np.where(places, first.real.q, 0.0)))
    dt = 1.0 / (STEPS_PER_PERIOD * first.frequency)
    sway = Sway(int(largest))
    Simulation(system, dt, (PERIODS + 0.5) * STEPS_PER_PERIOD * dt, [sway], start=start).run()
    corrected = np.tan(np.pi * sway.frequency() * dt) / (np.pi * dt)
    return {"run": error(first.frequency, corrected)}


def main(comm=MPI.COMM_WORLD):
    """Rows of the table."""
    found = beam_error(comm) | plain_errors(comm) | pendulum_errors(comm)
    found |= locked_error(comm) | tower_error(comm) | run_error(comm)
    return [
        Row(r.quantity, r.unit, r.value, found[k], r.tolerance, round_off=0.0 < r.tolerance < 1e-5)
        for k, r in references("small_vibrations").items()
    ]

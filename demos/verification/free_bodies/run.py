"""Thrown bodies and a thrown chain.

A bundle of different bodies is thrown, each with a different spin, and so is a chain of bodies
with spherical joints between them. Nothing but gravity acts from outside. So linear and angular
momentum are known at any time, whatever the bodies do: with the mass `M`, its centre `x_c` and
the momenta `p`, `L` about the origin at the start,

    p(t) = p + M g t,        L(t) = L + x_c x M g t + p x g t^2 / 2.

The step keeps such polynomials exactly: forces act at the middle of the step, and joint forces
have neither resultant nor moment. Each body of the bundle keeps its own angular momentum about its
centre of mass, too, and all keep their energy. Only round-off and the residual of a step are left,
although the bodies turn by up to 0.4 rad in each.
"""

from mpi4py import MPI

import numpy as np
from published import Row, references

from turbine_fenicsx import Gravity, MultibodySystem, RigidBody, Simulation, Spherical
from turbine_fenicsx.foundation.rotations import rotation_about

G = np.array([0.0, -9.81, 0.0])  # [m/s^2]
STEP = 0.02  # [s]
BODIES = 12  # of the bundle
LINKS = 8  # of the chain
LENGTH = 0.5  # of a link [m]
SEED = 1


def random_body(name, rng, position):
    """A body of any shape, thrown with about 5 m/s and 10 rad/s."""
    return RigidBody(
        name,
        mass=rng.uniform(0.5, 5.0),
        euler=rng.uniform(0.01, 0.1, 3),
        position=position,
        directors=rotation_about(rng.normal(size=3), rng.uniform(0.0, np.pi)),
        velocity=rng.normal(scale=5.0, size=3),
        angular_velocity=rng.normal(scale=6.0, size=3),
    )


def bundle():
    """Bodies without joints."""
    rng = np.random.default_rng(SEED)
    return [random_body(f"body_{k}", rng, rng.normal(size=3)) for k in range(BODIES)]


def chain():
    """Links along e1 with spherical joints between them, all turning as each of them likes.

    The velocities fit the joints: each link turns about the end of the one before.
    """
    rng = np.random.default_rng(SEED)
    half = np.array([0.5 * LENGTH, 0.0, 0.0])
    links, joints = [], []
    end, velocity = np.zeros(3), rng.normal(scale=3.0, size=3)
    for k in range(LINKS):
        omega = rng.normal(scale=6.0, size=3)
        link = RigidBody(
            f"link_{k}",
            mass=rng.uniform(0.5, 5.0),
            euler=rng.uniform(0.01, 0.1, 3),
            position=end + half,
            velocity=velocity + np.cross(omega, half),
            angular_velocity=omega,
        )
        if links:
            joints.append(Spherical(f"joint_{k}", links[-1], link, point=end))
        links.append(link)
        end, velocity = end + 2.0 * half, velocity + np.cross(omega, 2.0 * half)
    return [*links, *joints]


class Momenta:
    """Observer of time, momenta and energies."""

    def __init__(self, masses):
        """``masses`` is the diagonal of the mass matrix."""
        self.masses, self.rows, self.spins = masses, [], []

    def start(self, snapshot, resumed):
        """Keep the first state."""
        self.observe(snapshot)

    def observe(self, snapshot):
        """Keep the momenta, also of each body about its centre of mass."""
        b, s = snapshot.balance, snapshot.state
        self.rows.append([s.time, *b.linear, *b.angular, b.kinetic, snapshot.energy_error])
        p = (self.masses * s.q_dot).reshape(-1, 4, 3)
        self.spins.append(np.cross(s.q.reshape(-1, 4, 3), p)[:, 1:].sum(axis=1))

    def finish(self):
        """Arrays over time."""
        columns = np.split(np.array(self.rows), [1, 4, 7, 8], axis=1)
        self.time, self.linear, self.angular, self.kinetic, self.energy_error = columns
        self.spins = np.array(self.spins)


def errors(parts, steps, comm=MPI.COMM_WORLD):
    """Largest errors of a run, relative to the largest values of what they are errors of."""
    bodies = [part for part in parts if isinstance(part, RigidBody)]
    masses = np.concatenate([body.masses for body in bodies])
    system = MultibodySystem(comm, [*parts, Gravity(tuple(G))])
    seen = Momenta(masses)
    Simulation(system, STEP, steps * STEP, [seen]).run()
    t, p, L = seen.time, seen.linear, seen.angular
    M = sum(body.mass for body in bodies)
    x_c = sum(body.mass * np.asarray(body.position) for body in bodies) / M
    p_exact = p[0] + M * G * t
    L_exact = L[0] + np.cross(x_c, M * G) * t + np.cross(p[0], G) * t**2 / 2.0
    return {
        "linear": largest(p - p_exact) / largest(p),
        "angular": largest(L - L_exact) / largest(L),
        "spin": largest(seen.spins - seen.spins[0]) / largest(seen.spins),
        "energy": largest(seen.energy_error) / largest(seen.kinetic),
    }


def largest(values):
    """Largest absolute value."""
    return float(np.max(np.abs(values)))


def main(steps=100):
    """Rows of the table."""
    found = {}
    for name, parts in (("bundle", bundle()), ("chain", chain())):
        found |= {f"{name}_{key}": error for key, error in errors(parts, steps).items()}
    return [
        Row(r.quantity, r.unit, r.value, found[name], r.tolerance, round_off=True)
        for name, r in references("free_bodies").items()
    ]

"""Top in steady precession.

A symmetric top with a fixed point, its axis tilted by `theta`, precesses at a constant rate
`omega_p` about the vertical without nutation if it spins about its axis at the right rate:

    omega_s = m g l / (J3 omega_p) + (J1 + m l^2 - J3) omega_p cos(theta) / J3,
    omega = omega_p e3 + omega_s d3,

with its inertia `J1 = J2`, `J3` about the centre of mass, which is at `l d3`. So all of its
motion is known: the axis `d3` runs round a circle, and the body turns by `omega_s t` about it.

The top is a cone of 0.1 m that stands on its tip. It starts on the exact motion and is followed
for one turn of the axis, in which it spins fourteen times. In steps of finite length it nutates a
little and precesses at a slightly different rate; both must vanish with the square of the step.
"""

from mpi4py import MPI

import numpy as np
from published import references, refine

from turbine_fenicsx import Gravity, MultibodySystem, RigidBody, Simulation, Spherical
from turbine_fenicsx.foundation.rotations import E1, E3, rotation_about

DENSITY, HEIGHT, RADIUS = 2700.0, 0.1, 0.05  # of the cone [kg/m^3, m, m]
G = 9.81  # [m/s^2]
THETA = np.pi / 3.0  # tilt [rad]
OMEGA_P = 10.0  # rate of precession [rad/s]
END = 2.0 * np.pi / OMEGA_P  # [s]

MASS = DENSITY * np.pi * RADIUS**2 * HEIGHT / 3.0
ARM = 0.75 * HEIGHT  # l, from the tip of a cone to its centre of mass
J1 = 3.0 / 80.0 * MASS * (4.0 * RADIUS**2 + HEIGHT**2)
J3 = 3.0 / 10.0 * MASS * RADIUS**2
OMEGA_S = MASS * G * ARM / (J3 * OMEGA_P) + (J1 + MASS * ARM**2 - J3) * OMEGA_P * np.cos(THETA) / J3


class Angles:
    """Observer of tilt, precession and spin."""

    def __init__(self):
        """Nothing is seen yet."""
        self.directors = []

    def start(self, snapshot, resumed):
        """Keep the first state."""
        self.observe(snapshot)

    def observe(self, snapshot):
        """Keep the directors."""
        self.directors.append(snapshot.state.q[3:12].reshape(3, 3).copy())

    def finish(self):
        """Tilt theta, precession psi and spin phi of R = R3(psi) R1(theta) R3(phi)."""
        d1, d2, d3 = np.moveaxis(np.array(self.directors), 1, 0)
        self.theta = np.arccos(d3[:, 2])
        self.psi = np.unwrap(np.arctan2(d3[:, 0], -d3[:, 1]))
        self.phi = np.unwrap(np.arctan2(d1[:, 2], d2[:, 2]))


def solve(steps, comm=MPI.COMM_WORLD):
    """Errors of the tilt and both angles at the end, for a number of steps."""
    R = rotation_about(E1, THETA)
    omega = OMEGA_P * E3 + OMEGA_S * R[:, 2]
    x = ARM * R[:, 2]
    top = RigidBody.from_inertia(
        "top",
        MASS,
        (J1, J1, J3),
        position=x,
        axes=R,
        velocity=np.cross(omega, x),
        angular_velocity=omega,
    )
    joint = Spherical("tip", None, top, point=(0.0, 0.0, 0.0))
    system = MultibodySystem(comm, [top, joint, Gravity((0.0, 0.0, -G))])
    seen = Angles()
    Simulation(system, END / steps, END, [seen]).run()
    return {
        "tilt": np.max(np.abs(seen.theta - THETA)),
        "precession": seen.psi[-1] - seen.psi[0],
        "spin": seen.phi[-1] - seen.phi[0],
    }


def main(steps=(250, 500, 1000, 2000)):
    """Rows of the table."""
    return refine(solve, steps, END, references("steady_top"))

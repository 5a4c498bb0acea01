"""Heavy top of Brüls, Cardona and Arnold.

A disk of mass `m` turns about a point `O` that is fixed in space. Its centre of mass is at
`x = R X`, where `R` is its rotation and `X` the place of the centre of mass in the body. With the
inertia `J` about the centre of mass the body moves by

    m x'' = m g + lambda,        (J_O Omega)' + Omega x J_O Omega = X x m R^T g,
    R' = R skew(Omega),          J_O = J + m (|X|^2 I - X X^T).

It spins at 150 rad/s about the axis through `O`, so that it precesses slowly and nutates fast.

Here the directors `d_i = R e_i` and `x` are twelve coordinates `q`. The spherical joint is the
constraint `Phi(q) = x - sum X_i d_i = 0` with the multiplier `lambda`, and the Euler tensor
`E = tr(J)/2 I - J` takes the place of `J`. The step is of second order in all of `q`. Four runs
with steps halved from 2 ms on are extrapolated to a step of zero.
"""

from mpi4py import MPI

import numpy as np
from published import references, refine

from turbine_fenicsx import Gravity, MultibodySystem, RigidBody, Simulation, Spherical

MASS = 15.0  # m [kg]
INERTIA = np.array([0.234375, 0.46875, 0.234375])  # J [kg m^2]
ARM = np.array([0.0, 1.0, 0.0])  # X [m]
SPIN = np.array([0.0, 150.0, -4.61538])  # Omega(0) [rad/s]
GRAVITY = (0.0, 0.0, -9.81)  # g [m/s^2]
END = 2.0  # [s]


def solve(steps, comm=MPI.COMM_WORLD):
    """Centre of mass at the end, for a number of steps."""
    top = RigidBody.from_inertia(
        "top",
        MASS,
        INERTIA,
        position=ARM,
        velocity=np.cross(SPIN, ARM),
        angular_velocity=SPIN,
    )
    joint = Spherical("O", None, top, point=(0.0, 0.0, 0.0))
    system = MultibodySystem(comm, [top, joint, Gravity(GRAVITY)])
    last = Simulation(system, END / steps, END).run()
    return dict(zip(("x1", "x2", "x3"), last.state.q[:3], strict=True))


def main(steps=(1000, 2000, 4000, 8000)):
    """Rows of the table."""
    return refine(solve, steps, END, references("heavy_top"))

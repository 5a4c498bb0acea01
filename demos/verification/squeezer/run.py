"""Andrews' squeezing mechanism.

Seven bodies `K1 ... K7` in a plane, three closed loops, one degree of freedom, no gravity. A
constant torque turns the crank `K1`, and within 0.03 s to more than 10 000 revolutions a minute; a
spring pulls at `K3`.

    K1  crank O F                           angle beta,   of OF with x
    K2  from F to E                         angle Theta,  of EF with OF
    K3  triangle B E D, spring from D to C  angle gamma,  of the side parallel to x
    K4  from G to E, K5 from A to G         angles Phi of K4 with K5, delta of K5
    K6  from H to E, K7 from A to H         angles Omega of K6 with K7, epsilon of K7

`O, A, B, C` are fixed. The test set writes the seven angles as unknowns, six equations for the
loops that close in `E`, and the mass matrix of the seven angles. Here each body has twelve
coordinates, joints are ten revolute joints in space, seven of whose angles are exactly those of
the test set, and the torque acts on the first of them. Nine of the fifty joint constraints say
nothing new, as the mechanism is plane; the time step leaves them out.

The mechanism has one degree of freedom, so quadrature gives its motion to all digits. The time to
the crank angle `beta` is `int sqrt(M / (2 W)) d beta`, with the kinetic energy `M beta'^2 / 2` and
the work `W` since the start. Those digits differ from the ones of the test set in the tenth place
of `beta` and `Theta`, and agree with ours.

Motion in a plane knows only the inertia `J3 = E1 + E2` of a body, and a plate with E1 = E2 and
E3 = 0 stands for it.
"""

from mpi4py import MPI

import numpy as np
from published import references, refine

from turbine_fenicsx import (
    JointTorque,
    MultibodySystem,
    PointSpring,
    Revolute,
    RigidBody,
    Simulation,
)
from turbine_fenicsx.foundation.rotations import E3

# Data of the test set: masses [kg], inertia about centres of mass [kg m^2], lengths [m]
MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
ORIGIN, A, B, C = (0.0, 0.0), (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
D_, DA, E_, EA = 0.028, 0.0115, 0.02, 0.01421
RR, RA = 0.007, 0.00092
SS, SA, SB, SC, SD = 0.035, 0.01874, 0.01043, 0.018, 0.02
TA, TB = 0.02308, 0.00916
U_, UA, UB = 0.04, 0.01228, 0.00449
ZF, ZT, FA = 0.02, 0.04, 0.01421
STIFFNESS, REST = 4530.0, 0.07785  # of the spring [N/m, m]
TORQUE = 0.033  # on the crank [N m]
END = 0.03  # [s]

START = {
    "beta": -0.0617138900142764496358948458001,
    "Theta": 0.0,
    "gamma": 0.455279819163070380255912382449,
    "Phi": 0.222668390165885884674473185609,
    "delta": 0.487364979543842550225598953530,
    "Omega": -0.222668390165885884674473185609,
    "epsilon": 1.23054744454982119249735015568,
}
"""Angles at rest [rad], in which all loops close."""


def along(angle, x, y=0.0):
    """Vector with components x along the direction of ``angle`` and y across it, in the plane."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * x - s * y, s * x + c * y, 0.0])


def mechanism():
    """All parts."""
    beta, Theta, gamma, Phi, delta, Omega, epsilon = START.values()
    point_O, point_A, point_B, point_C = (np.array([*point, 0.0]) for point in (ORIGIN, A, B, C))
    F = point_O + along(beta, RR)
    E = F - along(beta + Theta, D_)
    D = point_B + along(gamma, SD, -SC)
    G = point_A + along(delta, ZT)
    H = point_A + along(epsilon, 0.0, -U_)
    centres = (
        point_O + along(beta, RA),
        F - along(beta + Theta, DA),
        point_B + along(gamma, SB, -SA),
        G + along(Phi + delta, 0.0, -(E_ - EA)),
        point_A + along(delta, TB, TA),
        H + along(Omega + epsilon, ZF - FA),
        point_A + along(epsilon, UB, -UA),
    )
    K1, K2, K3, K4, K5, K6, K7 = bodies = [
        RigidBody.from_inertia(f"K{k}", m, (0.5 * J, 0.5 * J, J), position=x)
        for k, (m, J, x) in enumerate(zip(MASSES, INERTIAS, centres, strict=True), start=1)
    ]

    def pin(name, first, second, point):
        return Revolute(name, first, second, point=point, axis=E3, with_coordinates=name in START)

    joints = [
        pin("beta", None, K1, point_O),
        pin("Theta", K1, K2, F),
        pin("gamma", None, K3, point_B),
        pin("delta", None, K5, point_A),
        pin("Phi", K5, K4, G),
        pin("epsilon", None, K7, point_A),
        pin("Omega", K7, K6, H),
        pin("E3", K2, K3, E),
        pin("E4", K2, K4, E),
        pin("E6", K2, K6, E),
    ]
    spring = PointSpring(
        "spring", None, K3, first_point=point_C, second_point=D, stiffness=STIFFNESS, length=REST
    )
    return [*bodies, *joints, spring, JointTorque("torque on beta", "beta", TORQUE)]


def solve(steps, comm=MPI.COMM_WORLD):
    """All angles at the end, for a number of steps."""
    system = MultibodySystem(comm, mechanism())
    last = Simulation(system, END / steps, END).run()
    turned = dict(zip(system.joint_coordinate_names, last.state.joint_coordinates, strict=True))
    found = {name: angle + turned[name] for name, angle in START.items()}
    return found | {f"{name}_by_quadrature": angle for name, angle in found.items()}


def main(steps=(500, 1000, 2000, 4000)):
    """Rows of the table."""
    return refine(solve, steps, END, references("squeezer"))

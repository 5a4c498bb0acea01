"""Two four-bar linkages in a row, through singular positions.

`N + 1` upright rods stand on the ground at `A_0 ... A_N`, one metre apart, and `N` level rods join
their upper ends `B_0 ... B_N`: `N` four-bar windows, here two. All rods are one metre long,
uniform, and weigh one kilogram. They start upright with 1 m/s of the points `B` along `x` and fall
to the right; with that energy they go over the top again and again, five rounds in ten seconds.

One angle `theta` of the upright rods describes the whole motion,

    ((N+1)/3 + N) theta'' = -((N+1)/2 + N) (g / l) cos(theta),

but twice in each round all rods lie on one line, and there it could continue in other ways,
with `N + 1` degrees of freedom: the constraints lose rank. Moreover, each joint is a full revolute
joint in space. Then every window locks three motions twice, so that six of the 35 joint constraints
say nothing new. The library finds these by itself and leaves them out of the time step, with a
warning. The singular positions lie between two steps and do not lead any of them astray.

Motion in a plane knows only the inertia `J3 = E1 + E2` of a rod, and a plate with E1 = E2 and
E3 = 0 stands for it.
"""

from mpi4py import MPI

from published import references, refine

from turbine_fenicsx import Gravity, MultibodySystem, Revolute, RigidBody, Simulation
from turbine_fenicsx.foundation.rotations import E1, E2, E3

WINDOWS = 2  # N
LENGTH, MASS = 1.0, 1.0  # of a rod [m, kg]
SPEED = 1.0  # of the points B at the start [m/s]
G = 9.81  # [m/s^2]
END = 10.0  # [s]

INERTIA = MASS * LENGTH**2 / 12.0  # J3 about the centre of a rod [kg m^2]
EULER = (0.5 * INERTIA, 0.5 * INERTIA, 0.0)


def linkage():
    """Rods and joints; the first rod is the one from A_0 to B_0."""
    A = [k * LENGTH * E1 for k in range(WINDOWS + 1)]
    B = [point + LENGTH * E2 for point in A]
    upright = [
        RigidBody(
            f"A{k}_B{k}",
            MASS,
            EULER,
            position=0.5 * (A[k] + B[k]),
            velocity=0.5 * SPEED * E1,
            angular_velocity=-SPEED / LENGTH * E3,
        )
        for k in range(WINDOWS + 1)
    ]
    level = [
        RigidBody(
            f"B{k}_B{k + 1}", MASS, EULER, position=0.5 * (B[k] + B[k + 1]), velocity=SPEED * E1
        )
        for k in range(WINDOWS)
    ]

    def pin(name, first, second, point):
        return Revolute(name, first, second, point=point, axis=E3, with_coordinates=False)

    joints = [pin(f"A{k}", None, upright[k], A[k]) for k in range(WINDOWS + 1)]
    for k in range(WINDOWS):
        joints.append(pin(f"B{k}_left", upright[k], level[k], B[k]))
        joints.append(pin(f"B{k + 1}_right", level[k], upright[k + 1], B[k + 1]))
    return [*upright, *level, *joints]


def solve(steps, comm=MPI.COMM_WORLD):
    """Place of B_0 at the end, for a number of steps."""
    system = MultibodySystem(comm, [*linkage(), Gravity((0.0, -G, 0.0))])
    last = Simulation(system, END / steps, END).run()
    phi, _, d2, _ = last.state.q[:12].reshape(4, 3)
    x, y, _ = phi + 0.5 * LENGTH * d2
    return {"x": x, "y": y}


def main(steps=(500, 1000, 2000)):
    """Rows of the table."""
    return refine(solve, steps, END, references("four_bar"))

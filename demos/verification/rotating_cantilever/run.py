"""A rotating beam flaps the faster the faster it turns.

A beam is clamped to a hub that turns with the speed `Omega` about an axis through the clamp. The
centrifugal force stretches it and stiffens it against flapping, out of the plane of its rotation.
With speeds and frequencies in units of `sqrt(EI/(rho A L^4))`, the first frequency is

    w^2 int phi^2 dx = int phi''^2 dx + Omega^2 int (1 - x^2)/2 phi'^2 dx.

Nothing of this is put in: the beam is a solid of quadratic hexahedra, 10 m x 0.2 m x 0.2 m, on a
rigid hub whose joint is driven. It starts in its stretched state and flaps gently in its first
mode. The frequency is that of the sine that fits two periods of the tip's motion.

A time step makes periods too long by `(w dt)^2/12`. It does the same with the turn of the hub,
which makes the centrifugal force too large by the same share; at high speeds both nearly cancel.
Two runs of 40 and 80 steps per period are extrapolated to a step of zero. The solid also shears,
and its sections turn, which beam theory leaves out: that lowers the frequencies by up to 2.2e-4 of
them, and four times less in a beam half as thick.
"""

from mpi4py import MPI

import numpy as np
from dolfinx import mesh
from published import Row, extrapolate, load, references
from scipy.optimize import minimize_scalar

from turbine_fenicsx import (
    Coupling,
    EnergyMomentum,
    FlexibleBody,
    MultibodySystem,
    PrescribedMotion,
    Revolute,
    RigidBody,
    StVenantKirchhoff,
)
from turbine_fenicsx.foundation.rotations import E3

LENGTH, THICKNESS, DENSITY = 10.0, 0.2, 1000.0  # [m], [m], [kg/m^3]
YOUNG = 12.0 * DENSITY * LENGTH**4 / THICKNESS**2  # so that the unit of time is 1 s [Pa]
TIP = 1e-3 * LENGTH  # amplitude [m]
PERIODS = 2
STEPS = (80, 160)  # for these periods
ELEMENTS = 40  # along the beam; one across
SPEEDS = (0, 2, 4, 8, 12)  # Omega [rad/s]


def solve(speed, steps, elements=ELEMENTS, comm=MPI.COMM_WORLD):
    """First flap frequency at a speed, both [rad/s]."""
    half = 0.5 * THICKNESS
    corners = [(0.0, -half, -half), (LENGTH, half, half)]
    box = mesh.create_box(comm, corners, (elements, 1, 1), mesh.CellType.hexahedron)
    root = mesh.locate_entities_boundary(box, 2, lambda x: np.isclose(x[0], 0.0))
    frequency, mode = load("rotating_cantilever", "exact").flap(speed)

    def stretched(X):
        """Positions in the turning beam at rest, from E u'' = -rho Omega^2 X."""
        pull = DENSITY * speed**2 / (2.0 * YOUNG)
        return X + np.outer(pull * X[:, 0] * (LENGTH**2 - X[:, 0] ** 2 / 3.0), [1.0, 0.0, 0.0])

    def velocity(X):
        flapping = TIP * frequency * mode(X[:, 0] / LENGTH)
        return np.cross(speed * E3, stretched(X)) + np.outer(flapping, E3)

    law = StVenantKirchhoff(0.0, 0.5 * YOUNG)
    beam = FlexibleBody("beam", box, law, DENSITY, degree=2, velocity=velocity)
    hub = RigidBody("hub", 1.0, (1.0, 1.0, 1.0), angular_velocity=speed * E3)
    parts = [
        beam,
        hub,
        Coupling("clamp", beam, root, hub),
        Revolute("shaft", None, hub, point=(0.0, 0.0, 0.0), axis=E3),
        PrescribedMotion("shaft", lambda t: speed * t),
    ]
    system = MultibodySystem(comm, parts)
    solver = EnergyMomentum(system)
    X = system.flexible_models[0].positions
    middle = np.linalg.norm(X - [LENGTH, 0.0, 0.0], axis=1) < 1e-9
    state = system.initial_state()
    state.u[0].array[:] = (stretched(X) - X).ravel()
    after, dt = state.copy(), PERIODS * 2.0 * np.pi / frequency / steps
    w = [0.0]
    for _ in range(steps):
        solver.advance(state, dt, after)
        state, after = after, state
        tip = comm.allreduce(state.u[0].array_r.reshape(-1, 3)[middle].sum(axis=0))
        w.append(tip[2])
    solver.destroy()
    return fitted_frequency(dt * np.arange(steps + 1), np.array(w), frequency)


def fitted_frequency(t, w, guess):
    """Frequency of the sine that fits w(t) best, within a fifth of a guess [rad/s]."""

    def misfit(frequency):
        waves = np.column_stack([np.sin(frequency * t), np.cos(frequency * t)])
        size, *_ = np.linalg.lstsq(waves, w, rcond=None)
        return np.linalg.norm(w - waves @ size)

    bounds = (0.8 * guess, 1.2 * guess)
    options = {"xatol": 1e-9 * guess}
    return float(minimize_scalar(misfit, bounds=bounds, method="bounded", options=options).x)


def main(steps=STEPS):
    """Rows of the table."""
    expected = references("rotating_cantilever")
    rows = []
    for speed in SPEEDS:
        values = [solve(speed, n) for n in steps]
        r = expected[f"speed_{speed}"]
        limit = extrapolate(1.0 / np.array(steps), values)
        rows.append(Row(r.quantity, r.unit, r.value, limit, r.tolerance, "extrapolated"))
    return rows

"""Three reduced blades of the IEA 15 MW turbine in a gust: Newton iterations and time of a step.

``python benchmarks/reduced.py`` reduces the hollow blade of the windIO file (14 by 16 cells, walls
with the bending stiffness of their layup) and lets three copies turn at rated speed for ten
seconds. They are loaded by their weight, a gust of four seconds and noise up to 2.2 Hz, as forces
on nodes along the blades. Iterations do not depend on the machine; times are of one core.
"""

import importlib.util
import sys
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np

from turbine_fenicsx import (
    Coupling,
    EnergyMomentum,
    Gravity,
    MultibodySystem,
    NodeForce,
    Placement,
    PrescribedMotion,
    RayleighDamping,
    ReducedBody,
    Revolute,
    RigidBody,
    SolverOptions,
    reduce_body,
)
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.windio import find_turbine_file, read_turbine

CELLS = (14, 16)
SPEED = 0.79  # rated [rad/s]
CREEP = 0.003  # viscosity over stiffness [s]
END = 10.0
STATIONS = (0.3, 0.5, 0.7, 0.85, 0.97)
STEADY, GUST, NOISE = 4.0e3, 6.0e3, 1.0e3  # forces per length [N/m]


def make_blade():
    """The clamped blade on its mesh."""
    path = Path(__file__).parents[1] / "demos" / "verification" / "iea22_blade" / "solid.py"
    spec = importlib.util.spec_from_file_location("solid", path)
    solid = importlib.util.module_from_spec(spec)
    sys.modules["solid"] = solid
    spec.loader.exec_module(solid)
    blade = read_turbine(find_turbine_file("IEA-15-240-RWT.yaml")).blade
    return solid.make_solid(MPI.COMM_SELF, blade, CELLS, moments=True)


def wind(k, seed):
    """Force per length over time at a station: steady, gust from 2 s to 6 s, noise."""
    rng = np.random.default_rng(seed)
    f, phase = rng.uniform(0.1, 2.2, 12), rng.uniform(0.0, 2.0 * np.pi, 12)

    def force(t):
        gust = np.sin(np.pi * (t - 2.0) / 4.0) ** 2 if 2.0 < t < 6.0 else 0.0
        noise = np.sum(np.sin(2.0 * np.pi * f * t + phase)) / np.sqrt(12.0)
        return STEADY * min(t, 1.0) + GUST * gust + NOISE * noise

    return force


def make_rotor(solid, basis, damping):
    """Three copies on a hub that turns at rated speed about e3."""
    X = basis.points
    length = X[:, 0].max() - X[:, 0].min()
    turns = [rotation_about((0.0, 0.0, 1.0), 2.0 * np.pi * k / 3.0) for k in range(3)]
    blades = ReducedBody("blades", solid.body, basis, [Placement(rotation=R) for R in turns])
    hub = RigidBody("hub", 1e5, (1e6, 1e6, 1e6), angular_velocity=(0.0, 0.0, SPEED))
    parts = [hub, blades, Gravity((0.0, -9.81, 0.0))]
    parts += [Revolute("main", None, hub, (0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))]
    parts += [PrescribedMotion("main", lambda t: SPEED * t)]
    parts += [Coupling(f"root {k}", blades, solid.root, hub, copy=k) for k in range(3)]
    if damping:
        parts.append(RayleighDamping("damping", blades, stiffness=damping))
    for copy, R in enumerate(turns):
        for k, s in enumerate(STATIONS):
            node = X[np.argmin(np.abs(X[:, 0] - X[:, 0].min() - s * length))]
            load = (0.0, 0.0, 0.2 * length)
            at = R @ node
            name = f"wind {copy} {k}"
            parts.append(
                NodeForce(name, blades, point=at, force=load, function=wind(k, 10 * copy + k))
            )
    return MultibodySystem(MPI.COMM_SELF, parts)


def run(solid, basis, dt, damping):
    """Print the numbers of iterations, of steps that failed at first, and the time of a step."""
    system = make_rotor(solid, basis, damping)
    stepper = EnergyMomentum(system, options=SolverOptions(tolerance=1e-8))
    state, out = system.initial_state(), system.initial_state()
    counts = []
    begin = time.process_time()
    with one_thread():
        for _ in range(round(END / dt)):
            counts.append(stepper.advance(state, dt, out).newton_iterations)
            state, out = out, state
    took = 1e3 * (time.process_time() - begin) / len(counts)
    print(
        f"dt = {dt:g} s, damping {damping:g} s: {np.mean(counts):.2f} iterations, "
        f"{np.max(counts)} at most, {stepper.fallbacks} fallbacks, {took:.1f} ms a step"
    )


def main():
    """All of it."""
    solid = make_blade()
    begin = time.perf_counter()
    basis = reduce_body(solid.system(), solid.body, 6, 44)
    took, r = time.perf_counter() - begin, basis.strain_factor.shape[1]
    print(f"{basis}, {r} strain coordinates, made in {took:.1f} s")
    for dt in (0.05, 0.02):
        for damping in (CREEP, 0.0):
            run(solid, basis, dt, damping)


if __name__ == "__main__":
    main()

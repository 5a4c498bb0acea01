"""Reduced hollow blades of reference turbines: how good they are, and how fast.

``python benchmarks/reduced.py steps`` reduces the blade of the IEA 15 MW turbine (14 by 16 cells,
walls with the bending stiffness of their layup) and lets three copies turn at rated speed for ten
seconds. They are loaded by their weight, a gust of four seconds and noise up to 2.2 Hz, as forces
on nodes along the blades. Iterations do not depend on the machine; times are of one core.

``python benchmarks/reduced.py IEA-22`` trains the blade of that turbine (20 by 24 cells) by
operating points and judges it by others, by dead loads, by damping, and by a transient, all beside
the full blade; ``IEA-15`` is the other one.
"""

import importlib.util
import logging
import sys
import time
from dataclasses import replace
from pathlib import Path

from mpi4py import MPI

import numpy as np
from reduced_transient import compare

from turbine_fenicsx import (
    BodyForce,
    Coupling,
    EnergyMomentum,
    Gravity,
    KelvinVoigt,
    LoadPath,
    MultibodySystem,
    NodeForce,
    Placement,
    PrescribedMotion,
    Ramp,
    RayleighDamping,
    ReducedBody,
    Revolute,
    RigidBody,
    SolverOptions,
    StepFailure,
    damped_modes,
    judge,
    reduce_body,
)
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.reduction.smooth_loads import LineLoads
from turbine_fenicsx.reduction.static_body import StaticBody
from turbine_fenicsx.turbine.blades.operating_points import (
    TRAINING,
    UNSEEN,
    OperatingLoads,
    OperatingPoint,
    RatedOperation,
)
from turbine_fenicsx.wind.windio_blade import make_aero_blade
from turbine_fenicsx.windio import find_turbine_file, read_turbine

CELLS, FINE = (14, 16), (20, 24)
SPEED = 0.79  # rated [rad/s]
CREEP = 0.003  # viscosity over stiffness [s]
END = 10.0
STATIONS = (0.3, 0.5, 0.7, 0.85, 0.97)
STEADY, GUST, NOISE = 4.0e3, 6.0e3, 1.0e3  # forces per length [N/m]


SIZE = (66, 25)  # functions, strains
FILES = {"IEA-15": "IEA-15-240-RWT.yaml", "IEA-22": "IEA-22-280-RWT.yaml"}


LAST = (
    OperatingPoint(7.0, 1.2, azimuths=(30.0,)),
    OperatingPoint(9.5, azimuths=(120.0,)),
    OperatingPoint(12.0, 1.3, azimuths=(210.0,)),
    OperatingPoint(17.0, 0.7, azimuths=(300.0,)),
    OperatingPoint(22.0, 1.2, azimuths=(75.0,)),
)
"""Looked at only after all choices had been made."""


def make_loads(solid, turbine):
    """Loads of the blade at operating points of its turbine."""
    c, hub, axis = turbine.control, turbine.hub.radius, turbine.blade.outer_shape.axis[2]
    tip = hub + float(axis.smooth(np.array([1.0]))[0])
    aero = make_aero_blade(turbine, np.linspace(hub + 0.005 * tip, 0.995 * tip, 60))
    rated = RatedOperation(
        c.least_speed, c.rated_speed, c.rated_power, c.tip_speed_ratio, c.fine_pitch or 0.0
    )
    return OperatingLoads(solid.system(), solid.body, solid.skin, aero, rated)


def make_blade(turbine, cells):
    """The clamped blade on its mesh."""
    path = Path(__file__).parents[1] / "demos" / "verification" / "iea22_blade" / "solid.py"
    spec = importlib.util.spec_from_file_location("solid", path)
    solid = importlib.util.module_from_spec(spec)
    sys.modules["solid"] = solid
    spec.loader.exec_module(solid)
    return solid.make_solid(MPI.COMM_SELF, turbine.blade, cells, moments=True)


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
    counts, failed = [], ""
    begin = time.process_time()
    with one_thread():
        for _ in range(round(END / dt)):
            try:
                counts.append(stepper.advance(state, dt, out).newton_iterations)
            except StepFailure:
                failed = f"; the step from t = {state.time:.3g} s failed"
                break
            state, out = out, state
    took = 1e3 * (time.process_time() - begin) / len(counts)
    print(
        f"dt = {dt:g} s, damping {damping:g} s: {np.mean(counts):.2f} iterations, "
        f"{np.max(counts)} at most, {stepper.fallbacks} fallbacks, {took:.1f} ms a step{failed}"
    )


def learn(solid, operating, size, modes=6):
    """Print how long it takes to make a basis from operating points, and return it."""
    begin = time.process_time()
    loads = operating.list_paths(TRAINING)
    basis = reduce_body(solid.system(), solid.body, modes, *size, loads)
    took, r = time.process_time() - begin, basis.strain_factor.shape[1]
    print(f"{basis}, {r} strain coordinates, made in {took:.0f} s of one core", flush=True)
    return basis


def measure_steps():
    """Iterations and times of steps."""
    turbine = read_turbine(find_turbine_file(FILES["IEA-15"]))
    solid = make_blade(turbine, CELLS)
    basis = learn(solid, make_loads(solid, turbine), SIZE, None)
    for dt in (0.05, 0.02):
        for damping in (CREEP, 0.0):
            run(solid, basis, dt, damping)


def make_lines(solid):
    """Line loads of the blade."""
    still = StaticBody(solid.system(), solid.body, solid.body)
    lines = LineLoads(still)
    still.destroy()
    return lines


def flapwise(solid, lines):
    """9 kN/m across the chord, in two steps."""
    field = lines.field(np.ones_like, np.array([0.0, 0.0, 9.0e3]), 0.0)
    force = BodyForce("flap", solid.body, field=field, function=Ramp(1.0, 1.0))
    return LoadPath("9 kN/m flapwise", [force], (0.25, 0.5, 0.75, 1.0))


def compare_damping(solid, functions):
    """Print the largest error of the damping ratios of the first six modes with viscosity."""
    shear = 1.0e5  # foam cores would creep with more
    law = KelvinVoigt(solid.body.material, shear_viscosity=shear, bulk_viscosity=2.0 * shear)
    viscous = replace(solid, body=replace(solid.body, material=law))
    reduced = reduce_body(viscous.system(), viscous.body, 6, functions, loads=())
    held = Coupling("clamp", ReducedBody("reduced", viscous.body, reduced), solid.root, None)
    systems = viscous.system(), MultibodySystem(solid.comm, [held.flexible, held])
    full, found = (damped_modes(system, count=6).modes for system in systems)
    errors = [
        abs(b.damping_ratio / a.damping_ratio - 1.0) for a, b in zip(full, found, strict=True)
    ]
    ratios = ", ".join(f"{100.0 * mode.damping_ratio:.3f}" for mode in full)
    print(f"damping ratios {ratios} %, error {100.0 * max(errors):.4f} % of them", flush=True)


def measure_accuracy(name):
    """Compare a blade with the full one."""
    turbine = read_turbine(find_turbine_file(FILES[name]))
    solid = make_blade(turbine, FINE)
    operating = make_loads(solid, turbine)
    basis = learn(solid, operating, SIZE)
    dead = [flapwise(solid, make_lines(solid))]
    for loads in (operating.list_paths(UNSEEN), operating.list_paths(LAST), dead):
        print(judge(solid.system(), solid.body, basis, loads), flush=True)
    twelve = reduce_body(solid.system(), solid.body, 12, 48, loads=())
    print(judge(solid.system(), solid.body, twelve, [], 12), flush=True)
    compare_damping(solid, SIZE[0])
    compare(solid, operating, basis, make_lines(solid))


def main():
    """One of them."""
    what, *_ = sys.argv[1:] or ["steps"]
    logging.basicConfig(level=logging.INFO, format="%(message)s", force=True)
    if what == "steps":
        measure_steps()
        return
    measure_accuracy(what)


if __name__ == "__main__":
    main()

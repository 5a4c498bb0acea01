"""A blade in a gust, full and reduced: the largest differences of tip, root moments and twist.

The clamped blade is loaded by the air of a wind speed with a gust of three quarters of a second and
noise up to 1.8 Hz, by pitching moments with a wave of their own, by the centrifugal force and by
the weight, which turns with the rotor. Two motions start in equilibrium. The third starts at rest,
and the loads of 9 m/s grow within a second: the tip goes twice as far as in equilibrium.
"""

import time
from dataclasses import dataclass, replace

import numpy as np

from turbine_fenicsx import (
    BodyForce,
    Coupling,
    EnergyMomentum,
    MultibodySystem,
    Ramp,
    RayleighDamping,
    ReducedBody,
    SectionLoads,
    SolverOptions,
    equilibrium,
)
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.reduction.judge import SpanMeter
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.turbine.blades.operating_points import OperatingPoint

DT, END = 0.02, 4.0
CREEP = 0.003  # viscosity over stiffness [s]


@dataclass(frozen=True)
class Motion:
    """How the loads change.

    Args:
        name: A name.
        wind: Wind speed [m/s].
        peak: Of the gust over the loads of the air.
        start: When the loads start to grow for a second [s].
    """

    name: str
    wind: float
    peak: float
    start: float

    @property
    def is_running(self):
        """Whether it starts in equilibrium."""
        return self.start < 0.0

    def grow(self, t):
        """From zero to one."""
        return Ramp(1.0, 1.0, self.start, smooth=True)(t)

    def gust(self, t):
        """Factor of the loads of the air."""
        rng = np.random.default_rng(7)
        f, phase = rng.uniform(0.2, 1.8, 9), rng.uniform(0.0, 2.0 * np.pi, 9)
        noise = 0.05 * np.sum(np.sin(2.0 * np.pi * f * max(t, 0.0) + phase))
        peak = np.sin(np.pi * (t - 1.6) / 0.75) ** 2 if 1.6 < t < 2.35 else 0.0
        return self.grow(t) * (1.0 + self.peak * peak + noise)


MOTIONS = (
    Motion("15 m/s, from equilibrium", 15.0, 0.35, -1.0),
    Motion("10 m/s, from equilibrium", 10.0, 0.35, -1.0),
    Motion("9 m/s, from rest", 9.0, 0.6, 0.0),
)


def load(operating, lines, body, motion):
    """Forces on the full body or the reduced one."""
    point, grow = OperatingPoint(motion.wind), motion.grow
    speed = operating.find_operation(point).rotor_speed
    air, turn, *weights = operating.make_path(point).forces
    flutter = lines.field(lambda s: 900.0 * s**2, np.zeros(3), 1.0)
    waves = (lambda t: grow(t) * np.cos(speed * t), lambda t: grow(t) * np.sin(speed * t))
    return [
        SectionLoads("air", body, air.lines, replace(air.source, function=motion.gust)),
        BodyForce("pitching", body, field=flutter, function=lambda t: np.sin(2.6 * t) * grow(t)),
        BodyForce("centrifugal", body, field=turn.field, function=grow),
        *(
            BodyForce(weight.name, body, field=weight.field, function=wave)
            for weight, wave in zip(weights, waves, strict=True)
        ),
    ]


def run(solid, operating, lines, basis, motion, is_reduced):
    """Tip (steps, 3), root moment (steps, 3), twists (steps, 2), and CPU seconds."""
    body = ReducedBody("blade", solid.body, basis) if is_reduced else solid.body
    clamp = Coupling("clamp", body, solid.root, None)
    damping = RayleighDamping("damping", body, stiffness=CREEP)
    forces = load(operating, lines, body, motion)
    system = MultibodySystem(solid.comm, [body, clamp, damping, *forces])
    stepper = EnergyMomentum(system, options=SolverOptions(tolerance=1e-8))
    axis = LongAxis(basis.points, basis.masses, basis.origins[0])
    meter = SpanMeter(basis.points, basis.masses, axis, (0.7, 0.9, 1.0))
    model, block = system.flexible_models[0], system.coupling_blocks[0]
    h = model.is_point[block.nodes][:, None]
    arms = model.positions[block.nodes] - h * basis.origins[0]
    state, out, rows = system.initial_state(), system.initial_state(), []
    if motion.is_running:
        state = equilibrium(system, np.linspace(-0.8, 0.0, 5))
    begin = time.process_time()
    with one_thread():
        for _ in range(round(END / DT)):
            stepper.advance(state, DT, out)
            state, out = out, state
            u = model.expand(state.u[0])[0] if is_reduced else state.u[0].array.reshape(-1, 3)
            f = state.coupling[0].array_r.reshape(-1, 3)
            moment = -np.cross(arms, f).sum(axis=0)
            rows.append((meter.displacements(u)[2], moment, np.degrees(meter.twists(u)[:2])))
    took = time.process_time() - begin
    return *(np.array(x) for x in zip(*rows, strict=True)), took


def compare(solid, operating, basis, lines):
    """Print the largest differences."""
    for motion in MOTIONS:
        *full, slow = run(solid, operating, lines, basis, motion, False)
        *reduced, fast = run(solid, operating, lines, basis, motion, True)
        tip, moment, twist = (np.abs(a - b) for a, b in zip(full, reduced, strict=True))
        size = [np.abs(x).max(axis=0) for x in full]
        print(f"{motion.name}, {END:g} s: full {slow:.0f} s, reduced {fast:.1f} s of one core")
        far = np.linalg.norm(full[0], axis=1).max()
        print(f"  tip {far:.2f} m, error {100 * np.linalg.norm(tip, axis=1).max() / far:.2f} %")
        for name, k in (("flap", 1), ("edge", 2)):
            error = 100.0 * moment[:, k].max() / size[1][k]
            print(f"  root moment {name} {1e-6 * size[1][k]:.1f} MN m, error {error:.2f} %")
        for place, k in ((0.7, 0), (0.9, 1)):
            error = twist[:, k].max()
            print(f"  twist at {place} {size[2][k]:.2f} deg, error {error:.3f} deg", flush=True)

"""Steps far from any solution, where nothing vanishes by accident."""

import numpy as np

from turbine_fenicsx import Gravity, Hat, JointTorque
from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentumStep

DT, T0 = 0.05, 0.4


def loaded(machine, **options):
    m = machine(spin=2.0, **options)
    loads = [
        Gravity(),
        JointTorque("torque on rotor", "rotor", 1.0, Hat(5.0)),
        JointTorque("torque on yaw", "yaw", 1.0, Hat(-2.0)),
    ]
    return m.system(*loads)


def fill(vector, seed, size):
    """Numbers that look random, entry by entry from the global index."""
    start, end = vector.getOwnershipRange()
    vector.array[:] = size * np.sin(seed + 1.7 * np.arange(start, end) ** 2)


def wild_state(system, seed=0):
    """A state that fulfils no constraint."""
    rng, state = np.random.default_rng(seed), system.initial_state()
    state.time = T0
    state.q += 0.1 * rng.normal(size=state.q.size)
    state.q_dot += rng.normal(size=state.q.size)
    state.joint_coordinates += rng.uniform(-2, 2, state.joint_coordinates.size)
    state.joint_rates += rng.normal(size=state.joint_coordinates.size)
    state.multipliers += rng.normal(size=state.multipliers.size)
    for k, vectors in enumerate((state.u, state.v, state.coupling)):
        for vector in vectors:
            fill(vector, seed + k, (0.02, 1.0, 3.0)[k])
    return state


def wild_unknowns(step, seed=10, sizes=(0.02, 0.1, 0.1)):
    x = step.new_nested_vector()
    for k, (part, size) in enumerate(zip(step.split(x), sizes, strict=True)):
        for vector in part if isinstance(part, list) else [part]:
            fill(vector, seed + k, size)
    return x


def begun(system, seed=0, form="regular"):
    """A step begun from a wild state, with wild unknowns."""
    step, state = EnergyMomentumStep(system, angle_form=form), wild_state(system, seed)
    step.start_step(state, DT)
    x = wild_unknowns(step)
    x.copy(step.x)
    return step, state

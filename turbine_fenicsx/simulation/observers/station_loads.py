"""Loads on sections of bodies, as they were in the step that led to a state."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.forces.line_source import SAME_TIME, StepLoads
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


def find_loads(system: MultibodySystem, name: str, state: State) -> StepLoads:
    """Loads on sections in the step that led to a state, or in the first state. Collective."""
    last = system.section_loads[name].last
    if last is not None and abs(last.times.end - state.time) <= SAME_TIME * last.times.dt:
        return last
    for model, u, v in zip(system.flexible_models, state.u, state.v, strict=True):
        for loads in model.section_loads:
            if loads.name == name:
                return loads.loads_at(u.array_r, v.array_r, state.time)
    rigid = next(x for x in system.rigid_section_loads if x.name == name)
    y = np.concatenate([state.q, state.joint_coordinates])[rigid.index]
    y_dot = np.concatenate([state.q_dot, state.joint_rates])[rigid.index]
    return rigid.loads_at(y, y_dot, state.time)

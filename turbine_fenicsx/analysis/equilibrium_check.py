"""Whether a state is in equilibrium."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.analysis.statics import UNHELD, EquilibriumBlocks, reach
from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.system.start import check_start
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

LARGEST_LACK = 1e-6
"""Part of the forces on a system that may be unbalanced in an equilibrium."""

ROUND_OFF = 1e-14
"""Round-off of unbalanced forces, relative to stiffness times extent."""


@dataclass(frozen=True)
class Imbalance:
    """How far a state is from equilibrium.

    Args:
        lacking: Norm of the forces that are not balanced [N].
        size: Norm of all forces [N].
        noise: What may be round-off [N].
    """

    lacking: float
    size: float
    noise: float

    @property
    def is_equilibrium(self) -> bool:
        """Whether the state counts as an equilibrium."""
        return self.lacking <= LARGEST_LACK * self.size + self.noise


def imbalance(system: MultibodySystem, state: State) -> Imbalance:
    """How far the forces on a system and in it are from balance, at the time of the state.

    Velocities are not looked at. Collective.
    """
    blocks = EquilibriumBlocks(system, state)
    blocks.time = state.time
    blocks.residual()
    R_u, _, R_r = blocks.split(blocks.residual_vector)
    model = system.rigid_model
    rigid = blocks.on_all_ranks(R_r)[: model.n_q + model.n_T]
    lacking = float(np.linalg.norm([*(R.norm() for R in R_u), np.linalg.norm(rigid)]))
    # what nothing holds has a little stiffness in an equilibrium, see `UNHELD`
    least = UNHELD * float(np.max(model.masses, initial=0.0))
    noise = (ROUND_OFF * _stiffness(blocks) + least) * reach(system)
    blocks.destroy()
    return Imbalance(lacking, _size_of_forces(system, state), noise)


def check_equilibrium(system: MultibodySystem, state: State) -> None:
    """Check that a state is in equilibrium. Collective."""
    check_start(system, state)
    found = imbalance(system, state)
    if not found.is_equilibrium:
        raise ModelError(
            f"the state is not in equilibrium: forces of {found.lacking:.1e} N are not balanced, "
            f"where {LARGEST_LACK:g} of all forces, {LARGEST_LACK * found.size:.1e} N, is allowed; "
            "turbine_fenicsx.equilibrium finds one"
        )


def _stiffness(blocks: EquilibriumBlocks) -> float:
    """Norm of the diagonal of the flexible bodies' stiffness [N/m]."""
    norms = []
    for K in blocks.tangents:
        diagonal = K.getDiagonal()
        norms.append(diagonal.norm())
        diagonal.destroy()
    return float(np.linalg.norm(norms))


def _size_of_forces(system: MultibodySystem, state: State) -> float:
    """Norm of all forces that an equilibrium balances: loads, and forces of constraints [N]."""
    norms = [mu.norm() for mu in state.coupling]
    for m in system.flexible_models:
        undeformed, forces = m.new_vector(), m.new_vector()
        m.static_forces(undeformed, system.gravity, state.time, forces)
        norms.append(forces.norm())
        undeformed.destroy()
        forces.destroy()
    model = system.rigid_model
    y = np.concatenate([state.q, state.joint_coordinates])
    loads = (forces.sum(axis=0) for forces in system.evaluate_prescribed_forces(state.time))
    _, moving, _ = model.motion_forces(y, y, StepTimes.at_rest(state.time))
    G = model.constraint_jacobian(state.q, state.joint_coordinates)
    parts = [system.gravity_force(system.gravity), *loads, moving]
    parts.append(np.abs(state.multipliers) @ np.abs(G))
    return float(np.linalg.norm([*norms, *(np.linalg.norm(part) for part in parts)]))

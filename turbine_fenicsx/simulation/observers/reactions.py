"""Forces and moments that flexible bodies exert on what carries them, from the multipliers.

The multiplier of a contact node x is the force f on that node in the step from t_n to t_{n+1}. With
the positions x_m = (x_n + x_{n+1})/2 in the middle of the step, and r_m of a point that moves with
the parent body,

    F = -sum f,    M = -sum (x_m - r_m) x f

is the load on the parent body, the moment about that point. It balances the momenta of the flexible
body and the other loads on it *exactly*, because the step is a mean over its length (d'Alembert):

    (p_{n+1} - p_n)/dt = weight - F,    (L_{n+1} - L_n)/dt = moment of the weight - M - r_m x F,

where L and the moment of the weight, sum x_m x m g, are those about the origin. Since the contact
nodes move with the parent body, x_m - r_m = sum_i (xi - xi_r)_i d_i with the mean directors d_i,
and twelve sums over the nodes suffice: sum f and sum (xi - xi_r)_i f.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.rigid_body import GROUND
from turbine_fenicsx.foundation.argument_checks import check_among_parts
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.step_loads import LAST, NEXT, Coordinates, StepLoads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class Reaction:
    """Where and along which axes the load on a parent body is measured.

    Args:
        coupling: The coupling whose nodes count.
        point: Point of the moment, fixed to the parent body; its initial position [m], shape (3,).
        axes: Axes of the components, fixed to the parent body; their initial directions as rows,
            shape (3, 3). The inertial axes e1, e2, e3 if None.
    """

    coupling: Coupling
    point: npt.ArrayLike
    axes: npt.ArrayLike | None = None


class Reactions(StepLoads):
    """Loads that flexible bodies exert on their parent bodies through couplings.

    Args:
        system: The system.
        reactions: What to measure.

    Raises:
        ModelError: if a coupling is not part of the system.
    """

    def __init__(self, system: MultibodySystem, reactions: Sequence[Reaction]) -> None:
        super().__init__([r.axes for r in reactions], [r.coupling.rigid for r in reactions])
        self._where: list[tuple[int, slice, Array]] = []
        self._slots = np.full(len(reactions), len(system.rigid_bodies))  # the ground is the last
        for k, reaction in enumerate(reactions):
            coupling = reaction.coupling
            check_among_parts("coupling", coupling, system.couplings)
            index = system.flexible_bodies.index(coupling.flexible)
            block = system.coupling_blocks[index]
            rows = block.slices[block.couplings.index(coupling)]
            model, nodes = system.flexible_models[index], block.nodes[rows]
            h, R = model.is_point[nodes][:, None], np.eye(3)
            arms = model.positions[nodes] - h * np.asarray(reaction.point, dtype=float)
            if coupling.rigid is not None:
                R = np.asarray(coupling.rigid.directors, dtype=float)
                self._slots[k] = system.rigid_bodies.index(coupling.rigid)
            weights = np.hstack([h, arms @ R])
            self._where.append((index, rows, np.ascontiguousarray(weights.T)))
        self._comm = system.comm

    def at_rest(self, state: State) -> Array:
        """Loads in a static equilibrium, shape (n, 2, 3), as in `at`."""
        return self._in_axes(*self._loads_of(state, state.q))

    def _evaluate(
        self, start: Coordinates, end: Coordinates, snapshot: Snapshot
    ) -> tuple[Array, Array]:
        """Loads on the parent bodies."""
        return self._loads_of(snapshot.state, 0.5 * (start[0] + end[0]))

    def _loads_of(self, state: State, q: Array) -> tuple[Array, Array]:
        """Loads from the sums over all nodes, of f and (xi - xi_r)_i f, with the bodies at q."""
        forces = [f.array_r.reshape(-1, 3) for f in state.coupling]
        mine = [weights @ forces[index][rows] for index, rows, weights in self._where]
        sums = -sum_over_ranks(self._comm, np.array(mine).reshape(-1, 4, 3))
        d = np.concatenate([q, GROUND]).reshape(-1, 4, 3)[self._slots, 1:]
        loads = np.empty((len(sums), 2, 3))
        loads[:, 0] = sums[:, 0]
        dyads = d.transpose(0, 2, 1) @ sums[:, 1:]  # sum (x_m - r_m) f^T; its skew part is x
        loads[:, 1] = dyads[:, NEXT, LAST] - dyads[:, LAST, NEXT]
        return loads, d

"""Forces and moments that flexible bodies exert on what carries them, from the multipliers.

The multiplier of a contact node x is the force f on that node in the step from t_n to t_{n+1}. With
the positions x_m = (x_n + x_{n+1})/2 in the middle of the step, and r_m of a point that moves with
the carrier,

    F = -sum f,    M = -sum (x_m - r_m) x f

is the load on the carrier, the moment about that point. It balances the momenta of the flexible
body and the other loads on it *exactly*, because the step is a mean over its length (d'Alembert):

    (p_{n+1} - p_n)/dt = weight - F,    (L_{n+1} - L_n)/dt = moment of the weight - M - r_m x F,

where L and the moment of the weight, sum x_m x m g, are those about the origin. Since the contact
nodes move with the carrier, x_m - r_m = sum_i (xi - xi_r)_i d_i with the mean directors d_i, and
twelve sums over the nodes suffice: sum f and sum (xi - xi_r)_i f.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.rigid_body import GROUND
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.simulation.observers.shared_sum import SharedSum
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.system import MultibodySystem

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


@dataclass(frozen=True, eq=False)
class Reaction:
    """Where and along which axes the load on a carrier is measured.

    Args:
        coupling: The coupling whose nodes count.
        point: Point of the moment, fixed to the carrier; its initial position [m], shape (3,).
        axes: Axes of the components, fixed to the carrier; their initial directions as rows,
            shape (3, 3). The inertial axes e1, e2, e3 if None.
    """

    coupling: Coupling
    point: npt.ArrayLike
    axes: npt.ArrayLike | None = None


class Reactions:
    """Loads that flexible bodies exert on their carriers through couplings.

    Args:
        system: The system.
        reactions: What to measure.
        sums: Where the sums over the ranks are made; its own if None.

    Raises:
        ValueError: if a coupling is not part of the system.
    """

    def __init__(
        self,
        system: MultibodySystem,
        reactions: Sequence[Reaction],
        sums: SharedSum | None = None,
    ) -> None:
        """Find the nodes and their lever arms in the carriers' frames."""
        n = len(reactions)
        self._where: list[tuple[int, slice, Array]] = []
        self._axes = np.tile(np.eye(3), (n, 1, 1))
        self._turning = np.zeros(n, dtype=bool)
        self._slots = np.full(n, len(system.rigid_bodies))  # the ground is the last one
        for k, reaction in enumerate(reactions):
            coupling = reaction.coupling
            if coupling not in system.couplings:
                raise ValueError(f"coupling {coupling.name!r} is not among the parts")
            index = system.flexible_bodies.index(coupling.flexible)
            block = system.coupling_blocks[index]
            rows = block.slices[block.couplings.index(coupling)]
            X = system.flexible_models[index].positions[block.nodes[rows]]
            arms, axes = X - np.asarray(reaction.point, dtype=float), reaction.axes
            R = np.eye(3)
            if coupling.rigid is not None:
                R = np.asarray(coupling.rigid.directors, dtype=float)
                self._slots[k] = system.rigid_bodies.index(coupling.rigid)
            if axes is not None:
                self._turning[k] = True
                self._axes[k] = np.asarray(axes, dtype=float) @ R
            weights = np.column_stack([np.ones(len(X)), arms @ R])
            self._where.append((index, rows, np.ascontiguousarray(weights.T)))
        self._q: Array | None = None
        self._directors: Array | None = None
        self._next_index = 0
        self._snapshot: Snapshot | None = None
        self._loads = np.zeros((n, 2, 3))
        self._sum = (sums or SharedSum(system.comm)).add(self._local_sums)

    def at(self, snapshot: Snapshot) -> Array:
        """Loads on the carriers, mean values of the step that ended with a snapshot.

        To be called for every snapshot of a run, since the middle of a step lies between two.

        Args:
            snapshot: The snapshot.

        Returns:
            Force [N] and moment [N m] of each reaction, shape (n, 2, 3), equal on all ranks; zero
            in the first snapshot of a run, before which there was no step.

        Note:
            Collective.
        """
        if snapshot is not self._snapshot:
            self._loads = self._in_axes(-self._sum(snapshot))
            self._snapshot = snapshot
        return self._loads

    def _in_axes(self, sums: Array) -> Array:
        """Forces and moments, shape (n, 2, 3), from the sums over all nodes."""
        d = self._directors
        if d is None:
            return np.zeros((len(sums), 2, 3))
        loads = np.empty((len(sums), 2, 3))
        loads[:, 0] = sums[:, 0]
        dyads = d.transpose(0, 2, 1) @ sums[:, 1:]  # sum (x_m - r_m) f^T; its skew part is x
        loads[:, 1] = dyads[:, _NEXT, _LAST] - dyads[:, _LAST, _NEXT]
        axes = self._axes
        if np.any(self._turning):
            U, _, V = np.linalg.svd(d)  # U V is the rotation half way between the two ends
            axes = np.where(self._turning[:, None, None], axes @ U @ V, axes)
        return loads @ axes.transpose(0, 2, 1)

    def _local_sums(self, snapshot: Snapshot) -> Array:
        """This rank's sums of f and (xi - xi_r)_i f, shape (n, 4, 3), and the mean directors."""
        q = np.concatenate([snapshot.state.q, GROUND]).reshape(-1, 4, 3)[self._slots, 1:]
        if self._q is None or snapshot.report is None:
            self._directors = None
        else:
            assert snapshot.index == self._next_index, "reactions need every step of a run"
            start = self._q if snapshot.stepper.forces_at < 1.0 else q
            self._directors = 0.5 * (start + q)
        self._q, self._next_index = q, snapshot.index + 1
        forces = [f.array_r.reshape(-1, 3) for f in snapshot.state.coupling]
        sums = [weights @ forces[index][rows] for index, rows, weights in self._where]
        return np.array(sums).reshape(-1, 4, 3)

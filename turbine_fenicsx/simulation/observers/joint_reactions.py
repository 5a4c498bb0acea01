"""Forces and moments in joints, from the multipliers.

With the multipliers lambda of a joint, and the gradients G of its constraints and of its joint
coordinates in the middle of the step, f = -G^T lambda acts on the coordinates (phi, d1, d2, d3) of
a body in the step from t_n to t_{n+1}. With the means d_i, phi and r, the point of the moment, that
is

    F = f_phi,    M = sum_i d_i x f_i + (phi - r) x F.

A step is a mean over its length, so that for each body, with L about the origin,

    (p_{n+1} - p_n)/dt = weight + sum F,
    (L_{n+1} - L_n)/dt = moment of the weight + sum (M + r x F)

exactly, besides other loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import GROUND
from turbine_fenicsx.foundation.checks import check_array, check_vectors
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.postprocessing import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class JointReaction:
    """Where and along which axes the load in a joint is measured.

    Args:
        joint: The joint.
        point: Point of the moment, fixed to the second partner; its initial position [m], shape
            (3,). The joint's own point if None.
        axes: Axes of the components, fixed to the second partner; their initial directions as rows,
            shape (3, 3). The inertial axes e1, e2, e3 if None.

    Raises:
        ValueError: for a point or axes that are none, or a joint that has no point of its own.
    """

    joint: Joint
    point: npt.ArrayLike | None = None
    axes: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        """Check the data."""
        name = self.joint.name
        if self.point is None and not hasattr(self.joint, "point"):
            raise ValueError(f"joint {name!r} has no point of its own: give the one for its moment")
        check_vectors(name, point=self.place)
        if self.axes is not None:
            check_array(f"axes of {name!r}", self.axes, (3, 3), "three rows of three numbers")

    @property
    def place(self) -> npt.ArrayLike:
        """Point of the moment in the initial configuration [m], shape (3,)."""
        own: npt.ArrayLike = getattr(self.joint, "point", ())
        return own if self.point is None else self.point


class JointReactions:
    """Loads that the first partners of joints exert on the second through the joint.

    Torques, springs, dampers and drives on the joint's own coordinates are part of them. Where
    constraints of a joint are redundant (`MultibodySystem.redundant`), its load is one choice of
    many.

    Args:
        system: The system.
        reactions: What to measure.

    Attributes:
        reactions: What is measured.

    Raises:
        ValueError: if a joint is not part of the system.
    """

    def __init__(self, system: MultibodySystem, reactions: Sequence[JointReaction]) -> None:
        """Find the rows of the joints and the bodies that they act on."""
        self.reactions = tuple(reactions)
        self._model, n = system.rigid_model, len(self.reactions)
        self._rows = np.zeros((n, system.rigid_model.n_rows), dtype=bool)
        self._signs = np.ones((n, 1))
        self._slots = np.zeros((2, n), dtype=np.int64)  # the body that f acts on, that of the axes
        self._xi, self._axes = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
        ground = len(system.rigid_bodies)
        for k, reaction in enumerate(self.reactions):
            if reaction.joint not in system.joints:
                raise ValueError(f"joint {reaction.joint.name!r} is not among the parts")
            self._rows[k, system.joint_rows[reaction.joint.name]] = True
            first, second = reaction.joint.bodies
            # without a second body, what acts on the first in the opposite sense
            loaded = first if second is None else second
            self._signs[k] = -1.0 if second is None else 1.0
            place, R = np.asarray(reaction.place, dtype=float), np.eye(3)
            self._slots[:, k] = system.rigid_bodies.index(loaded), ground
            self._xi[k] = place
            if second is not None:
                self._slots[1, k] = self._slots[0, k]
                self._xi[k] = second.body_coordinates(place)
                R = np.asarray(second.directors, dtype=float)
            if reaction.axes is not None:
                self._axes[k] = np.asarray(reaction.axes, dtype=float) @ R
        self._turning = np.array([r.axes is not None for r in self.reactions], dtype=bool)
        self._last: tuple[Array, Array] | None = None
        self._next_index = 0
        self._snapshot: Snapshot | None = None
        self._loads = np.zeros((n, 2, 3))

    def at(self, snapshot: Snapshot) -> Array:
        """Loads on the second partners, mean values of the step that ended with a snapshot.

        To be called for every snapshot of a run, since the middle of a step lies between two.

        Args:
            snapshot: The snapshot.

        Returns:
            Force [N] and moment [N m] of each reaction, shape (n, 2, 3), equal on all ranks; zero
            in the first snapshot of a run, before which there was no step.
        """
        if snapshot is not self._snapshot:
            state = snapshot.state
            if self._last is None or snapshot.report is None:
                self._loads = np.zeros((len(self.reactions), 2, 3))
            else:
                assert snapshot.index == self._next_index, "reactions need every step of a run"
                forces = snapshot.stepper.constraint_forces(*self._last, state)
                start = self._last[0] if snapshot.stepper.forces_at < 1.0 else state.q
                self._loads = self._loads_of(*forces, 0.5 * (start + state.q))
            self._last = state.q.copy(), state.angles.copy()
            self._next_index, self._snapshot = snapshot.index + 1, snapshot
        return self._loads

    def at_rest(self, state: State) -> Array:
        """Loads in a static equilibrium, shape (n, 2, 3), as in `at`."""
        forces = self._model.constraint_forces(state.q, state.angles, state.multipliers)
        return self._loads_of(*forces, state.q)

    def _loads_of(self, lam: Array, G: Array, q: Array) -> Array:
        """Loads of the constraint forces -lam_k G_k, with the bodies at q."""
        f = -(self._signs * self._rows * lam) @ G
        f = f.reshape(len(f), -1, 4, 3)[np.arange(len(f)), self._slots[0]]
        q = np.concatenate([q, GROUND]).reshape(-1, 4, 3)
        (phi, d), (origin, e) = ((x[:, 0], x[:, 1:]) for x in (q[s] for s in self._slots))
        r = origin + np.einsum("ni,nij->nj", self._xi, e)
        F = f[:, 0]
        moments = np.cross(d, f[:, 1:]).sum(axis=1) + np.cross(phi - r, F)
        loads = np.stack([F, moments], axis=1)
        axes = self._axes
        if np.any(self._turning):
            U, _, V = np.linalg.svd(e)  # U V is the rotation half way between the two ends
            axes = np.where(self._turning[:, None, None], axes @ U @ V, axes)
        return loads @ axes.transpose(0, 2, 1)


def joint_channel(reactions: JointReactions) -> Channel:
    """Force and moment in each joint, three columns each."""
    columns = tuple(
        family(joint=reaction.joint.name, axis=i)
        for reaction in reactions.reactions
        for family in (names.JOINT_FORCE, names.JOINT_MOMENT)
        for i in (1, 2, 3)
    )
    return Channel(columns, lambda s: reactions.at(s).ravel().tolist())

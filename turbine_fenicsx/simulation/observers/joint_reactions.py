"""Forces and moments in joints, from the multipliers.

In the step from t_n to t_{n+1}, f = -G^T lambda acts on the coordinates (phi, d1, d2, d3) of a
body. Here lambda are the multipliers of a joint, and G the gradients of its constraints and of its
joint coordinates in the middle of the step. With the means d_i, phi and r, the point of the moment,
that is

    F = f_phi,    M = sum_i d_i x f_i + (phi - r) x F.

A step is a mean over its length, so that for each body, with L about the origin,

    (p_{n+1} - p_n)/dt = weight + sum F,
    (L_{n+1} - L_n)/dt = moment of the weight + sum (M + r x F)

exactly, besides other forces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import GROUND, RigidBody
from turbine_fenicsx.foundation.argument_checks import check_among_parts, check_array, check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.joints.base import Joint
from turbine_fenicsx.records import names
from turbine_fenicsx.simulation.observers.history import Channel
from turbine_fenicsx.simulation.observers.step_loads import LAST, NEXT, Coordinates, StepLoads
from turbine_fenicsx.simulation.snapshot import Snapshot
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class JointReaction:
    """Where and along which axes the load in a joint is measured.

    Args:
        joint: The joint.
        point: Point of the moment, fixed to the carrier; its initial position [m], shape (3,). The
            joint's own point if None.
        axes: Axes of the components, fixed to the carrier; their initial directions as rows, shape
            (3, 3). The inertial axes e1, e2, e3 if None.
        carrier: What carries point and axes: a body, None for the ground, or the second partner.

    Raises:
        ModelError: if point or axes have the wrong shape, or the joint defines no point.
    """

    joint: Joint
    point: npt.ArrayLike | None = None
    axes: npt.ArrayLike | None = None
    carrier: RigidBody | Literal["second partner"] | None = "second partner"

    def __post_init__(self) -> None:
        name = self.joint.name
        if self.point is None and not hasattr(self.joint, "point"):
            raise ModelError(f"joint {name!r} defines no point: give the one for its moment")
        check_vectors(name, point=self.place)
        if self.axes is not None:
            check_array(f"axes of {name!r}", self.axes, (3, 3), "three rows of three numbers")

    @property
    def place(self) -> npt.ArrayLike:
        """Point of the moment in the initial configuration [m], shape (3,)."""
        own: npt.ArrayLike = getattr(self.joint, "point", ())
        return own if self.point is None else self.point

    @property
    def frame(self) -> RigidBody | None:
        """The body that carries point and axes; None is the ground."""
        if isinstance(self.carrier, str):
            return self.joint.bodies[1]
        return self.carrier


class JointReactions(StepLoads):
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
        ModelError: if a joint is not part of the system.
    """

    def __init__(self, system: MultibodySystem, reactions: Sequence[JointReaction]) -> None:
        self.reactions = tuple(reactions)
        super().__init__([r.axes for r in reactions], [r.frame for r in reactions])
        self._model, n = system.rigid_model, len(self.reactions)
        self._rows, self._xi = np.zeros((n, system.rigid_model.n_rows)), np.zeros((n, 3))
        self._slots = np.zeros((2, n), dtype=np.int64)  # the body that f acts on, that of the axes
        ground = len(system.rigid_bodies)
        for k, reaction in enumerate(self.reactions):
            check_among_parts("joint", reaction.joint, system.joints)
            first, second = reaction.joint.bodies
            place = np.asarray(reaction.place, dtype=float)
            # f = -G^T lambda; what acts on the first partner is in the opposite sense
            self._rows[k, system.joint_rows[reaction.joint.name]] = 1.0 if second is None else -1.0
            acted, frame = first if second is None else second, reaction.frame
            self._xi[k] = place if frame is None else frame.body_coordinates(place)
            self._slots[:, k] = [
                ground if body is None else system.rigid_bodies.index(body)
                for body in (acted, frame)
            ]

    def at_rest(self, state: State) -> Array:
        """Loads in a static equilibrium, shape (n, 2, 3), as in `at`."""
        forces = self._model.constraint_forces(state.q, state.joint_coordinates, state.multipliers)
        return self._in_axes(*self._loads_of(*forces, state.q))

    def _evaluate(
        self, start: Coordinates, end: Coordinates, snapshot: Snapshot
    ) -> tuple[Array, Array]:
        """Loads on the second partners."""
        forces = snapshot.stepper.constraint_forces(*start, snapshot.state)
        return self._loads_of(*forces, 0.5 * (start[0] + end[0]))

    def _loads_of(self, lam: Array, G: Array, q: Array) -> tuple[Array, Array]:
        """Loads of the forces -lam_k G_k with the bodies at q, and the directors of the axes."""
        f = ((self._rows * lam) @ G).reshape(len(self._rows), -1, 4, 3)
        f = f[np.arange(len(f)), self._slots[0]]
        acted, frames = np.concatenate([q, GROUND]).reshape(-1, 4, 3)[self._slots]
        acted[:, 0] -= frames[:, 0] + (self._xi[:, None] @ frames[:, 1:])[:, 0]  # phi - r, d_i
        loads = np.empty((len(f), 2, 3))
        loads[:, 0] = f[:, 0]
        dyads = acted.transpose(0, 2, 1) @ f
        loads[:, 1] = dyads[:, NEXT, LAST] - dyads[:, LAST, NEXT]  # their skew part is x
        return loads, frames[:, 1:]


def joint_channel(reactions: JointReactions) -> Channel:
    """Force and moment in each joint, means of two steps, three columns each."""
    columns = tuple(
        family(joint=reaction.joint.name, axis=i)
        for reaction in reactions.reactions
        for family in (names.JOINT_FORCE, names.JOINT_MOMENT)
        for i in (1, 2, 3)
    )
    return Channel(columns, lambda s: reactions.mean_at(s).ravel().tolist(), reactions)

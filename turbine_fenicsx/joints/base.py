"""Joint interface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from turbine_fenicsx.bodies.rigid_body import BodyFrame, RigidBody
from turbine_fenicsx.foundation.quadratic import Quadratic
from turbine_fenicsx.joints.coordinates import JointCoordinate
from turbine_fenicsx.joints.rheonomic import Rheonomic


@runtime_checkable
class Joint(Protocol):
    """A joint between two rigid bodies, or between a rigid body and the ground (None).

    A joint only states quadratic functions of the coordinates; the time stepping scheme takes
    their exact discrete gradients. Functions built from scalar products of body-fixed directions
    and from differences of material points are frame-invariant, which is what conserves angular
    momentum.
    """

    @property
    def name(self) -> str:
        """Unique name."""

    @property
    def bodies(self) -> tuple[RigidBody | None, RigidBody | None]:
        """The two partners; None is the ground."""

    def constraints(self, a: BodyFrame, b: BodyFrame) -> Sequence[Quadratic | Rheonomic]:
        """Functions that vanish, or follow time, one per locked degree of freedom."""

    def coordinates(self, a: BodyFrame, b: BodyFrame) -> Mapping[str, JointCoordinate]:
        """Joint coordinates by unique name; the name of the joint itself if there is one."""

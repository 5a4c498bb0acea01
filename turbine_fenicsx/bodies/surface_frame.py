"""Frames without mass on the surfaces of flexible bodies.

Joints, and forces at points, act on frames: on a point and three directions that move as a rigid
body does. A frame on a surface has no mass. Its coordinates follow the nodes of the
surface by the coupling of eqs (53)-(54), and no inertia is added to the model.
"""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.argument_checks import check_vectors, describe
from turbine_fenicsx.foundation.errors import ModelError


class SurfaceFrame(RigidBody):
    """A frame without mass that moves with surfaces of flexible bodies, which it keeps rigid.

    It is a partner of joints and forces like any rigid body. With surfaces of two bodies it joins
    them. It must be among the parts of a system; its couplings are made by it.

    Args:
        name: Unique name.
        surfaces: Pairs of a flexible body and facets of its surface, indices local to this rank.
        point: Where it is initially [m], shape (3,); any point near the surfaces.
        velocity: Initial velocity of the point [m/s], shape (3,).
        angular_velocity: Initial angular velocity in space [rad/s], shape (3,).

    Attributes:
        couplings: The coupling of each surface, called "NAME on BODY".

    Raises:
        ModelError: if there is no surface, or a vector is not three numbers.
        TypeError: if a surface is not a flexible body and its facets.
    """

    couplings: tuple[Coupling, ...]

    def __init__(
        self,
        name: str,
        *surfaces: tuple[DeformableBody, npt.ArrayLike],
        point: npt.ArrayLike,
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        if not surfaces:
            raise ModelError(f"frame {name!r} needs a surface: a flexible body and its facets")
        vectors = {"position": point, "velocity": velocity, "angular_velocity": angular_velocity}
        check_vectors(name, **vectors)
        super().__init__(name, 0.0, (0.0, 0.0, 0.0), **vectors)
        couplings = tuple(self._couple(surface) for surface in surfaces)
        object.__setattr__(self, "couplings", couplings)

    def __post_init__(self) -> None:
        """A frame has no mass, which other rigid bodies must have."""

    def _couple(self, surface: Any) -> Coupling:
        """The coupling of a surface."""
        try:
            flexible, facets = surface
        except (TypeError, ValueError):
            flexible, facets = surface, None
        if not isinstance(flexible, DeformableBody) or facets is None:
            raise TypeError(
                f"a surface of frame {self.name!r} must be a pair of a flexible body and its "
                f"facets, got {describe(surface)}"
            )
        return Coupling(f"{self.name} on {flexible.name}", flexible, facets, self)

"""Force on a rigid body that turns with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.body_checks import check_body
from turbine_fenicsx.forces.force import BoundForce, Kind, Layout, StepTimes
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_vectors
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class FollowerForce:
    """A force on a material point, whose direction is fixed to the body.

    With the components f_j in the body frame, F = sum f_j d_j with the mean directors of the step.

    Args:
        name: Name under which its work is reported.
        body: The rigid body.
        point: Point in the initial configuration [m], shape (3,).
        force: Force in the initial configuration [N], shape (3,).
        function: Factor as a function of time [s].

    Raises:
        ModelError: if point or force are not three numbers.
        TypeError: if the body is not rigid, or the function is not one of time.
    """

    name: str
    body: RigidBody
    _: KW_ONLY
    point: npt.ArrayLike
    force: npt.ArrayLike
    function: Callable[[float], float] = ALWAYS
    kind: Kind = "external"

    def __post_init__(self) -> None:
        check_body(self.name, self.body)
        check_vectors(self.name, point=self.point, force=self.force)
        check_function(self.name, self.function)

    def bind(self, layout: Layout) -> BoundForce:
        """The force with its coordinates numbered."""
        _, index = layout.frames(self.body)
        weights = np.append(1.0, self.body.body_coordinates(self.point))
        f = np.asarray(self.force, dtype=float) @ np.asarray(self.body.directors, dtype=float)
        N = np.asarray(np.kron(np.outer(weights, np.append(0.0, f)), np.eye(3)), dtype=float)
        return _LinearForce(index, N, self.function)


@dataclass(frozen=True)
class _LinearForce:
    """The force p(t) N y at the middle of the step."""

    index: npt.NDArray[np.int64]
    N: Array
    function: Callable[[float], float]

    def force(self, y0: Array, y1: Array, step: StepTimes) -> tuple[Array, Array]:
        """Force and derivative."""
        N = self.function(step.middle) * self.N
        return N @ (0.5 * (y0 + y1)), 0.5 * N

    def energy(self, y: Array) -> float:
        return 0.0

"""Force on a material point of a rigid body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.body_checks import check_body
from turbine_fenicsx.forces.prescribed_force import ForceSum
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, check_vectors
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class PointForce:
    """A force with a direction fixed in space; its work is force times displacement of the point.

    Args:
        name: Name under which its work is reported.
        body: The rigid body.
        point: Point in the initial configuration [m], shape (3,).
        force: Force [N], shape (3,).
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

    def __post_init__(self) -> None:
        check_body(self.name, self.body)
        check_vectors(self.name, point=self.point, force=self.force)
        check_function(self.name, self.function)

    def add_to(self, forces: ForceSum, time: float) -> None:
        """Add the force."""
        if self.body not in forces.coordinates:
            raise ModelError(f"rigid body {self.body.name!r} is not among the parts")
        forces.coordinates[self.body][:] += self.function(time) * self._generalised

    @cached_property
    def _generalised(self) -> Array:
        """Force on (phi, d1, d2, d3): F and xi_i F."""
        weights = np.append(1.0, self.body.body_coordinates(self.point))
        return np.outer(weights, np.asarray(self.force, dtype=float)).ravel()

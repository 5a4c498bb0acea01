"""Force on the mass of a flexible body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.forces.time_functions import ALWAYS
from turbine_fenicsx.foundation.argument_checks import check_function, describe
from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class BodyForce:
    """A force per mass with a direction fixed in space, a field in the initial configuration.

    It follows the material: int rho b(X) . w dV. Fields make line loads, pitching moments and the
    centrifugal force of a given speed. `Gravity` acts on all bodies alike and counts as potential.

    Args:
        name: Name under which its work is reported.
        flexible: The body.
        field: b, a function of positions of shape (n, 3) [m] that returns as many forces per mass
            [N/kg].
        function: Factor as a function of time [s].

    Raises:
        TypeError: if field or function are no functions.
    """

    name: str
    flexible: DeformableBody
    _: KW_ONLY
    field: Callable[[Array], Array]
    function: Callable[[float], float] = ALWAYS

    def __post_init__(self) -> None:
        if not callable(self.field):
            raise TypeError(
                f"field of {self.name!r} must be a function of positions, got "
                f"{describe(self.field)}"
            )
        check_function(self.name, self.function)

"""Constraint of a joint that follows a function of time."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from turbine_fenicsx.foundation.quadratic import Quadratic


class Rheonomic(NamedTuple):
    """The constraint Phi(q) = p(t), in place of Phi(q) = 0 among those of a joint.

    It holds at the ends of all steps, and the work of its multiplier counts as external work under
    the name of the joint.

    Attributes:
        function: Phi.
        motion: p as a function of time [s], in the unit of Phi; at t = 0 and shortly after it, it
            must fit positions and velocities of the bodies.
    """

    function: Quadratic
    motion: Callable[[float], float]


def function_of(constraint: Quadratic | Rheonomic) -> Quadratic:
    """The function of the coordinates in a constraint."""
    return constraint.function if isinstance(constraint, Rheonomic) else constraint

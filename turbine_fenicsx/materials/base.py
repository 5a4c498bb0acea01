"""What every material is to the rest of the code: a strain energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import ufl


@runtime_checkable
class Material(Protocol):
    """A hyperelastic material, given by its strain energy and nothing else.

    A user's own material is a class with these two members; stress, tangent and discrete gradient
    follow from `strain_energy` by differentiation.
    """

    @property
    def quadratic(self) -> bool:
        """Whether W is quadratic in C; the mean stress is then an exact discrete gradient."""

    def strain_energy(self, C: Any, parameter: Callable[[Any], Any]) -> Any:
        """Strain energy per reference volume [J/m^3] as a UFL expression.

        Args:
            C: Right Cauchy-Green tensor, a UFL tensor of shape (3, 3).
            parameter: Turns numbers and arrays into UFL constants, so that another value of a
                parameter needs no new compilation.
        """


def second_piola_kirchhoff(energy: Callable[[Any], Any], C: Any) -> Any:
    """S = 2 dW/dC, symmetric, shape (3, 3) [Pa]."""
    C = ufl.variable(C)
    return 2.0 * ufl.sym(ufl.diff(energy(C), C))

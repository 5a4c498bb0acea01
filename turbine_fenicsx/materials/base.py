"""Material interface: a strain energy, and perhaps a viscous stress."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, runtime_checkable

import ufl
from ufl.core.expr import Expr

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.kinematics import right_cauchy_green


@runtime_checkable
class Material(Protocol):
    """A hyperelastic material, given by its strain energy and nothing else.

    A user's own material is a class with these two members; stress, tangent and discrete gradient
    follow from `strain_energy` by differentiation.
    """

    @property
    def quadratic(self) -> bool:
        """Whether W is quadratic in C; the mean stress is then an exact discrete gradient."""

    def strain_energy(self, C: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Strain energy per reference volume [J/m^3] as a UFL expression.

        Args:
            C: Right Cauchy-Green tensor, a UFL tensor of shape (3, 3).
            parameter: Turns numbers and arrays into UFL constants, so that another value of a
                parameter needs no new compilation; a `cell_field` stays what it is.
        """


@runtime_checkable
class Viscous(Protocol):
    """Additional interface of viscous materials; the code asks for it by `isinstance`."""

    def viscous_stress(self, E_dot: Expr, parameter: Callable[[Any], Expr]) -> Expr:
        """Viscous second Piola-Kirchhoff stress S_v [Pa] as a UFL expression.

        It must be symmetric, and S_v : E_dot must not be negative for any E_dot.

        Args:
            E_dot: Rate of the Green-Lagrange strain [1/s], a symmetric UFL tensor of shape (3, 3).
                In a step it is (E_{n+1} - E_n)/dt, so that S_v : (E_{n+1} - E_n) is the energy
                per volume that the step takes out [J/m^3].
            parameter: As for `Material.strain_energy`.

        Returns:
            UFL tensor of shape (3, 3).
        """


class Quadrature(NamedTuple):
    """Points of a reference cell, shape (n, 3), and their weights, shape (n,)."""

    points: Array
    weights: Array


@runtime_checkable
class Sampled(Protocol):
    """Additional interface of materials whose energy is sampled at special points."""

    @property
    def quadrature(self) -> Quadrature | None:
        """Points on the reference cell, weights that add up to its volume; None for the usual."""


def second_piola_kirchhoff(energy: Callable[[Expr], Expr], C: Expr) -> Expr:
    """S = 2 dW/dC, symmetric, shape (3, 3) [Pa]."""
    C = ufl.variable(C)
    return 2.0 * ufl.sym(ufl.diff(energy(C), C))


def stress_at_rest(energy: Callable[[Expr], Expr], E: Expr, quadratic: bool = False) -> Expr:
    """The linear stress D_0 : E, with the elasticity D_0 = 4 W''(I) of a material at rest.

    Args:
        E: A symmetric strain, shape (3, 3).
        quadratic: Whether W is quadratic in C; its stress 2 W'(I + 2 E) is linear in E.
    """
    if quadratic:
        return second_piola_kirchhoff(energy, ufl.Identity(3) + 2.0 * E)
    C = ufl.variable(ufl.Identity(3))
    S = 2.0 * ufl.sym(ufl.diff(energy(C), C))
    i, j, k, m = ufl.indices(4)
    return ufl.sym(ufl.as_tensor(ufl.diff(S, C)[i, j, k, m] * 2.0 * E[k, m], (i, j)))


def cauchy_stress(energy: Callable[[Expr], Expr], F: Expr) -> Expr:
    """The stress sigma = F S F^T / det F with S = 2 dW/dC at C = F^T F, shape (3, 3) [Pa]."""
    return F * second_piola_kirchhoff(energy, right_cauchy_green(F)) * F.T / ufl.det(F)

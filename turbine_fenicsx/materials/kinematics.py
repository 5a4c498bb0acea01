"""Kinematics of a flexible body in UFL: deformation gradient and strain measures."""

from __future__ import annotations

import ufl
from ufl.core.expr import Expr


def deformation_gradient(u: Expr) -> Expr:
    """F = I + grad u."""
    return ufl.Identity(3) + ufl.grad(u)


def right_cauchy_green(F: Expr) -> Expr:
    """C = F^T F."""
    return F.T * F


def strain_rate(F: Expr, D: Expr) -> Expr:
    """E' = sym(F^T D) for the rate, or the increment, D of F."""
    return ufl.sym(F.T * D)


def green_lagrange(C: Expr) -> Expr:
    """E = (C - I)/2."""
    return 0.5 * (C - ufl.Identity(3))

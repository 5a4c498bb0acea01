"""Kinematics of a flexible body in UFL: deformation gradient and strain measures."""

from __future__ import annotations

from typing import Any

import ufl


def deformation_gradient(u: Any) -> Any:
    """F = I + grad u."""
    return ufl.Identity(3) + ufl.grad(u)


def right_cauchy_green(F: Any) -> Any:
    """C = F^T F."""
    return F.T * F


def strain_rate(F: Any, D: Any) -> Any:
    """E' = sym(F^T D) for the rate, or the increment, D of F."""
    return ufl.sym(F.T * D)


def green_lagrange(C: Any) -> Any:
    """E = (C - I)/2."""
    return 0.5 * (C - ufl.Identity(3))

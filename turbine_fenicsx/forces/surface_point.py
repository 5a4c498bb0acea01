"""A point of a surface, as the forces on it see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class SurfacePoint:
    """Where and when a force acts, in UFL; in an energy-momentum step, at its middle.

    In such a step ``x0`` and ``x1`` are the ends of the way of the point, with which a force can be
    the exact discrete gradient of an energy. Everywhere else (end of a step, rest) both are ``x``.

    Args:
        X: Initial position [m], shape (3,).
        x: Present position [m], shape (3,).
        x0: Position at the start of the step [m], shape (3,).
        x1: Position at its end [m], shape (3,).
        v: Velocity [m/s], shape (3,).
        F: Deformation gradient, shape (3, 3).
        N: Outward normal in the initial configuration, shape (3,).
        time: Time [s].
        factor: Value of the force's function of time.
        parameter: Turns numbers and arrays into UFL constants, so that another value of a
            parameter needs no new compilation.
    """

    X: Any
    x: Any
    x0: Any
    x1: Any
    v: Any
    F: Any
    N: Any
    time: Any
    factor: Any
    parameter: Callable[[Any], Any]

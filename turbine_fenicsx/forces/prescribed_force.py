"""Interfaces of the forces that depend on time, and of those on flexible bodies.

A force that depends on time alone is a `PrescribedForce`; one on a flexible body is a
`SurfaceForce` or a `NodeForce`. Forces on rigid bodies or joint coordinates that depend on their
motion are a `turbine_fenicsx.forces.force.Force`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.forces.surface_point import SurfacePoint
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array


@dataclass
class ForceSum:
    """Generalised forces at one time, the sum of all prescribed forces.

    Args:
        coordinates: Forces on the coordinates of each rigid body, each of shape (12,) [N, N m].
        torques: Torque or force on each joint coordinate by name [N m, N].
        acceleration: Acceleration of gravity that acts on all masses, shape (3,) [m/s^2].
    """

    coordinates: Mapping[RigidBody, Array]
    torques: dict[str, float]
    acceleration: Array = field(default_factory=lambda: np.zeros(3))


def check_force_sum(force: PrescribedForce, forces: ForceSum) -> None:
    """Raise a ModelError for a sum that a force has replaced by something of another shape."""
    parts: list[tuple[str, Any, tuple[int, ...]]] = [
        *((f"the force on {body.name!r}", x, (12,)) for body, x in forces.coordinates.items()),
        *((f"the torque of {name!r}", x, ()) for name, x in forces.torques.items()),
        ("the acceleration", forces.acceleration, (3,)),
    ]
    for what, found, shape in parts:
        if np.shape(found) != shape:
            raise ModelError(
                f"{what} must keep the shape {shape} in add_to() of {describe(force)}, got "
                f"{np.shape(found)}"
            )


@runtime_checkable
class PrescribedForce(Protocol):
    """Something that drives the system, whatever its motion.

    The step evaluates them at t_{n+1/2}; the work of forces and torques over a step is exactly
    force times increment of the coordinate. Gravity counts as potential energy instead. A force
    may have a ``name``, under which its work is reported.
    """

    def add_to(self, forces: ForceSum, time: float) -> None:
        """Add this force at the given time [s]; raises ModelError for an unknown joint or body."""


@runtime_checkable
class SurfaceForce(Protocol):
    """A force on a part of the surface of a flexible body, whose work counts as external.

    That of a `SurfacePotential` counts as energy.
    """

    @property
    def name(self) -> str:
        """Name under which its work is reported."""

    @property
    def flexible(self) -> FlexibleBody:
        """The body."""

    @property
    def facets(self) -> npt.NDArray[np.int32]:
        """Facets of the surface, indices local to this rank (ghosts allowed)."""

    @property
    def function(self) -> Callable[[float], float]:
        """Factor as a function of time [s]."""

    def traction(self, at: SurfacePoint) -> Any:
        """Force per reference area [N/m^2] at a point of the surface, as a UFL vector."""


@runtime_checkable
class SurfacePotential(SurfaceForce, Protocol):
    """A force on a surface with a potential energy, which counts in `Balance.spring`.

    Its traction t must be the discrete gradient of the energy V, t . (x1 - x0) = V(x0) - V(x1), or
    the balance of energy shows what is missing.
    """

    @property
    def kind(self) -> Literal["conservative"]:
        """Where its work goes: into its own energy."""

    def energy(self, at: SurfacePoint) -> Any:
        """Potential energy per reference area [J/m^2] at the position x, as a UFL scalar."""


def has_energy(force: SurfaceForce) -> bool:
    """Whether the work of a force on a surface is that of an energy."""
    kind = getattr(force, "kind", "external")
    if kind not in ("external", "conservative"):
        raise ModelError(
            f"kind of {force.name!r} must be 'external' or 'conservative' for a force on a "
            f"surface, got {kind!r}"
        )
    if kind == "conservative" and not callable(getattr(force, "energy", None)):
        raise ModelError(f"{force.name!r} is conservative and needs the method energy(at)")
    return bool(kind == "conservative")

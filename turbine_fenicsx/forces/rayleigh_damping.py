"""Rayleigh damping of a flexible body, which leaves its momenta alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy.typing as npt

from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.foundation.argument_checks import check_number
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True, eq=False)
class HeldPart:
    """A part of a flexible body, and the surface that something rigid holds it by.

    Args:
        facets: Facets of the surface, indices local to this rank (ghosts allowed).
        cells: Cells of the part, indices local to this rank (ghosts allowed); None is all.
    """

    facets: npt.ArrayLike
    cells: npt.ArrayLike | None = None


@dataclass(frozen=True, eq=False)
class RayleighDamping:
    """Damping in proportion to stiffness and mass, Rayleigh's D = beta K + alpha M.

    The part in proportion to the stiffness is the viscous stress beta D_0 : E' with the elasticity
    D_0 of the material at rest. The part in proportion to the mass acts on the velocity of each
    node relative to the surface that holds it: forces on the nodes of a blade react at its root.
    So neither changes a momentum, nor resists a rigid motion. A mode of the angular frequency w
    [rad/s] of a body that is held at rest is damped by the ratio

        (beta w + alpha/w)/2.

    The mass of a node is the diagonal of the consistent mass matrix, scaled to the mass of the
    body (Hinton, Rock, Zienkiewicz 1976), which is positive for all elements.

    Args:
        name: Unique name.
        flexible: The body.
        stiffness: beta [s], not negative.
        mass: alpha [1/s], not negative.
        held: What holds the body; needed if alpha is not zero.

    Raises:
        ModelError: for a negative number, or alpha without something that holds the body.
    """

    name: str
    flexible: DeformableBody
    _: KW_ONLY
    stiffness: float
    mass: float = 0.0
    held: Sequence[HeldPart] = ()

    def __post_init__(self) -> None:
        for key in ("stiffness", "mass"):
            value = check_number(f"{key} of {self.name!r}", getattr(self, key))
            if value < 0.0:
                raise ModelError(f"{key} of {self.name!r} must not be negative, got {value:g}")
        if self.mass > 0.0 and not self.held:
            raise ModelError(
                f"mass of {self.name!r} = {self.mass:g} needs held, the surfaces that the motion "
                "counts from"
            )

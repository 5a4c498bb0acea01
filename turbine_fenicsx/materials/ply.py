"""Plies of a laminate: an orthotropic material, a thickness and an angle."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.orthotropic import Triple, stiffness_matrix


@dataclass(frozen=True)
class Strengths:
    """Strengths of a ply in its own axes, all positive; infinite where nothing is known.

    Args:
        tension: Along the fibre, across it, through the thickness [Pa].
        compression: The same [Pa].
        shear: In the planes 12, 13 and 23 [Pa].
    """

    tension: Triple = (inf, inf, inf)
    compression: Triple = (inf, inf, inf)
    shear: Triple = (inf, inf, inf)

    def __post_init__(self) -> None:
        if not all(value > 0.0 for value in (*self.tension, *self.compression, *self.shear)):
            raise ModelError(f"strengths of a ply must be positive, got {self}")


@dataclass(frozen=True)
class PlyMaterial:
    """Orthotropic material: axis 1 along the fibre, 2 across it in the ply, 3 normal to the ply.

    Args:
        name: For messages and tables.
        density: Mass per volume [kg/m^3].
        young: E1, E2, E3 [Pa].
        shear: G12, G13, G23 [Pa].
        poisson: nu12, nu13, nu23 [-]; nu_ij is the contraction along j under tension along i.
        strengths: Stresses at which it fails.

    Raises:
        ModelError: for a density that is not positive, or a stiffness that is not positive
            definite.
    """

    name: str
    density: float
    young: Triple
    shear: Triple
    poisson: Triple
    strengths: Strengths = Strengths()

    def __post_init__(self) -> None:
        if not 0.0 < self.density < inf:
            raise ModelError(f"density of {self.name!r} must be positive, got {self.density:g}")
        try:
            stiffness_matrix(self.young, self.shear, self.poisson)
        except ModelError as error:
            raise ModelError(f"{self.name!r}: {error}") from error


@dataclass(frozen=True)
class Ply:
    """One layer of a laminate; a laminate is a tuple of these from its outer to its inner face.

    Args:
        material: What it is made of.
        thickness: Its thickness [m].
        angle: From the span to the fibre, positive about the normal of the wall that points
            outwards [rad].
    """

    material: PlyMaterial
    thickness: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.thickness < inf:
            raise ModelError(
                f"thickness of a ply of {self.material.name!r} must be positive, got "
                f"{self.thickness:g}"
            )
        if not -inf < self.angle < inf:
            raise ModelError(f"angle of a ply of {self.material.name!r} must be a finite number")

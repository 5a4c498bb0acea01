"""Plies of a laminate: an orthotropic material, a thickness and an angle."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.materials.orthotropic import Triple, stiffness_matrix

_SINGULAR = 1e-6
"""Least relative determinant of the compliance in plane stress [-]."""


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
        ModelError: if the density or a modulus is not positive, or if the stiffness is not positive
            definite; with nu12 below 1 that of plane stress is enough, so nu = 0.5 is valid.
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
        (E1, E2, _), nu = self.young, self.poisson[0]
        if not all(0.0 < modulus < inf for modulus in (*self.young, *self.shear)):
            raise ModelError(
                f"{self.name!r}: material is not positive definite: Young's moduli {self.young} "
                f"and shear moduli {self.shear} must be positive"
            )
        # the compliance ((1/E1, -nu/E1), (-nu/E1, 1/E2)) has a positive determinant
        if abs(nu) < 1.0 and nu * nu * E2 < (1.0 - _SINGULAR) * E1:
            return
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

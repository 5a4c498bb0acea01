"""Lame parameters of isotropic materials."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.materials.cell_fields import Scalar, check_cells


def lame_constants(young: float, poisson: float) -> tuple[float, float]:
    """First Lame parameter and shear modulus [Pa] from Young's modulus [Pa] and Poisson's ratio."""
    return (
        young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
        young / (2.0 * (1.0 + poisson)),
    )


def check_lame(first_lame: Scalar, shear_modulus: Scalar) -> None:
    """Raise a ModelError unless shear and bulk modulus are positive, in all cells."""
    words = "material is not positive definite: "
    check_cells(
        words + "shear modulus {shear_modulus} Pa",
        lambda mu: (mu > 0.0) & (mu < np.inf),
        shear_modulus=shear_modulus,
    )
    check_cells(
        words + "bulk modulus Lambda + 2 mu/3, Lambda {first_lame} Pa, mu {shear_modulus} Pa",
        lambda lam, mu: (lam + 2.0 * mu / 3.0 > 0.0) & (lam < np.inf),
        first_lame=first_lame,
        shear_modulus=shear_modulus,
    )

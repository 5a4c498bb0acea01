"""Numbers of a section that engineers compare, from its matrices."""

from __future__ import annotations

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.sections.centres import (
    find_principal_axes,
    find_shear_centre,
    find_tension_centre,
)


def find_properties(stiffness: Array, inertia: Array) -> dict[str, float]:
    """Columns of a table of sections.

    Bending stiffnesses are about the principal axes, the smaller one first, with the angle from x
    to its axis. Each stiffness is that of a section which is free to deform otherwise.

    Args:
        stiffness: Shape (6, 6) [N, N m, N m^2].
        inertia: Mass matrix, shape (6, 6) [kg/m, kg, kg m].
    """
    S = np.linalg.inv(stiffness)
    (small, large), angle = find_principal_axes(S)
    (x_t, y_t), (x_s, y_s) = find_tension_centre(S), find_shear_centre(S)
    mass = inertia[2, 2]
    # forces at the shear centre
    shear = [1.0 / (S[k, k] - S[k, 5] ** 2 / S[5, 5]) for k in (0, 1)]
    return {
        "mass_[kg/m]": mass,
        "stretch_stiffness_[N]": 1.0 / S[2, 2],
        "shear_stiffness_x_[N]": shear[0],
        "shear_stiffness_y_[N]": shear[1],
        "bending_stiffness_1_[Nm2]": small,
        "bending_stiffness_2_[Nm2]": large,
        "bending_angle_[deg]": np.degrees(angle),
        "torsion_stiffness_[Nm2]": 1.0 / S[5, 5],
        "mass_centre_x_[m]": -inertia[2, 4] / mass,
        "mass_centre_y_[m]": inertia[2, 3] / mass,
        "tension_centre_x_[m]": x_t,
        "tension_centre_y_[m]": y_t,
        "shear_centre_x_[m]": x_s,
        "shear_centre_y_[m]": y_s,
    }

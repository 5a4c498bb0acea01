"""The skewed wake of a rotor that does not face the wind: more induction where it is deep.

    w = w_0 (1 + K r/R tan(chi/2) cos(psi)),    tan(chi) = V_p/(V_n - w_m).

chi is the angle between the wake and the shaft, from the wind V_n through the rotor and V_p in its
plane and the mean induced velocity w_m. The angle psi in the rotor plane counts from the direction
in which the wake leaves. Glauert proposed the form, D. M. Pitt and D. A. Peters (Vertica 5, 1981)
found K = 15 pi/32.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np

from turbine_fenicsx.foundation.argument_checks import check_not_negative
from turbine_fenicsx.foundation.types import Array

PITT_PETERS = 15.0 * np.pi / 32.0


@dataclass(frozen=True)
class SkewedWake:
    """How much a skewed wake changes the induced velocity.

    Args:
        factor: K [-].
    """

    factor: float = PITT_PETERS

    def __post_init__(self) -> None:
        check_not_negative("factor of the skewed wake", self.factor)

    def find_factors(
        self, wind: Array, shaft: Array, induced: float, outward: Array, part: Array
    ) -> Array:
        """Factors of the axial induced velocities of all sections; never negative.

        Args:
            wind: Mean wind relative to the rotor, shape (3,) [m/s].
            shaft: Direction of the shaft, downwind, shape (3,).
            induced: w_m, against the wind [m/s].
            outward: Directions from the shaft to the sections, shape (n, 3).
            part: r/R, shape (n,) [-].
        """
        through = float(wind @ shaft)
        V_p = wind - through * shaft
        V_n, in_plane = through - induced, hypot(*V_p.tolist())
        # tan(chi/2) = V_p/(V_n + |V|), as a vector in the rotor plane
        reach = V_n + hypot(V_n, in_plane)
        slope = in_plane / reach if reach > 1e-6 else 0.0
        strength = self.factor / (reach * max(1.0, self.factor * slope)) if slope else 0.0
        return np.asarray(1.0 + np.minimum(part, 1.0) * (outward @ (strength * V_p)))

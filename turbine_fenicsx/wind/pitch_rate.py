"""Loads of a section that turns about its span, by the theory of thin aerofoils.

A section that turns nose up with the rate theta' relative to the rotor sees a flow whose angle
changes along the chord. The angle of attack is that at three quarters of the chord c, and a force
for each length acts there too, at right angles to the chord,

    alpha = atan2(V_up + x c theta', V_forward),      x = 1/2 + V_forward/(4 W) - x_ac,
    f = sigma pi rho (c/2)^2 V_forward theta',        m = -x c f,

where x_ac c is the place of the aerodynamic centre, and V is the flow there, with the speed W. All
is turned round where the flow comes from behind. A flat plate has sigma = 1, so that
sigma = C_l,alpha/(2 pi), at most one; a cylinder has none.

About a point at b a behind the middle, with c = 2 b, the moment is 2 pi rho V b^3 a (1/2 - a)
theta', which dampens turns about points before the middle. Nothing else in the air dampens torsion:
without these terms soft blades flutter.

T. Theodorsen, NACA report 496 (1935), with C(k) = 1 and without apparent mass, which leaves out
how long lift takes; M. H. Hansen, M. Gaunaa, H. Aa. Madsen, Risoe-R-1354 (2004).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.foundation.types import Array

MIN_SPEED = 1e-6
"""Minimum speed of the flow that is divided by [m/s]."""


class PitchRate:
    """Loads that sections have from turning.

    Args:
        sigma: Lift slope of the stations of a blade as a part of that of a flat plate [-].
        chord: c at the stations of all blades, shape (n,) [m].
        centre: x_ac, the aerodynamic centre as a fraction of the chord, shape (n,) [-].

    Attributes:
        area: sigma pi (c/2)^2, shape (n,) [m^2].
        middle: From there to the middle of the chord, 1/2 - x_ac, shape (n,) [-].
    """

    def __init__(self, sigma: Array, chord: Array, centre: npt.ArrayLike) -> None:
        self.area = 0.25 * np.pi * np.resize(sigma, len(chord)) * chord**2
        self._chord = chord
        self.middle = np.broadcast_to(0.5 - np.asarray(centre), chord.shape)

    def find(self, rate: Array, forward: Array, W: Array) -> tuple[Array, Array, Array]:
        """Change of V_up [m/s], f/rho [m^3/s^2] and m/rho [m^4/s^2], shapes (n,).

        Args:
            rate: theta', shape (n,) [rad/s].
            forward: V_forward, shape (n,) [m/s].
            W: Speed of the flow across the section, shape (n,) [m/s].
        """
        lever = (self.middle + 0.25 * forward / np.maximum(W, MIN_SPEED)) * self._chord
        f = self.area * forward * rate
        return lever * rate, f, -lever * f

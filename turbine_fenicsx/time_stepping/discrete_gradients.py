"""Algorithmic stresses S_alg of the energy-momentum step as UFL expressions.

With F at the midpoint, D = grad(u_{n+1} - u_n), the mean C_bar = (C_n + C_{n+1})/2 and the
increment dC = C_{n+1} - C_n are, without cancellation,

    C_bar = F^T F + D^T D/4,        dC = F^T D + D^T F,

and S_alg is a discrete gradient of the strain energy: S_alg : dC/2 = W_{n+1} - W_n.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ufl

from turbine_fenicsx.materials.base import second_piola_kirchhoff

Energy = Callable[[Any], Any]
"""W as a function of C."""

AlgorithmicStress = Callable[[Energy, Any, Any], Any]
"""S_alg as a function of W, F at the midpoint, and D."""

SMALL_INCREMENT = 2e-3
"""Below this |dC| two Gauss points integrate W' along dC to round-off, if W is smooth."""

ROUND_OFF = 2.0 * 2.0**-52
"""Round-off of a difference of energies, relative to what the energies consist of.

Measured for six smooth laws at random C: less than a quarter of this for strains up to 0.1, and
about this in the worst of a thousand for a half.
"""


def mean_strain(F: Any, D: Any) -> Any:
    """C_bar."""
    return F.T * F + 0.25 * D.T * D


def mean_stress(energy: Energy, F: Any, D: Any) -> Any:
    """S(C_bar); for W quadratic in C this is (S_n + S_{n+1})/2 and an exact discrete gradient."""
    return second_piola_kirchhoff(energy, mean_strain(F, D))


def general_stress(energy: Energy, F: Any, D: Any) -> Any:
    """Discrete gradient for any W(C): mean of S along dC, closed by Gonzalez' correction.

    S_G = [S(C_bar - dC/sqrt(12)) + S(C_bar + dC/sqrt(12))]/2 is the two-point Gauss rule of the
    average of S between C_n and C_{n+1} (the mean value discrete gradient). The missing energy is
    added along dC (Gonzalez 2000),

        S_alg = S_G + 2 [W_{n+1} - W_n - S_G:dC/2] / (dC:dC) dC.

    Where W has five bounded derivatives, the bracket is O(dC^5): below `SMALL_INCREMENT` it is
    smaller than the round-off of W, which would become noise in the stress when it is divided by
    |dC|. Where the stress has a kink, as that of fibres which bear tension only, it is O(dC^2).
    So a small increment is corrected where the bracket exceeds the round-off of W, and nowhere
    else. (The same correction of the midpoint stress S(C_bar) has a bracket of O(dC^3), and
    Newton's method stalls in its noise.)
    """
    # mean of S at two Gauss points between the ends of the step
    C_bar, dC = F.T * F + 0.25 * D.T * D, F.T * D + D.T * F
    gauss = 12.0**-0.5
    S = 0.5 * second_piola_kirchhoff(energy, C_bar - gauss * dC)
    S += 0.5 * second_piola_kirchhoff(energy, C_bar + gauss * dC)
    W_n, W_n1 = energy(C_bar - 0.5 * dC), energy(C_bar + 0.5 * dC)
    # energy that this mean lacks, added along dC
    gap = W_n1 - W_n - 0.5 * ufl.inner(S, dC)
    size = ufl.inner(dC, dC)
    # W may be a difference of terms as large as the stiffness; C is rounded too
    terms = (
        abs(_stiffness_in_swelling_and_shear(energy))
        + abs(W_n)
        + abs(W_n1)
        + abs(ufl.inner(S, C_bar))
    )
    kept = ufl.conditional(ufl.gt(abs(gap), ROUND_OFF * terms), gap, 0.0)
    kept = ufl.conditional(ufl.gt(size, SMALL_INCREMENT**2), gap, kept)
    return S + 2.0 * kept / (size + 1e-200) * dC  # 0/0 without an increment


def discrete_gradient_stress(quadratic: bool) -> AlgorithmicStress:
    """The stress that conserves energy exactly for the kind of strain energy."""
    return mean_stress if quadratic else general_stress


def _stiffness_in_swelling_and_shear(energy: Energy) -> Any:
    """D H:D_0:H of the material at rest for a strain H that stretches all directions and shears."""
    s = ufl.variable(ufl.as_ufl(0.0))
    H = ufl.as_tensor([[1.0, 0.5, 0.5], [0.5, 1.0, 0.5], [0.5, 0.5, 1.0]])
    W = energy(ufl.Identity(3) + 2.0 * s * H)
    return ufl.diff(ufl.diff(W, s), s)

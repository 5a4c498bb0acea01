"""Fatigue of plies: S-N curves and constant-life diagrams of their stresses.

A cycle of amplitude A about a mean M is survived

    N = (d/(g_b A))^m,    d = min(a_t - b_t g_a M, a_c + b_c g_a M)

times, with the slope m of the S-N curve and partial factors g_a of the strength and g_b of fatigue;
once if it reaches a strength. With the strengths R_t and R_c the shifted Goodman diagram has
d = min(R_t - M, R_c + M), the distance to the nearer strength. Goodman's has
d = S_1 min(1 - M/R_t, 1 + M/R_c). The S-N curve of cycles about zero is S = S_1 N^(-1/m) there.

Four stresses count: along the fibre, across it, of shear, and the exertion of Tsai and Hill

    e^2 = (s1/X)^2 - s1 s2/X^2 + (s2/Y)^2 + (t/S)^2,

with the strengths for the signs of s1 and s2, where all that are known count. It has the sign of
the stress that in its history comes nearest to its strength, and fails at 1 and -1.

Germanischer Lloyd, Guideline for the Certification of Wind Turbines (2010), section 5.5.3;
DNV-ST-0376, Rotor blades for wind turbines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from functools import cached_property, lru_cache
from math import inf, isfinite
from typing import Literal

import numpy as np

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.materials.ply import PlyMaterial, Strengths
from turbine_fenicsx.materials.ply_table import PlyTable

Diagram = Literal["shifted_goodman", "goodman"]

MEASURES = ("11", "22", "12", "exertion")
"""The stresses that count: along the fibre, across it, of shear, and all together."""

CARBON, GLASS, BIAXIAL = 14.0, 10.0, 9.0
"""Slopes of plies with carbon fibres along axis 1, with glass fibres, and of biaxial ones, which
their matrix carries. These are the slopes that Germanischer Lloyd gives for carbon fibres, for
glass with epoxy, and for the weakest matrix, polyester."""

CARBON_MODULUS = 80e9
"""Plies whose E1 is larger have carbon fibres [Pa]."""

ALIKE = 1.2
"""Ratio of E1 and E2 up to which a ply is biaxial."""

ISOTROPIC = 1.01
"""Ratio of the largest and least Young's modulus up to which a material has no fibres."""


def find_usual_slope(material: PlyMaterial) -> float | None:
    """Slope of the S-N curve of a family of plies; None for a material without fibres."""
    E1, E2, _ = material.young
    if max(material.young) < ISOTROPIC * min(material.young):
        return None
    if max(E1, E2) > CARBON_MODULUS:
        return CARBON
    return BIAXIAL if max(E1, E2) < ALIKE * min(E1, E2) else GLASS


@dataclass(frozen=True)
class ConstantLife:
    """Lines of constant life of one stress, see the module.

    Args:
        tension: a_t.
        tension_slope: b_t, with the partial factor.
        compression: a_c.
        compression_slope: b_c.
        exponent: m; 0 for a stress that does not count.
    """

    tension: float = 0.0
    tension_slope: float = 0.0
    compression: float = 0.0
    compression_slope: float = 0.0
    exponent: float = 0.0

    def find_cycles(self, amplitude: Array | float, mean: Array | float) -> Array:
        """How often cycles are survived: once if they reach a strength."""
        up = self.tension - self.tension_slope * np.asarray(mean)
        down = self.compression + self.compression_slope * np.asarray(mean)
        margin = np.maximum(np.minimum(up, down), 0.0)
        with np.errstate(divide="ignore"):
            return np.asarray(np.maximum((margin / amplitude) ** self.exponent, 1.0))


@dataclass(frozen=True)
class PlyFatigue:
    """How a material fails by fatigue.

    Args:
        slope: Exponent m of its S-N curves [-].
        strengths: Those of the plies.
        first: Amplitude S_1 along the fibre for Goodman's diagram [Pa]; the lesser strength if
            None, as it is of all other stresses.
        diagram: ``"shifted_goodman"`` or ``"goodman"``.
        strength_factor: Partial factor g_a [-].
        fatigue_factor: Partial factor g_b [-].

    Raises:
        ModelError: for a slope or factor that is not positive.
    """

    slope: float
    strengths: Strengths
    first: float | None = None
    diagram: Diagram = "shifted_goodman"
    strength_factor: float = 1.0
    fatigue_factor: float = 1.0

    def __post_init__(self) -> None:
        values = self.slope, self.strength_factor, self.fatigue_factor, self.first or 1.0
        if not all(0.0 < value < inf for value in values):
            raise ModelError(f"slope, first amplitude and partial factors must be positive: {self}")

    @property
    def lives(self) -> tuple[ConstantLife, ...]:
        """Those of the four stresses."""
        s = self.strengths
        along, across = zip(s.tension[:2], s.compression[:2], strict=True)
        found = [
            self._draw(*along, self.first),
            self._draw(*across),
            self._draw(s.shear[0], s.shear[0]),
        ]
        known = any(life.exponent for life in found)
        return (*found, self._draw(1.0, 1.0) if known else ConstantLife())

    def _draw(self, tension: float, compression: float, first: float | None = None) -> ConstantLife:
        """The lines for two strengths; none if one of them is not known."""
        if not (isfinite(tension) and isfinite(compression)):
            return ConstantLife()
        lines = np.array([[tension, 1.0], [compression, 1.0]])
        if self.diagram == "goodman":
            S1 = first or min(tension, compression)
            lines = S1 * np.array([[1.0, 1.0 / tension], [1.0, 1.0 / compression]])
        lines[:, 1] *= self.strength_factor
        (a_t, b_t), (a_c, b_c) = (lines / self.fatigue_factor).tolist()
        return ConstantLife(a_t, b_t, a_c, b_c, self.slope)


@dataclass(frozen=True, eq=False)
class FatigueTable:
    """Fatigue of all plies of a table.

    Args:
        plies: The n plies.
        materials: By the names of materials; plies of others do not count.
        places: Number of histories of each ply.
    """

    plies: PlyTable
    materials: Mapping[str, PlyFatigue]
    places: int = 1

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """One over the strengths, 0 where they are not known, and the constant-life lines.

        Returns:
            Of the k histories: tension and compression along and across the fibre, and shear, shape
            (k, 5); lines of each stress as in `ConstantLife`, shape (k, 4, 5).
        """
        known = {name: _as_rows(fatigue) for name, fatigue in self.materials.items()}
        names = [ply.material.name for ply in self.plies.plies for _ in range(self.places)]
        of_plies = [known.get(name, _NOTHING) for name in names]
        strengths, lives = zip(*of_plies, strict=True) if of_plies else ((), ())
        return np.array(strengths).reshape(-1, 5), np.array(lives).reshape(-1, len(MEASURES), 5)


@lru_cache(maxsize=256)
def _as_rows(fatigue: PlyFatigue) -> tuple[Array, Array]:
    """Rows of a material."""
    s = fatigue.strengths
    strengths = [*s.tension[:2], *s.compression[:2], s.shear[0]]
    return 1.0 / np.array(strengths), np.array([astuple(life) for life in fatigue.lives])


_NOTHING = np.zeros(5), np.zeros((len(MEASURES), 5))
"""Rows of a ply that does not count."""

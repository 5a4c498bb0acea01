"""Blades with an outer surface that is known, whatever they are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.turbine.blades.blade_plan import BladeSurface


class Skin(BladeSurface, Protocol):
    """An outer surface that knows where its blade begins and ends."""

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""

    @property
    def length(self) -> float:
        """From the root to the tip along the span [m]."""


S = TypeVar("S", bound=Skin)


@dataclass(frozen=True, eq=False)
class ShapedBlades(Generic[S]):
    """The surface of a `turbine_fenicsx.turbine.blades.blade_plan.BladePlan`."""

    shape: S

    def rings(self, stations: int, around: int) -> Array:
        """Points of the outer surface for pictures, shape (stations, around, 3) [m]."""
        s = np.linspace(0.0, 1.0, stations)[:, None]
        return self.shape.surface(s, np.linspace(0.0, 1.0, around, endpoint=False)[None, :])

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""
        return self.shape.hub_radius

    @property
    def length(self) -> float:
        """From the root to the tip along the span [m]."""
        return self.shape.length

    @property
    def tip(self) -> Array:
        """Leading edge of the tip, shape (3,) [m]."""
        return np.asarray(self.shape.surface(np.ones(1), self.shape.leading(np.ones(1)))[0])

    @property
    def root_radius(self) -> float:
        """Radius of a circle around the root section [m]."""
        ring = self.shape.surface(np.zeros(1), np.linspace(0.0, 1.0, 65))
        return float(np.linalg.norm(ring[:, 1:], axis=1).max())

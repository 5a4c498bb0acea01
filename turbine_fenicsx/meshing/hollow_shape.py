"""Interface of shapes for the mesher of hollow blades: outer surface, walls, lines and webs.

A point of the outer surface has two coordinates. s is the fraction of the span, from 0 at the root
to 1 at the tip. The fraction a of the contour of a section is 0 at the trailing edge. It rises
along the suction side over the leading edge and back along the pressure side to 1, the same point
again. Where the trailing edge is flat and thick, this point is the middle of its face. Then the
first and the last panel, called "trailing edge", are the halves of the face; the second line and
the last but one are its corners. At a sharp trailing edge these panels have no width.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True)
class Web:
    """A shear web from the suction to the pressure side.

    Args:
        name: Its name.
        start: Fraction of the span where it begins [-].
        end: Fraction of the span where it ends [-].
    """

    name: str
    start: float
    end: float


class HollowShape(Protocol):
    """Outer surface, walls and webs of a blade, in its own frame.

    The frame is that of `turbine_fenicsx.meshing.RotorLayout`: a1 along the span, a2 towards the
    leading edge, a3 = a1 x a2 towards the suction side. Its origin is the rotor centre, so the root
    lies in the plane a1 = hub_radius.
    """

    @property
    def hub_radius(self) -> float:
        """Distance of the root from the rotor centre [m]."""

    @property
    def length(self) -> float:
        """Length of the span [m]."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Span fractions, rising from 0 to 1, where something begins, ends or has a kink."""

    @property
    def panels(self) -> tuple[str, ...]:
        """Names of the n panels around a section, from a = 0 to a = 1; names may repeat."""

    @property
    def webs(self) -> tuple[Web, ...]:
        """The shear webs."""

    @property
    def closed_tip(self) -> bool:
        """Whether a plate as thick as the wall closes the tip."""

    def lines(self, s: Array) -> Array:
        """Contour fractions that bound the panels at span fractions s.

        Args:
            s: Shape (m,) [-].

        Returns:
            Shape (m, n + 1) [-], not falling along each row, from 0 to 1; equal neighbours are a
            panel of no width there.
        """

    def web_arcs(self, web: int, s: Array) -> Array:
        """Contour fractions where the middle of a web meets suction and pressure side, (m, 2)."""

    def surface(self, s: Array, a: Array) -> Array:
        """Points of the outer surface.

        Args:
            s: Span fractions [-].
            a: Contour fractions, of a shape that broadcasts with s [-].

        Returns:
            Coordinates along a1, a2, a3, one axis more than the arguments [m].
        """

    def wall(self, s: Array, a: Array) -> Array:
        """Thickness of the wall there [m]; the arguments as in `surface`."""

    def web_wall(self, web: int, s: Array) -> Array:
        """Thickness of a web, shape (m,) [m]."""

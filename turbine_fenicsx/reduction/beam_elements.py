"""Finite elements of a beam.

Nodes k stand along the axis with their position r_k and two directors d_1k, d_2k of the section.
With Lagrange functions N_k of the arc length s,

    x(xi, eta, s) = sum_k N_k(s) (r_k + xi d_1k + eta d_2k).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.lagrange import lagrange, lagrange_slopes, lobatto_rule
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.beam_line import BeamLine, unit_rows

HIGHEST_DEGREE = 5
"""Polynomial degree of beam elements."""

TURNS = 40
"""Iterations that find the section of a point; each is closer by curvature times distance."""


class Places(NamedTuple):
    """Points as places in sections.

    Attributes:
        s: Arc length, shape (N,) [m].
        xi: Along the first director, shape (N,) [m].
        eta: Along the second one.
    """

    s: Array
    xi: Array
    eta: Array


@dataclass(frozen=True, eq=False)
class BeamElements:
    """Equal finite elements along a line.

    Args:
        line: The line.
        number: How many.
        degree: p of their functions.
    """

    line: BeamLine
    number: int
    degree: int

    def __post_init__(self) -> None:
        for name, value, most in (
            ("elements", self.number, 1000),
            ("degree", self.degree, HIGHEST_DEGREE),
        ):
            if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
                raise ModelError(
                    f"{name} of a beam must be a whole number from 1 to {most}, got {value!r}"
                )

    @property
    def ends(self) -> Array:
        """Arc lengths of the ends of the elements, shape (number + 1,) [m]."""
        return np.linspace(0.0, self.line.length, self.number + 1)

    @cached_property
    def nodes(self) -> tuple[Array, Array]:
        """Points and directors of the nodes, shapes (K + 1, 3) and (K + 1, 2, 3)."""
        return self.line.at(self.node_places)

    @property
    def node_places(self) -> Array:
        """Arc lengths of the nodes, Lobatto points of each element, shape (K + 1,) [m]."""
        inner = lobatto_rule(self.degree + 1)[0][:-1]
        size = self.line.length / self.number
        places = self.ends[:-1, None] + size * inner
        return np.append(places.ravel(), self.line.length)

    @property
    def node_lengths(self) -> Array:
        """Part of the length that each node stands for, by Lobatto's rule, shape (K + 1,) [m]."""
        weights = self.line.length / self.number * lobatto_rule(self.degree + 1)[1]
        found = np.zeros(self.number * self.degree + 1)
        for e in range(self.number):
            found[self.nodes_of(e)] += weights
        return found

    def find_element(self, s: Array) -> IntArray:
        """Number of the element of arc lengths; those beyond the ends belong to the last ones."""
        inner = self.ends[1:-1]
        found: IntArray = np.searchsorted(inner, s, side="right")
        return found

    def functions(self, element: int, s: Array) -> tuple[Array, Array]:
        """N_k of the nodes of an element at arc lengths, and dN_k/ds, shape (k, p + 1) each."""
        first, last = self.ends[element], self.ends[element + 1]
        points = lobatto_rule(self.degree + 1)[0]
        N = lagrange(points, (np.asarray(s) - first) / (last - first))
        return N, N @ lagrange_slopes(points) / (last - first)

    def interpolate(self, s: Array) -> tuple[Array, Array]:
        """Points and directors of the elements at arc lengths, as of `BeamLine.at`."""
        r, d = self.nodes
        points, directors = np.zeros((len(s), 3)), np.zeros((len(s), 2, 3))
        of = self.find_element(s)
        for e in np.unique(of):
            N, _ = self.functions(int(e), s[of == e])
            own = self.nodes_of(int(e))
            points[of == e] = N @ r[own]
            directors[of == e] = np.tensordot(N, d[own], 1)
        return points, directors

    def nodes_of(self, element: int) -> slice:
        """Nodes of an element."""
        return slice(element * self.degree, (element + 1) * self.degree + 1)

    def all_functions(self, s: Array) -> Array:
        """N_k of all nodes at arc lengths, shape (k, K + 1)."""
        found, of = np.zeros((len(s), self.number * self.degree + 1)), self.find_element(s)
        for e in np.unique(of):
            found[of == e, self.nodes_of(int(e))] = self.functions(int(e), s[of == e])[0]
        return found

    def locate(self, X: Array) -> Places:
        """Sections that points lie in; points beyond an end belong to the end.

        Args:
            X: Shape (N, 3) [m].

        Raises:
            ModelError: if a point is so far from the axis that sections cross there.
        """
        fine = np.linspace(0.0, self.line.length, 8 * self.number * self.degree + 1)
        s = fine[cKDTree(self.interpolate(fine)[0]).query(X)[1]]
        step = np.zeros(len(X))
        for _ in range(TURNS):
            r, d = self.interpolate(s)
            normal = unit_rows(np.cross(d[:, 0], d[:, 1]))
            step = np.sum((X - r) * normal, axis=1)
            step = np.clip(s + step, 0.0, self.line.length) - s
            s = s + step
            if np.max(np.abs(step), initial=0.0) <= 1e-14 * self.line.length:
                break
        if np.max(np.abs(step), initial=0.0) > 1e-6 * self.line.length:
            raise ModelError("points are too far from the axis of the beam: its sections cross")
        r, d = self.interpolate(s)
        G = d @ d.swapaxes(1, 2)
        xi, eta = np.linalg.solve(G, d @ (X - r)[:, :, None])[..., 0].T
        return Places(s, xi, eta)

"""All plies of many walls in one table, with their strains, stresses and failure indices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TypeAlias

import numpy as np

from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.materials.laminate_theory import (
    Plies,
    interfaces,
    reduced_stiffness,
    strain_in_ply,
    total_thickness,
)
from turbine_fenicsx.materials.ply import Ply

Criterion: TypeAlias = Callable[["PlyTable", Array], Array]
"""Failure index of strains in ply axes, shape (n, ..., 3), for the n plies of a table."""


class PlyTable:
    """Plies of walls, one after the other, each wall from its outer to its inner face.

    Attributes:
        wall: Number of the wall of each, shape (n,).
        first: Number of the first ply of each wall, shape (walls,).
        stiffness: Plane-stress stiffness in the axes of the ply, shape (n, 3, 3) [Pa].
        tension: Strength along and across the fibre, shape (n, 2) [Pa].
        shear: Strength against shear in the ply, shape (n,) [Pa].
    """

    def __init__(self, laminates: Sequence[Plies]) -> None:
        self.plies: tuple[Ply, ...] = tuple(ply for plies in laminates for ply in plies)
        counts = np.array([len(plies) for plies in laminates], dtype=np.int64)
        self.wall = np.repeat(np.arange(len(counts)), counts)
        self.first = np.cumsum(counts) - counts
        n = len(self.plies)
        materials = [ply.material for ply in self.plies]
        self.stiffness: Array = np.array([reduced_stiffness(m) for m in materials])
        self.stiffness = self.stiffness.reshape(n, 3, 3)
        strengths = [m.strengths for m in materials]
        self.tension: Array = np.array([s.tension[:2] for s in strengths]).reshape(n, 2)
        self.compression: Array = np.array([s.compression[:2] for s in strengths]).reshape(n, 2)
        self.shear: Array = np.array([s.shear[0] for s in strengths])
        self._turn = np.array([strain_in_ply(ply.angle) for ply in self.plies]).reshape(n, 3, 3)
        # share of the strain of the outer face of the wall in that of both faces of each ply
        zeta = [interfaces(plies) / total_thickness(plies) + 0.5 for plies in laminates]
        faces = [np.stack([z[:-1], z[1:]], axis=1) for z in zeta]
        self._share = np.concatenate([np.zeros((0, 2)), *faces])

    def take(self, walls: IntArray) -> PlyTable:
        """The plies of some walls."""
        ends = [*self.first.tolist(), len(self.plies)]
        return PlyTable([self.plies[ends[k] : ends[k + 1]] for k in walls.tolist()])

    def strains(self, inner: Array, outer: Array) -> Array:
        """Strains of the plies at their outer and inner faces, in their own axes.

        Between the faces of the wall strains are linear.

        Args:
            inner: Strains 11, 22, 12 (engineering) of the inner faces of the walls in their axes,
                at p points of each, shape (walls, p, 3).

        Returns:
            Along the fibre, across it, and shear, shape (n, 2, p, 3).
        """
        share = self._share[:, :, None, None]
        e = (1.0 - share) * inner[self.wall, None] + share * outer[self.wall, None]
        return np.asarray(np.matmul(e, self._turn.transpose(0, 2, 1)[:, None]))

    def stresses(self, strains: Array) -> Array:
        """Stresses along the fibre, across it, and of shear [Pa], of the shape of the strains."""
        n = len(self.plies)
        return np.asarray(np.matmul(strains.reshape(n, -1, 3), self.stiffness)).reshape(
            strains.shape
        )

    @cached_property
    def stress_rows(self) -> Array:
        """Stresses at the outer and inner faces of the plies by the strains of their walls.

        Returns:
            Shape (n, 2, 3, 6) [Pa]: strains 11, 22, 12 of the inner face of the wall, then of the
            outer one.
        """
        stiff = self.stiffness @ self._turn  # of strains in the axes of the wall
        share = self._share[:, :, None, None]
        both = [(1.0 - share) * stiff[:, None], share * stiff[:, None]]
        return np.concatenate(both, axis=3)

    def largest(self, indices: Array) -> tuple[Array, IntArray]:
        """The largest failure index of each wall and the number of the ply where it is.

        Args:
            indices: Of all plies, shape (n, ...).

        Returns:
            Shapes (walls,); plies of a wall count from its outer face, from 0.
        """
        if not len(self.first):
            return np.zeros(0), np.zeros(0, dtype=np.int64)
        of_plies = indices.reshape(len(self.plies), -1).max(axis=1, keepdims=True)
        found, numbers = self.find_largest(of_plies)
        return found[:, 0], numbers[:, 0]

    def find_largest(self, indices: Array) -> tuple[Array, IntArray]:
        """As `largest` in m states, for indices of all plies of shape (n, m); shapes (walls, m)."""
        if not len(self.first):
            return np.zeros((0, indices.shape[1])), np.zeros((0, indices.shape[1]), dtype=np.int64)
        found: Array = np.maximum.reduceat(indices, self.first)
        n = len(indices)
        numbers = np.where(indices == found[self.wall], np.arange(n)[:, None], n)
        return found, np.minimum.reduceat(numbers, self.first) - self.first[:, None]

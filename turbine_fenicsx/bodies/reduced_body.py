"""Bodies whose motion is that of a few vectors, and what is known of such a motion beforehand."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.bodies.carrier import Carrier
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.bodies.placement import Placement
from turbine_fenicsx.foundation.argument_checks import describe
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.types import Array, IntArray

SAME_PLACE = 1e-9
"""Maximum distance of two nodes in the same place, relative to the size of the body."""


@dataclass(frozen=True, eq=False, repr=False)
class ReducedBasis:
    """Functions F_k of the reference configuration, and mass and strain energy of what they carry.

    Vectors z_k in space move the body by x(X, t) = sum_k F_k(X) z_k(t). An interface s is a surface
    that couplings hold. Its four functions are f_s and f_s (X - X_s)_j, and their vectors a point
    and three directors. The function f_s is one on its surface and zero on the others; all f_s add
    up to one. (Of a beam, the last three are such on surfaces only; a rigid motion of all
    interfaces moves it rigidly all the same.) The other functions are zero on all interfaces. A
    body without interfaces has the point and the directors all the same, with f = 1.

    `turbine_fenicsx.reduce_body` makes a basis, `turbine_fenicsx.write_basis` and
    `turbine_fenicsx.read_basis` keep it in a file. Arrays cannot be written to.

    Args:
        points: Nodes of the mesh in the reference configuration, shape (N, 3) [m].
        functions: Values of F_k at the nodes, shape (N, n).
        masses: Masses of the nodes, positive, shape (N,) [kg].
        origins: X_s of each interface, shape (S, 3) [m].
        surface_of: Interface that each node belongs to, -1 for none, shape (N,).
        mass: int rho F_k F_l dV, shape (n, n) [kg] for functions without a unit.
        strain_factor: W with the strain energy |W^T e|^2/2, where e_p are the changes of the
            scalar products of `strain_vectors`, shape (pairs, r).
        viscosity: Times Z of the viscous losses sum_r Z_r c_r'^2 of c = W^T e, shape (r,) [s];
            shape (0,) of materials without viscosity.
        cells: What the basis belongs to: a row for each cell with its middle, volume, density, and
            numbers that stand for stiffness and viscosity, shape (cells, 7); shape (0, 7) of beams.
        singular_values: Of the equilibria that functions were made of, largest first: roots of the
            energies that they had beyond the functions before them [sqrt(J)]; shape (0,) if none.
    """

    points: Array
    functions: Array
    masses: Array
    origins: Array
    surface_of: IntArray
    mass: Array
    strain_factor: Array
    viscosity: Array
    cells: Array
    singular_values: Array

    FLAT: ClassVar[tuple[str, ...]] = ("masses", "surface_of", "viscosity", "singular_values")

    def __post_init__(self) -> None:
        for field in fields(self):
            kind = np.int64 if field.name == "surface_of" else np.float64
            values = np.array(getattr(self, field.name), dtype=kind, order="C")
            if values.ndim != (1 if field.name in self.FLAT else 2):
                raise ModelError(f"{field.name} of a basis has the shape {values.shape}")
            if not np.all(np.isfinite(values)):
                raise ModelError(f"{field.name} of a basis must be finite")
            values.flags.writeable = False
            object.__setattr__(self, field.name, values)
        n, interfaces, r = self.functions.shape[1], len(self.origins), self.strain_factor.shape[1]
        if not 1 <= interfaces <= n // 4:
            raise ModelError(f"a basis of {n} functions cannot have {interfaces} interfaces")
        shapes = {
            "points": (len(self.functions), 3),
            "masses": (len(self.functions),),
            "origins": (interfaces, 3),
            "surface_of": (len(self.functions),),
            "mass": (n, n),
            "strain_factor": (n * (n - 1) // 2, r),
            "viscosity": (r if self.viscosity.size else 0,),
            "cells": (len(self.cells), 7),
        }
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ModelError(f"{name} of a basis must have the shape {shape}, got {found}")

    @property
    def size(self) -> int:
        """Number of functions besides those of the interfaces."""
        return self.functions.shape[1] - 4 * len(self.origins)

    @cached_property
    def fingerprint(self) -> str:
        """Hash of all arrays: a run resumes with an equal basis only."""
        digest = hashlib.sha256()
        for field in fields(self):
            digest.update(getattr(self, field.name).tobytes())
        return digest.hexdigest()[:16]

    def find_interface(self, points: Array) -> int | None:
        """Number of the interface whose nodes are at some points; None if there is none.

        Args:
            points: Shape (k, 3) [m].
        """
        size = float(np.max(np.ptp(self.points, axis=0)))
        for s in range(len(self.origins)):
            mine = self.points[self.surface_of == s]
            if len(mine) == len(points) > 0:
                distance, nearest = cKDTree(mine).query(points)
                alone = np.unique(nearest).size == len(mine)
                if alone and np.max(distance) <= SAME_PLACE * size:
                    return s
        return None

    def __repr__(self) -> str:
        """The sizes, as the arrays are long."""
        nodes, functions = self.functions.shape
        interfaces = len(self.origins)
        return f"ReducedBasis({nodes} nodes, {interfaces} interfaces, {functions} functions)"

    @property
    def strain_vectors(self) -> Array:
        """L with y = L z, the vectors whose scalar products make the strain, shape (n - 1, n).

        These are the directors d_j of the first interface; of each other interface s what its point
        and directors move relative to them,

            p_s - p_1 - sum_j (X_s - X_1)_j d_j,    d_sj - d_j;

        and all other vectors. A rigid motion only turns them.
        """
        return make_strain_vectors(self.functions.shape[1], self.origins)

    @property
    def is_point(self) -> Array:
        """Which of the vectors are points, 1 or 0, shape (n,)."""
        h = np.zeros(self.functions.shape[1])
        h[: 4 * len(self.origins) : 4] = 1.0
        return h

    @property
    def vectors(self) -> Array:
        """Vectors z in the reference configuration, shape (n, 3) [m, -]."""
        return make_vectors(self.functions.shape[1], self.origins)


def make_strain_vectors(n: int, origins: Array) -> Array:
    """L of `ReducedBasis.strain_vectors` for n functions, shape (n - 1, n)."""
    L = np.eye(n)[1:]
    for s in range(1, len(origins)):
        row = 4 * s - 1
        L[row, 0] = -1.0
        L[row, 1:4] = origins[0] - origins[s]
        L[row + 1 : row + 4, 1:4] = -np.eye(3)
    return L


def make_vectors(n: int, origins: Array) -> Array:
    """Vectors z of n functions in the reference configuration, shape (n, 3) [m, -]."""
    z = np.zeros((n, 3))
    for s, origin in enumerate(origins):
        z[4 * s], z[4 * s + 1 : 4 * s + 4] = origin, np.eye(3)
    return z


@dataclass(frozen=True, eq=False)
class ReducedBody(DeformableBody):
    """A flexible body that moves as the functions of a basis allow, or several equal ones.

    It takes the place of the full body in the parts of a system: couplings, gravity, forces on
    nodes and Rayleigh damping act on it, and it conserves energy and momenta as exactly.

    Args:
        name: Unique name.
        full: The body that the basis was made of, or the carrier of a beam; facets and points
            refer to its mesh.
        basis: The basis.
        placements: Where each copy stands; one copy where the mesh is by default. Couplings name
            the copy that they hold.
        velocity: Initial velocity field [m/s], a function of positions of shape (n, 3) that returns
            as many velocities; that of the first parent body, or rest, if None.
        displacement: Initial displacement [m]: such a function, or an array with those of all
            vectors, shape (copies n, 3). Of a function the basis takes the nearest displacement
            that leaves the interfaces of couplings where they are. Zero if None.

    Raises:
        ModelError: if there is no placement.
        TypeError: if a part is of the wrong kind.
    """

    name: str
    full: FlexibleBody | Carrier
    basis: ReducedBasis
    placements: Sequence[Placement] = (Placement(),)
    velocity: Callable[[Array], Array] | None = None
    displacement: Callable[[Array], Array] | Array | None = None

    def __post_init__(self) -> None:
        kinds = {"full": (FlexibleBody, Carrier), "basis": (ReducedBasis,)}
        for key, of_key in kinds.items():
            if not isinstance(getattr(self, key), of_key):
                names = " or a ".join(kind.__name__ for kind in of_key)
                raise TypeError(
                    f"{key} of {self.name!r} must be a {names}, got {describe(getattr(self, key))}"
                )
        if not self.placements:
            raise ModelError(f"placements of {self.name!r} must name one copy or more")
        for placement in self.placements:
            if not isinstance(placement, Placement):
                raise TypeError(
                    f"placements of {self.name!r} must be Placements, got {describe(placement)}"
                )
        if self.velocity is not None and not callable(self.velocity):
            raise TypeError(
                f"velocity of {self.name!r} must be a function of positions, got "
                f"{describe(self.velocity)}"
            )

    @property
    def points(self) -> Array:
        """Nodes of the mesh of each copy, shape (copies, N, 3) [m]."""
        return np.array(
            [t + self.basis.points @ R.T for R, t in map(Placement.frame, self.placements)]
        )

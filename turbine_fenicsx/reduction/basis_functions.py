"""Vector fields of a body that become functions of its basis, on rank 0.

They come in this order: static shapes between moving interfaces and modes, responses to smooth
forces, and what nonlinear equilibria have beyond these. The latter are chosen by the energy

    a . (K_xx + K_yy + K_zz) a

of a component a, with the blocks of the stiffness: an orthogonal decomposition of the components of
all states, which leaves the states their sizes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy import sparse

from turbine_fenicsx.foundation.rotations import nearest_rotation, skew_rows
from turbine_fenicsx.foundation.types import Array, IntArray
from turbine_fenicsx.reduction.gathered_body import WholeBody
from turbine_fenicsx.reduction.interfaces import make_interface_functions
from turbine_fenicsx.reduction.long_axis import LongAxis
from turbine_fenicsx.reduction.vector_fields import HeldBody


class Orthonormal:
    """Functions that are orthogonal to each other in the mass, with the mass of the body.

    Args:
        mass: int rho N_a N_b dV, shape (N, N) [kg].
        apart: Functions that others must be orthogonal to, shape (N, k).
    """

    def __init__(self, mass: sparse.csr_matrix, apart: Array) -> None:
        self._mass, self._scale = mass, float(np.sqrt(mass.sum()))
        self._all: list[Array] = []
        self._apart = 0
        for f in apart.T:
            self._append(f, 0.0)
        self._apart = len(self._all)

    def __len__(self) -> int:
        """Number of functions."""
        return len(self._all) - self._apart

    @property
    def functions(self) -> Array:
        """The functions, shape (N, k)."""
        rows = self._all[self._apart :]
        return self._scale * np.array(rows).T.reshape(self._mass.shape[0], len(rows))

    def coordinates(self, fields: Array) -> Array:
        """Vectors a_k of the nearest fields sum_k psi_k a_k, shape (..., k, 3).

        Args:
            fields: Shape (..., N, 3).
        """
        weighted = self._mass @ self.functions / self._scale**2
        found: Array = weighted.T @ fields
        return found

    def add(self, fields: Iterable[Array], negligible: float, most: int) -> None:
        """Add the components of fields as far as they are new, until there are enough.

        Args:
            fields: Shape (N, k) each, with any number of components.
            negligible: Part of a field that counts as zero, in the norm of the mass.
            most: Number of functions that is enough.
        """
        for field in fields:
            size = float(np.sqrt(np.sum(field * (self._mass @ field))))
            for component in field.T:
                if len(self) < most:
                    self._append(component, negligible * size)

    def _append(self, f: Array, least: float) -> None:
        """Append a function if what is new of it is not negligible."""
        for _ in range(2):  # twice is enough
            for known in self._all:
                f = f - (known @ (self._mass @ f)) * known
        norm = float(np.sqrt(f @ (self._mass @ f)))
        if norm > least:
            self._all.append(f / norm)


NEGLIGIBLE = {"exact": 1e-9, "responses": 1e-3, "states": 1e-6}
"""Part of a field that a component must add to become a function, in the norm of masses."""

RESPONSES = 5.0 / 8.0
"""Part of all functions that modes and responses make up before states are looked at."""

LEAST = 4
"""Minimum number of responses beside modes."""

Turn = Callable[[Array, Array], Array]
"""Increments of three directors, as rows, from arms of nodes and their increments, (k, 3) each."""


class BasisFunctions:
    """Functions of a body as they are added.

    Args:
        origins: X_s, shape (S, 3) [m].
        count: Number of functions wanted.

    Attributes:
        origins: X_s, shape (S, 3) [m].
        positions: X of all nodes, shape (N, 3) [m].
    """

    def __init__(
        self, whole: WholeBody, surfaces: Sequence[IntArray], origins: Array, count: int
    ) -> None:
        self._whole, self._surfaces, self.origins = whole, surfaces, origins
        self.positions, self._count = whole.positions, count
        self._left: list[Array] = []
        self.singular_values: Array = np.zeros(0)

    def add_linear(self, modes: int, all_of_them: bool) -> None:
        """Add static shapes, modes, and the first responses.

        Args:
            modes: Number of modes.
            all_of_them: Whether responses make up all the rest.
        """
        whole, surfaces = self._whole, self._surfaces
        self.interface = make_interface_functions(whole, surfaces, self.origins)
        # functions of a free body are none of what its point and directors do already
        nothing = np.zeros_like(self.interface[:, :0])
        self._known = Orthonormal(whole.mass, nothing if surfaces else self.interface)
        axis = LongAxis(whole.positions, np.abs(whole.mass.diagonal()), self.origins[0])
        held = HeldBody(whole, surfaces, self.origins, axis)
        try:
            exact = [self._subtract_rigid(u, _turn_little)[0] for u in held.follow_interfaces()]
            exact = [u for u in exact if np.any(u)]
            squares, shapes = held.modes(modes)
            exact += list(shapes)
            left = max(self._count - 3 * len(exact), 0)
            responses = held.responses(left, squares, shapes) if left else []
        finally:
            held.destroy()
        self._known.add(exact, NEGLIGIBLE["exact"], self._count)
        vectors = round(RESPONSES * self._count / 3.0)
        first = max(vectors - len(exact), LEAST)
        self._left = [] if all_of_them else responses[first:]
        self._add(responses if all_of_them else responses[:first])

    def add_states(self, states: Array) -> None:
        """Add what states have beyond all that is there, and then further responses.

        Args:
            states: Displacements, shape (states, N, 3) [m].
        """
        whole = self._whole
        moved = [self._subtract_rigid(u, _turn_far)[0] for u in states]
        psi, beyond = self._known.functions, []
        for u in moved:
            beyond.append(u - psi @ self._known.coordinates(u))
        R = np.concatenate([np.zeros((len(psi), 0)), *beyond], axis=1)
        energy = sum(whole.stiffness[i::3, i::3] for i in range(3))
        squares, weights = np.linalg.eigh(R.T @ (energy @ R))
        order = np.argsort(squares)[::-1]
        self.singular_values = np.sqrt(np.maximum(squares[order], 0.0))
        fields = [R @ weights[:, k : k + 1] for k in order[: self._count]]
        self._known.add(fields, NEGLIGIBLE["states"], self._count)
        self._add(self._left)

    def _add(self, responses: Sequence[Array]) -> None:
        """Add responses."""
        self._known.add(responses, NEGLIGIBLE["responses"], self._count)

    def coordinates(self, u: Array) -> Array:
        """Increments of the vectors z_k that come nearest to a displacement, shape (n, 3)."""
        rest, z = self._subtract_rigid(u, _turn_far)
        found: Array = np.concatenate([z, self._known.coordinates(rest)])
        return found

    def collect(self) -> dict[str, Any]:
        """Attributes of `ReducedBasis` that do not depend on the stiffness."""
        F, mass = self.functions, self._whole.mass
        surface_of = np.full(len(F), -1)
        for s, nodes in enumerate(self._surfaces):
            surface_of[nodes] = s
        return {
            "points": self.positions,
            "functions": F,
            "masses": mass.diagonal(),
            "origins": self.origins,
            "surface_of": surface_of,
            "mass": np.asarray(F.T @ (mass @ F)),
            "singular_values": self.singular_values,
        }

    @property
    def functions(self) -> Array:
        """Values of all functions at the nodes, shape (N, n)."""
        return np.concatenate([self.interface, self._known.functions], axis=1)

    def _subtract_rigid(self, u: Array, turn: Turn) -> tuple[Array, Array]:
        """A field less what rigid interfaces make of it, and the increments of their vectors.

        Args:
            u: The field, shape (N, 3).

        Returns:
            Shapes (N, 3), zero if nothing but round-off is left, and (4 S, 3).
        """
        z = np.zeros((self.interface.shape[1], 3))
        X = self._whole.positions
        for s, nodes in enumerate(self._surfaces):
            arms, moved = (x - x.mean(axis=0) for x in (X[nodes], u[nodes]))
            D = turn(arms, moved)  # rows are increments of directors
            z[4 * s + 1 : 4 * s + 4] = D
            z[4 * s] = np.mean(u[nodes] - (X[nodes] - self.origins[s]) @ D, axis=0)
        rest = u - self.interface @ z
        for nodes in self._surfaces:
            rest[nodes] = 0.0
        small = np.linalg.norm(rest) <= NEGLIGIBLE["exact"] * np.linalg.norm(u)
        return np.zeros_like(rest) if small else rest, z


def _turn_little(arms: Array, moved: Array) -> Array:
    """Increments w x e_j of directors in a small rotation that is nearest to a motion."""
    A = -skew_rows(arms).reshape(-1, 3)  # w x arm = A w
    w = np.linalg.lstsq(A, moved.ravel(), rcond=1e-9)[0]
    return np.cross(w, np.eye(3))


def _turn_far(arms: Array, moved: Array) -> Array:
    """Increments R e_j - e_j of directors in a rotation that is nearest to a motion."""
    R = nearest_rotation((arms + moved).T @ arms)
    return np.asarray(R.T - np.eye(3))

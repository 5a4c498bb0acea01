"""Flat vectors of a system that turns: values turned back, S and J of them, S' = S - Omega J.

Joint coordinates have no mass, and are zero in what is made here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from turbine_fenicsx.analysis.cyclic_shift import CyclicShift
from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.types import Array


class TurningVectors:
    """Operations on values of bodies, this rank's part.

    Args:
        frame: What turns, about which axis and how fast.
        shift: The cyclic shift of multiblade coordinates; None for those that turn.
    """

    def __init__(self, frame: TurningFrame, shift: CyclicShift | None) -> None:
        self._frame, self._shift = frame, shift
        sizes = [3 * m.n_owned for m in frame.system.flexible_models]
        self._ends = np.cumsum(sizes, dtype=int)

    def flatten(self, fields: Sequence[Array], q: Array) -> Array:
        """Values of flexible bodies, shape (3 n,) each, and of rigid ones, shape (n_q,)."""
        system = self._frame.system
        of_rigid = [q, np.zeros(system.rigid_model.n_T)] if system.comm.rank == 0 else []
        return np.concatenate([np.zeros(0), *fields, *of_rigid])

    def turn_back(self, fields: Sequence[Array], q: Array, angle: float) -> Array:
        """R^T of values in space: how they look to what turns; arguments as of `flatten`."""
        return self._apply(rotation_about(self._frame.axis, -angle), fields, q, False)

    def find_velocities(self, X: Array) -> Array:
        """S' X, velocities in space of motions that do not change in multiblade coordinates.

        Args:
            X: In columns, shape (local_size, m).
        """
        speed = self._frame.speed
        columns = [self.spin(x) - speed * self.generate(x) for x in X.T]
        return np.array(columns).reshape(X.T.shape).T

    def spin(self, values: Array) -> Array:
        """S of values of what turns, zero for the rest."""
        *fields, rigid = np.split(values, self._ends)
        return self._apply(self._frame.spin, fields, self._take(rigid), True)

    def generate(self, values: Array) -> Array:
        """J of values; zero without multiblade coordinates."""
        if self._shift is None:
            return 0.0 * values
        *fields, rigid = np.split(values, self._ends)
        found = []
        for u, J in zip(fields, self._shift.body_generators, strict=True):
            image = 0.0 * u
            if J is not None:
                x, y = J.createVecs()
                x.array[:] = u
                J.mult(x, y)
                image = y.array_r.copy()
                x.destroy()
                y.destroy()
            found.append(image)
        return self.flatten(found, self._shift.rigid_generator @ self._take(rigid))

    def _apply(self, matrix: Array, fields: Sequence[Array], q: Array, only: bool) -> Array:
        """A matrix of shape (3, 3) on all vectors of what turns; the rest is kept, or zero."""
        frame = self._frame
        factor = 0.0 if only else 1.0
        turned = [
            (u.reshape(-1, 3) @ matrix.T).ravel() if turns else factor * u
            for u, turns in zip(fields, frame.flexible_turns, strict=True)
        ]
        rigid = q.reshape(-1, 4, 3)
        turns = frame.rigid_turns[:, None, None]
        return self.flatten(turned, np.where(turns, rigid @ matrix.T, factor * rigid).ravel())

    def _take(self, rigid: Array) -> Array:
        """q; zeros on other ranks, where it does not count."""
        n_q = self._frame.system.rigid_model.n_q
        return rigid[:n_q] if rigid.size else np.zeros(n_q)

"""A controller of the speed of a rotor as a linear system, closed around motions and air.

With small changes of its states x, of the generator's speed w, and of its outputs, the torque T
that brakes the generator, the pitch theta and its rate,

    x' = A x + B w,    (T | theta | theta') = C x.

Pitch is a motion p that the drives prescribe, a column beside the others in X, normal to them in
the mass matrix. The equations of motion keep their test functions and lose its own row,

    (a | theta | a' | theta' | zeta) = P (a | a' | zeta | x),    w = n . (a' | theta'),

and the torque adds -n T to them, where n = X^T e holds the factors e of joint coordinates in the
angle of the generator.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array


@dataclass(frozen=True, eq=False)
class Feedback:
    """A controller with its drives about a steady state.

    Args:
        generator: Factors of joint coordinates in the angle of the generator.
        pitch: Joints that a change of the pitch turns, and the angle of each for 1 rad of it.
        A: Rates of the k states by states, shape (k, k) [1/s].
        B: Rates of the states by the speed of the generator, shape (k,).
        C: Torque [N m], pitch [rad] and rate of the pitch [rad/s] by states, shape (3, k).
    """

    generator: Mapping[str, float]
    pitch: Mapping[str, float]
    A: Array
    B: Array
    C: Array

    def close(self, matrix: Array, along: Array) -> Array:
        """The matrix of first order with the states of the controller.

        Args:
            matrix: That of m motions, the last of which is the pitch, their rates, and the air.
            along: n, shape (m,).

        Returns:
            The matrix of m - 1 motions, their rates, air and controller.
        """
        m, k = len(along), len(self.A)
        kept = keep_free(len(matrix), m)
        P = np.zeros((len(matrix), len(kept) + k))
        P[kept, np.arange(len(kept))] = 1.0
        P[[m - 1, 2 * m - 1], -k:] = self.C[1:]
        closed = np.zeros((len(kept) + k,) * 2)
        closed[:-k] = matrix[kept] @ P
        closed[m - 1 : 2 * m - 2, -k:] -= np.outer(along[:-1], self.C[0])
        closed[-k:] = np.outer(self.B, along @ P[m : 2 * m])
        closed[-k:, -k:] += self.A
        return closed

    def find_pitch(self, states: Array) -> Array:
        """Theta of states, shape (k, n)."""
        return np.asarray(self.C[1] @ states)


def keep_free(size: int, m: int) -> Array:
    """Numbers of what is left without the last of m motions and its rate."""
    return np.delete(np.arange(size), [m - 1, 2 * m - 1])

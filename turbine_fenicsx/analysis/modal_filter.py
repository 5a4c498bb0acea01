"""How much of a mode is in a run: the product of its left vector with motions and velocities.

R turns by psi = Omega t. In multiblade coordinates displacements u in space are exp(psi J) R^T u,
and velocities v in space have the rates z' = exp(psi J) R^T v - S' z. Here
exp(psi J) = 1 + sin(psi) J + (1 - cos(psi)) J^2. The left vector l of the eigenvalue s is normal to
all other modes, so that with the motions a = X^T M z

    q = l* . (a | a' | zeta),    q' = s q,

with states zeta of the air in multiblade coordinates too. J and S' are skew and commute: so they
act on l, once, and not on the motions of each step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from turbine_fenicsx.analysis.cyclic_shift import CyclicShift
from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.analysis.turning_vectors import TurningVectors
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.state import State

NEAR = 1e-9
"""Distance of a shift from an eigenvalue, relative to it."""

SOLUTIONS = 3
"""Of inverse iteration; each gains nine digits."""


def find_left_vector(A: Array, s: complex) -> Array:
    """The vector l of l* A = s l*, of unit length."""
    factors = lu_factor(A.astype(complex) - (1.0 + NEAR) * s * np.eye(len(A)))
    found: Array = np.ones(len(A), dtype=complex)
    for _ in range(SOLUTIONS):
        found = lu_solve(factors, found, trans=2)
        found /= np.linalg.norm(found)
    return found


class ModalFilter:
    """Measures q of the states of a run.

    Args:
        frame: What turns, about which axis and how fast.
        shift: The cyclic shift of multiblade coordinates; None for those that turn.
        of_motions: M X l of motions, complex, this rank's rows.
        of_rates: The same of velocities.
        of_states: For the loads on each body their whirl, shape (k, k) [1/s], and l of the states,
            shape (k,), as of `AirTerms`.
    """

    def __init__(
        self,
        frame: TurningFrame,
        shift: CyclicShift | None,
        of_motions: Array,
        of_rates: Array,
        of_states: Sequence[tuple[Array, Array]],
    ) -> None:
        self._frame, self._vectors = frame, TurningVectors(frame, shift)
        J = partial(_act, self._vectors.generate)
        turned = _act(lambda x: self._vectors.find_velocities(x[:, None])[:, 0], of_rates)
        self._of_motions, self._of_rates = (
            np.stack([w, -J(w), J(J(w))]) for w in (of_motions + turned, of_rates)
        )
        self._of_states = []
        for whirl, w in of_states:
            J_T = whirl.T / frame.speed if frame.speed else 0.0 * whirl
            self._of_states.append(np.stack([w, J_T @ w, J_T @ (J_T @ w)]))

    def measure(self, state: State) -> complex:
        """q, with a part that depends on the azimuth but not on the motion. Collective.

        Of two runs that start at the same azimuth the difference has none.
        """
        psi = self._frame.speed * state.time
        exponential = np.array([1.0, np.sin(psi), 1.0 - np.cos(psi)])
        u = self._vectors.turn_back([x.array_r for x in state.u], state.q, psi)
        v = self._vectors.turn_back([x.array_r for x in state.v], state.q_dot, psi)
        parts = self._of_motions.conj() @ u + self._of_rates.conj() @ v
        q = sum_over_ranks(self._frame.system.comm, parts)
        for rows, states in zip(self._of_states, self._read_states(state), strict=True):
            q = q + rows.conj() @ states
        return complex(exponential @ q)

    def _read_states(self, state: State) -> Iterator[Array]:
        """States of each of the loads, shape (k,). Collective."""
        for model, u, v in zip(self._frame.system.flexible_models, state.u, state.v, strict=True):
            for loads in model.section_loads:
                states = loads.read_states()
                if states is None:
                    motion = loads.find_motion(u.array_r, v.array_r)
                    states = loads.states.balance(motion, state.time)
                yield states.ravel()


def _act(function: Callable[[Array], Array], w: Array) -> Array:
    """A real function of a complex vector."""
    return function(w.real) + 1j * function(w.imag)

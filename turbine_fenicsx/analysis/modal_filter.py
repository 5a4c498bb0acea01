"""How much of a mode is in a run: the product of its left vector with motions and velocities.

R turns by Omega t. Displacements u in space are z = exp(Omega t J) R^T u in multiblade coordinates,
and velocities v in space have the rates z' = exp(Omega t J) R^T v - S' z. Here
exp(psi J) = 1 + sin(psi) J + (1 - cos(psi)) J^2. The left vector l of the eigenvalue s is normal to
all other modes, so that with the motions a = X^T M z

    q = l* . (a | a' | zeta),    q' = s q,

with states zeta of the air in multiblade coordinates too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
        self._of_motions, self._of_rates, self._of_states = of_motions, of_rates, of_states

    def measure(self, state: State) -> complex:
        """q, with a part that depends on the azimuth but not on the motion. Collective.

        Of two runs that start at the same azimuth the difference has none.
        """
        vectors, angle = self._vectors, self._frame.speed * state.time
        z = vectors.see([u.array_r for u in state.u], state.q, angle)
        rates = vectors.see([v.array_r for v in state.v], state.q_dot, angle)
        rates = rates - vectors.spin(z) + self._frame.speed * vectors.generate(z)
        q = self._of_motions.conj() @ z + self._of_rates.conj() @ rates
        of_air = sum(
            part.conj() @ (zeta + np.sin(angle) * once + (1.0 - np.cos(angle)) * (J @ once))
            for part, zeta, J, once in self._read_states(state)
        )
        return complex(sum_over_ranks(self._frame.system.comm, np.array([q]))[0] + of_air)

    def _read_states(self, state: State) -> Iterator[tuple[Array, Array, Array, Array]]:
        """l, states, J and J times the states of each of the loads. Collective."""
        system = self._frame.system
        bound = [
            (loads, u, v)
            for model, u, v in zip(system.flexible_models, state.u, state.v, strict=True)
            for loads in model.section_loads
        ]
        for (loads, u, v), (whirl, part) in zip(bound, self._of_states, strict=True):
            states = loads.read_states()
            if states is None:
                motion = loads.find_motion(u.array_r, v.array_r)
                states = loads.states.balance(motion, state.time)
            J = whirl / self._frame.speed
            yield part, states.ravel(), J, J @ states.ravel()

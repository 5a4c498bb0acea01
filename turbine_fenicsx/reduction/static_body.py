"""A body under static loads, held as the couplings of a system hold it."""

from __future__ import annotations

from typing import Any

import numpy as np

from turbine_fenicsx.analysis.statics import EquilibriumBlocks, at_rest, solve_load_step
from turbine_fenicsx.bodies.coupling import Coupling
from turbine_fenicsx.bodies.deformable_body import DeformableBody
from turbine_fenicsx.bodies.rigid_body import RigidBody
from turbine_fenicsx.foundation.errors import ModelError, StepFailure
from turbine_fenicsx.foundation.parallel import sum_over_ranks
from turbine_fenicsx.foundation.threads import one_thread
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.linear_solvers.elimination import Elimination
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

TOLERANCE = 1e-4
"""Last increment of Newton's method, relative to the displacements; the error is its square."""

ITERATIONS = 9
"""Maximum number of iterations of a load step."""

MAX_GROWING_INCREMENT = 0.5
"""Maximum part of the displacements that an increment may have while it grows."""

LIGHT = 1e-6
"""Mass [kg] and moments of inertia [kg m^2] of the rigid bodies that other surfaces move with."""


class StaticBody:
    """A body, its equilibria, and its linear response at rest.

    The ground holds the surfaces that it holds in the system, and else the first one. All others
    move with rigid bodies without weight.

    Args:
        held: A system with all couplings of the body.
        original: The body of these couplings.
        body: The body itself, or the one that takes its place.
        forces: Forces on it.

    Attributes:
        system: The system of the body alone.
        model: Its model.
        state: The equilibrium of `solve`.
        factors: Number of tangents that were factorised.

    Note:
        Collective, like all methods.
    """

    def __init__(
        self,
        held: MultibodySystem,
        original: DeformableBody,
        body: DeformableBody,
        forces: Any = (),
    ) -> None:
        self.system = _hold(held, original, body, forces)
        (self.model,) = self.system.flexible_models
        self.state = self._start()
        self._blocks = _LoadedBlocks(self.system, self.state)
        self._is_factor_of_rest = False
        self._solver = Elimination(self._blocks, "static_", self._blocks.is_symmetric)

    @property
    def factors(self) -> int:
        """Number of tangents that were factorised."""
        return self._blocks.tangents_made

    def solve(self, time: float, load: Array | None = None) -> bool:
        """Find the equilibrium from `state` on, which stays as it is if there is none.

        Args:
            time: Time of the forces [s].
            load: Further forces on the owned nodes, shape (3 n_owned,) [N].

        Returns:
            Whether it was found.
        """
        self._blocks.load, before = load, self.state.copy()
        self._is_factor_of_rest = False
        try:
            with one_thread():
                solve_load_step(
                    self._blocks,
                    self._solver,
                    time,
                    TOLERANCE,
                    ITERATIONS,
                    astray=MAX_GROWING_INCREMENT,
                )
        except StepFailure:
            self.restore(before)
            return False
        before.destroy()
        return True

    def restore(self, state: State) -> None:
        """Take a state, and free the present one."""
        self.state.destroy()
        self.state = self._blocks.state = state

    def respond(self, loads: list[Array]) -> list[Array]:
        """Linear displacements of the body at rest under forces on the owned nodes.

        Args:
            loads: Forces, shape (3 n_owned,) [N] each.

        Returns:
            Displacements of the owned nodes, of the same shape [m].
        """
        blocks, found = self._blocks, []
        self.relax()
        for load in loads:
            blocks.residual_vector.set(0.0)
            blocks.split(blocks.residual_vector)[0][0].array[:] = load
            with one_thread():
                blocks.solve(self._solver, update=not self._is_factor_of_rest)
            self._is_factor_of_rest = True
            found.append(blocks.split(blocks.correction)[0][0].array_r.copy())
        return found

    def _start(self) -> State:
        """The undeformed body."""
        state = at_rest(self.system, None)
        for u in state.u:
            u.set(0.0)
        return state

    def displacement(self) -> Array:
        """Displacements of the owned nodes, shape (3 n_owned,) [m]."""
        values: Array = self.state.u[0].array_r.copy()
        return values

    def relax(self) -> None:
        """Go back to the undeformed body."""
        self.restore(self._start())

    def find_ground(self) -> Array:
        """Middle of the nodes that the ground holds, shape (3,) [m]; one node if it holds none."""
        X, on_ground = self.model.positions, [c for c in self.system.couplings if c.rigid is None]
        nodes = [self.model.contact_nodes(c) for c in on_ground]
        held = self.gather(X[np.concatenate([np.zeros(0, np.int64), *nodes])])
        middle: Array = held.mean(axis=0) if len(held) else self.gather(X)[0]
        return middle

    def gather(self, values: Array) -> Array:
        """Values of all nodes in the order of their numbers, shape (N, 3)."""
        found: Array = np.concatenate(self.system.comm.allgather(values.reshape(-1, 3)))
        return found

    def take_own(self, values: Array) -> Array:
        """Values of the owned nodes, shape (3 n_owned,), of those of all nodes, shape (N, 3)."""
        n = self.model.n_owned
        first = self.system.comm.scan(n) - n
        own: Array = values[first : first + n].ravel()
        return own

    def multiply(self, a: Array, b: Array) -> float:
        """Sum of the products of values of the owned nodes, shape (3 n_owned,) each."""
        return float(sum_over_ranks(self.system.comm, np.array([a @ b]))[0])

    def forces_at_rest(self, time: float) -> Array:
        """Applied forces on the owned nodes of the undeformed body, shape (3 n_owned,) [N]."""
        return -self.find_forces(np.zeros((self.model.size_global, 3)), time)

    def find_forces(self, displacements: Array, time: float = 0.0) -> Array:
        """Forces that the owned nodes lack for equilibrium, shape (3 n_owned,) [N].

        Args:
            displacements: Of all nodes, shape (N, 3) [m].
            time: Time of the applied forces [s].
        """
        u, out = self.model.new_vector(), self.model.new_vector()
        u.array[:] = self.take_own(displacements)
        self.model.static_forces(u, self.system.gravity, time, out)
        values: Array = out.array_r.copy()
        u.destroy()
        out.destroy()
        return values

    def destroy(self) -> None:
        """Free matrices, vectors and factors."""
        self._solver.destroy()
        self._blocks.destroy()
        self.state.destroy()


class _LoadedBlocks(EquilibriumBlocks):
    """Blocks of an equilibrium under further forces on the body.

    Attributes:
        load: The forces on the owned nodes [N]; None for none.
        tangents_made: Number of tangents so far.
    """

    load: Array | None = None
    tangents_made = 0

    def residual(self) -> None:
        """Assemble the residual at the state."""
        super().residual()
        if self.load is not None:
            self.split(self.residual_vector)[0][0].array[:] -= self.load

    def tangent(self, x: Any) -> None:
        """Assemble the tangent at the state."""
        super().tangent(x)
        self.tangents_made += 1


def check_held(system: MultibodySystem, body: DeformableBody) -> None:
    """Raise a ModelError if no coupling holds a body that is to be loaded."""
    if not any(c.flexible is body for c in system.couplings):
        raise ModelError(f"loads need a coupling that holds {body.name!r}, and there is none")


def _hold(
    held: MultibodySystem, original: DeformableBody, body: DeformableBody, forces: Any
) -> MultibodySystem:
    """The body with its couplings, on the ground and on light rigid bodies."""
    couplings = [c for c in held.couplings if c.flexible is original and c.copy == 0]
    on_ground = [c for c in couplings if c.rigid is None] or couplings[:1]
    parts: list[Any] = [body]
    for c in couplings:
        carrier = None
        if c not in on_ground:
            assert c.rigid is not None
            carrier = RigidBody(
                f"carrier of {c.name}", LIGHT, (LIGHT,) * 3, position=c.rigid.position
            )
            parts.append(carrier)
        parts.append(Coupling(c.name, body, c.facets, carrier))
    return MultibodySystem(held.comm, [*parts, *forces])

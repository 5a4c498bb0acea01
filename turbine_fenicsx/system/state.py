"""The state of a system at one time: everything that the next step depends on."""

from __future__ import annotations

from dataclasses import dataclass

from petsc4py import PETSc

from turbine_fenicsx.foundation.types import Array


@dataclass(eq=False)
class State:
    """State at t_n. Rigid parts are the same arrays on every rank, fields are distributed.

    Args:
        time: t_n [s].
        q: Coordinates of all rigid bodies, shape (12 bodies,) [m, -].
        q_dot: Their rates, shape (12 bodies,).
        joint_coordinates: Joint coordinates Theta, shape (n_T,) [rad, m].
        joint_rates: Mean rates of the last step, D/dt, shape (n_T,) [rad/s, m/s]. (Velocities of
            massless coordinates are never propagated.)
        multipliers: Multipliers of rigid and joint constraints, then of the joint coordinates, of
            the last step, at t_{n-1/2}.
        u: Displacement of each flexible body [m].
        v: Velocity of each flexible body [m/s].
        coupling: Coupling forces on the contact nodes of each flexible body at t_{n-1/2} [N].
    """

    time: float
    q: Array
    q_dot: Array
    joint_coordinates: Array
    joint_rates: Array
    multipliers: Array
    u: tuple[PETSc.Vec, ...]
    v: tuple[PETSc.Vec, ...]
    coupling: tuple[PETSc.Vec, ...]

    def __repr__(self) -> str:
        """Its time and what it is a state of."""
        nodes = [u.getSize() // 3 for u in self.u]
        flexible = f", flexible bodies of {' + '.join(map(str, nodes))} nodes" if nodes else ""
        return (
            f"State at t = {self.time:.6g} s: {self.q.size // 12} rigid bodies, "
            f"{self.joint_coordinates.size} joint coordinates{flexible}"
        )

    def copy(self) -> State:
        """An independent copy."""
        return State(
            time=self.time,
            q=self.q.copy(),
            q_dot=self.q_dot.copy(),
            joint_coordinates=self.joint_coordinates.copy(),
            joint_rates=self.joint_rates.copy(),
            multipliers=self.multipliers.copy(),
            u=tuple(x.copy() for x in self.u),
            v=tuple(x.copy() for x in self.v),
            coupling=tuple(x.copy() for x in self.coupling),
        )

    def extrapolate_from(self, before: State, factor: float = 1.0) -> None:
        """Move positions and forces on, by a factor times their difference from another state."""
        here, there = 1.0 + factor, factor
        self.q = here * self.q - there * before.q
        self.joint_coordinates = here * self.joint_coordinates - there * before.joint_coordinates
        self.multipliers = here * self.multipliers - there * before.multipliers
        for mine, other in zip(
            (*self.u, *self.coupling), (*before.u, *before.coupling), strict=True
        ):
            mine.axpby(-there, here, other)

    def destroy(self) -> None:
        """Free the distributed vectors. Collective."""
        for vector in (*self.u, *self.v, *self.coupling):
            vector.destroy()

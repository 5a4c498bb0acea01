"""Loads on the sections of a turning body as linear functions of small motions and of states.

The loads F and the rates g of their states zeta depend on positions x and velocities v in space.
In the coordinates z of `turning_modes`, of a body about its steady rotation, v = z' + S' z, so

    F = F_z z + F_v z' + F_zeta zeta,    zeta' = g_z z + g_v z' + (g_zeta + Omega J) zeta,

where F_z = F_x + F_v S', and J, which permutes the sections of the blades, takes the states to
multiblade coordinates as that of `cyclic_shift` does the motions. In the turning frame J = 0.
All derivatives are central differences: by motions through the whole chain from nodes to sections
and back, by states for all sections together, as those of one act on it alone.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from scipy.spatial import cKDTree

from turbine_fenicsx.analysis.cyclic_shift import CyclicShift, find_weight
from turbine_fenicsx.analysis.turning_frame import TurningFrame
from turbine_fenicsx.forces.section_loads import SectionMotion
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.parallel import largest_of_ranks, sum_over_ranks
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.system.bound_section_loads import BoundSectionLoads
from turbine_fenicsx.system.state import State

MOVED, SPEED = 1e-3, 1e-2
"""Largest displacement [m] and velocity [m/s] of a node in differences."""

STATE_CHANGE, LEAST_STATE = 1e-4, 1e-2
"""Changes of states in differences, relative to the largest of each kind, or to the second."""

SAME_PLACE = 1e-3
"""Maximum distance of two sections in the same place, relative to their distance from the axis."""


@dataclass(frozen=True, eq=False)
class AirTerms:
    """Derivatives of generalised forces on m motions, and of the rates of k states.

    Args:
        by_motion: F_z, shape (m, m) [1/s^2].
        by_rate: F_v, shape (m, m) [1/s].
        by_states: F_zeta, shape (m, k).
        rates_by_motion: g_z, shape (k, m).
        rates_by_rate: g_v, shape (k, m).
        rates_by_states: g_zeta, shape (k, k) [1/s].
        whirl: Omega J, shape (k, k) [1/s].
        models: The model of each state.
    """

    by_motion: Array
    by_rate: Array
    by_states: Array
    rates_by_motion: Array
    rates_by_rate: Array
    rates_by_states: Array
    whirl: Array
    models: tuple[str, ...]

    def freeze(self, models: tuple[str, ...]) -> AirTerms:
        """The same with the states of some models constant."""
        kept = np.array([name not in models for name in self.models], dtype=bool)
        return self._keep(kept, *(getattr(self, field.name) for field in fields(self)[:6]))

    def follow(self, models: tuple[str, ...]) -> AirTerms:
        """The same with the states of some models in balance at each moment."""
        kept = np.array([name not in models for name in self.models], dtype=bool)
        # 0 = g_z z + g_v z' + g_kept zeta_kept + g_gone zeta_gone, on the blades
        G = self.rates_by_states
        inverse = np.linalg.inv(G[np.ix_(~kept, ~kept)])
        by_gone, rates_by_gone = self.by_states[:, ~kept], G[:, ~kept]
        of = [-inverse @ x[~kept] for x in (self.rates_by_motion, self.rates_by_rate, G)]
        return self._keep(
            kept,
            self.by_motion + by_gone @ of[0],
            self.by_rate + by_gone @ of[1],
            self.by_states + by_gone @ of[2],
            self.rates_by_motion + rates_by_gone @ of[0],
            self.rates_by_rate + rates_by_gone @ of[1],
            G + rates_by_gone @ of[2],
        )

    def _keep(self, kept: Array, F_z: Array, F_v: Array, F_s: Array, *rates: Array) -> AirTerms:
        """Terms with some of the states."""
        g_z, g_v, g_s = (x[kept] for x in rates)
        whirl = self.whirl[np.ix_(kept, kept)]
        models = tuple(name for name, keep in zip(self.models, kept, strict=True) if keep)
        return AirTerms(F_z, F_v, F_s[:, kept], g_z, g_v, g_s[:, kept], whirl, models)


def find_air_terms(
    frame: TurningFrame,
    body: int,
    loads: BoundSectionLoads,
    state: State,
    X: Array,
    turned: Array,
    shift: CyclicShift | None,
) -> AirTerms:
    """Terms of the loads on a flexible body. Collective.

    Args:
        frame: What turns, about which axis and how fast.
        body: Number of the body.
        loads: Those on its sections.
        state: The steady state, with its velocities; states of the air are in balance.
        X: Motions of the owned nodes, shape (3 n, m).
        turned: S' X, their velocities in space.
        shift: The cyclic shift for multiblade coordinates; None for those that turn.
    """
    comm, time = frame.system.comm, state.time
    u, v = state.u[body].array_r.copy(), state.v[body].array_r.copy()
    steady = loads.find_motion(u, v)
    zeta = loads.states.balance(steady, time)
    models, n = tuple(loads.states.state_models), len(zeta)
    k = len(models)

    def differ(du: Array, dv: Array) -> tuple[Array, Array]:
        """Change of generalised forces on the motions, and of rates, by a small motion."""
        (F_1, g_1), (F_0, g_0) = (
            loads.respond(u + sign * du, v + sign * dv, time, zeta) for sign in (1.0, -1.0)
        )
        return 0.5 * (X.T @ (F_1 - F_0)), 0.5 * (g_1 - g_0).ravel()

    m = X.shape[1]
    F_z, F_v = np.zeros((m, m)), np.zeros((m, m))
    g_z, g_v = np.zeros((n * k, m)), np.zeros((n * k, m))
    for j in range(m):
        x, w = X[:, j], turned[:, j]
        h = _find_size(frame, x, MOVED), _find_size(frame, x, SPEED)
        for size, F, g, motion in (
            (h[0], F_z, g_z, (h[0] * x, h[0] * w)),
            (h[1], F_v, g_v, (0.0 * x, h[1] * x)),
        ):
            force, rates = differ(*motion)
            F[:, j], g[:, j] = force / size, rates / size
    moved = [loads.find_motion(u, x) for x in X.T]
    velocities = np.array([np.hstack([each.velocity, each.angular_velocity]) for each in moved])
    F_s, g_s = _differ_by_states(loads, steady, time, zeta)
    F_s = np.einsum("jnc,nck->jnk", velocities.reshape(m, n, 6), F_s).reshape(m, n * k)
    g_s = np.einsum("nab,nm->namb", g_s, np.eye(n)).reshape(n * k, n * k)
    whirl = np.zeros_like(g_s)
    if shift is not None and frame.flexible_turns[body]:
        C = _find_section_shift(frame, steady.position, shift.blades)
        whirl = frame.speed * np.kron(_generate(C, shift.blades), np.eye(k))
    F_z, F_v = sum_over_ranks(comm, np.stack([F_z, F_v]))
    return AirTerms(F_z, F_v, F_s, g_z, g_v, g_s, whirl, models * n)


def _find_size(frame: TurningFrame, x: Array, largest: float) -> float:
    """Factor of a motion whose largest entry then is a number."""
    entry = largest_of_ranks(frame.system.comm, float(np.max(np.abs(x), initial=0.0)))
    return largest / entry if entry else largest


def _differ_by_states(
    loads: BoundSectionLoads, motion: SectionMotion, time: float, zeta: Array
) -> tuple[Array, Array]:
    """Derivatives by the k states of each section.

    Returns:
        Of force and moment, shape (n, 6, k), and of the rates, shape (n, k, k).
    """
    n, k = zeta.shape
    largest = np.maximum(np.max(np.abs(zeta), axis=0, initial=0.0), LEAST_STATE)
    F, g = np.empty((n, 6, k)), np.empty((n, k, k))
    for kind, size in enumerate(STATE_CHANGE * largest):
        step = size * np.eye(k)[kind]
        after, before = (loads.states.respond(motion, time, zeta + x) for x in (step, -step))
        F[:, :3, kind] = (after.force - before.force) / (2.0 * size)
        F[:, 3:, kind] = (after.moment - before.moment) / (2.0 * size)
        g[:, :, kind] = (after.rates - before.rates) / (2.0 * size)
    return F, g


def _find_section_shift(frame: TurningFrame, position: Array, blades: int) -> Array:
    """C of values at sections: each comes from the section that is turned onto it, (n, n)."""
    arms = position - frame.point
    R = rotation_about(frame.axis, 2.0 * np.pi / blades)
    far, sources = cKDTree(arms).query(arms @ R)
    if np.max(far) > SAME_PLACE * np.max(np.abs(arms)):
        raise ModelError(
            f"sections with loads do not come to lie on each other when they are turned by "
            f"1/{blades} of a revolution, which multiblade coordinates need"
        )
    return np.asarray(np.eye(len(arms))[sources])


def _generate(C: Array, blades: int) -> Array:
    """J of values at sections."""
    powers = [np.linalg.matrix_power(C, j) for j in range(blades)]
    return np.asarray(sum(find_weight(j, blades) * P for j, P in enumerate(powers)))

"""Nonlinear equilibria of a body along load paths, which a basis is made of or judged by."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from turbine_fenicsx.bodies.flexible_body import FlexibleBody
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.reduction.load_path import LoadPath
from turbine_fenicsx.reduction.static_body import StaticBody, check_held
from turbine_fenicsx.system.state import State
from turbine_fenicsx.system.system import MultibodySystem

log = logging.getLogger(__name__)

HALVINGS = 3
"""Number of times that steps along a path are halved before it is given up."""

STRAIGHT = 0.8
"""Minimum cosine between two increments of the loads for which the motion is extrapolated."""


class PathStates(NamedTuple):
    """Equilibria along a path.

    Attributes:
        times: Times of the equilibria, shape (states,) [s].
        displacements: Of all nodes in the order of their numbers, shape (states, N, 3) [m].
        given_up: Whether the path ends before its last time.
    """

    name: str
    times: Array
    displacements: Array
    given_up: bool


def find_states(
    held: MultibodySystem, body: FlexibleBody, paths: Sequence[LoadPath]
) -> list[PathStates]:
    """Equilibria of a body along load paths. Collective.

    A path whose next equilibrium is not reached in short steps is given up there: thin walls snap.

    Args:
        held: A system with all couplings of the body.
    """
    if paths:
        check_held(held, body)
    found, factors = list[PathStates](), 0
    for k, path in enumerate(paths):
        loaded = StaticBody(held, body, body, path.forces)
        try:
            states = _follow(path, loaded)
            factors += loaded.factors
        finally:
            loaded.destroy()
        found.append(states)
        log.info(
            "load path %d of %d, %r: %d equilibria%s; %d factors in all",
            k + 1,
            len(paths),
            path.name,
            len(states.times),
            ", then given up" * bool(states.given_up),
            factors,
        )
    return found


def _follow(path: LoadPath, body: StaticBody) -> PathStates:
    """Equilibria along a path."""
    times, found, reached = [], [], 0.0
    way = _Way(body)
    for target in path.times:
        for time in way.approach(reached, float(target)):
            times.append(time)
            found.append(body.gather(body.displacement()))
        reached = times[-1] if times else 0.0
        if reached < target:
            break
    way.destroy()
    states = np.array(found).reshape(-1, body.model.size_global, 3)
    return PathStates(path.name, np.array(times), states, reached < path.times[-1])


class _Way:
    """The way from one equilibrium to the next."""

    def __init__(self, body: StaticBody) -> None:
        self._body = body
        self._before: State | None = None
        self._load = np.zeros(3 * body.model.n_owned)
        self._change = self._load
        self._halvings = 0

    def approach(self, start: float, target: float) -> Iterator[float]:
        """Times of equilibria on the way to a time, each as soon as it is found."""
        now, step = start, target - start
        while now < target:
            time = now + step if now + 1.001 * step < target else target
            if self._move(time):
                now = time
                yield now
            elif self._halvings < HALVINGS:
                self._halvings, step = self._halvings + 1, 0.5 * step
            else:
                return

    def _move(self, time: float) -> bool:
        """Find the next equilibrium; the motion is extrapolated as far as the loads change."""
        body = self._body
        load, here = body.forces_at_rest(time), body.state.copy()
        change = load - self._load
        factor = self._compare(change)
        if self._before is not None and factor > 0.0:
            body.state.extrapolate_from(self._before, factor)
        if not body.solve(time):
            body.restore(here)
            return False
        self.destroy()
        self._before, self._load, self._change = here, load, change
        return True

    def _compare(self, change: Array) -> float:
        """Length of a change of the loads along the last one; 0 for another direction."""
        last = self._change
        pairs = ((change, last), (change, change), (last, last))
        both, now, before = (self._body.multiply(*pair) for pair in pairs)
        straight = both > STRAIGHT * np.sqrt(now * before) > 0.0
        return float(both / before) if straight else 0.0

    def destroy(self) -> None:
        """Free the state before the present one."""
        if self._before is not None:
            self._before.destroy()

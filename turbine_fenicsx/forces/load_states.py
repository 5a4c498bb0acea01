"""Loads on sections that follow from states, whose equations are known in continuous time.

In a run a `LineLoad` moves its states on by itself, step by step. Where small motions about a
steady state are looked at, states are variables like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion
from turbine_fenicsx.foundation.types import Array


class StateResponse(NamedTuple):
    """Loads on n sections for states of the source, and how fast these change.

    Attributes:
        force: Shape (n, 3) [N].
        moment: About the centres, shape (n, 3) [N m].
        rates: Of the states, shape (n, k).
    """

    force: Array
    moment: Array
    rates: Array


@runtime_checkable
class StateLoad(LineLoad, Protocol):
    """Loads with k states at each section, which act on this section alone."""

    @property
    def state_models(self) -> Sequence[str]:
        """The model that each state belongs to, k words."""

    def balance(self, motion: SectionMotion, time: float) -> Array:
        """States after this motion has lasted for long, shape (n, k)."""

    def read_states(self) -> Array | None:
        """States after the last accepted step, shape (n, k); None before the first."""

    def respond(self, motion: SectionMotion, time: float, states: Array) -> StateResponse:
        """Loads and rates, as a function that changes nothing."""


class WithoutStates:
    """A `LineLoad` as a `StateLoad`: whatever it remembers stays as it is.

    Args:
        source: The load.
    """

    state_models: Sequence[str] = ()

    def __init__(self, source: LineLoad) -> None:
        self._source = source

    def balance(self, motion: SectionMotion, time: float) -> Array:
        """No states."""
        return np.zeros((len(motion.position), 0))

    def read_states(self) -> Array | None:
        """Nothing is known before `balance`."""
        return None

    def respond(self, motion: SectionMotion, time: float, states: Array) -> StateResponse:
        """Loads in a step without length."""
        self._source.start_step(StepTimes.from_start(time, 0.0))
        return StateResponse(*self._source.loads(motion, time), states)


def find_states(source: LineLoad) -> StateLoad | WithoutStates:
    """The states of a source, none if it knows no equations for them."""
    return source if isinstance(source, StateLoad) else WithoutStates(source)

"""States of the air at single sections: separation and shed vorticity, in steps and in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.section_air import AirState, Loads
from turbine_fenicsx.wind.shed_wake import RATES, ShedWake
from turbine_fenicsx.wind.stall import OeyeStall

STALL, SHED = "stall", "shed wake"
"""Models with states at sections."""


@dataclass(frozen=True, eq=False)
class SectionStates:
    """The models at all sections; None for those that are left out.

    Args:
        stall: How long separation takes.
        shed_wake: Vorticity that sections shed.
        chord: Shape (n,) [m].
    """

    stall: OeyeStall | None
    shed_wake: ShedWake | None
    chord: Array

    @property
    def models(self) -> tuple[str, ...]:
        """The model of each state."""
        of_shed = () if self.shed_wake is None else (SHED,) * len(RATES)
        return (*(() if self.stall is None else (STALL,)), *of_shed)

    def follow(self, state: AirState, found: Loads, dt: float) -> AirState:
        """States a step later, in flow as it is where loads were found."""
        attached, shed = state.attached, state.shed
        if self.stall is not None:
            before = found.attached if attached is None else attached
            attached = self.stall.follow(before, found.attached, dt, self.chord, found.speed)
        if self.shed_wake is not None:
            before = self.shed_wake.balance(found.across) if shed is None else shed
            shed = self.shed_wake.follow(before, found.across, dt, found.speed)
        return state._replace(attached=attached, shed=shed)

    def balance(self, found: Loads) -> Array:
        """States after loads have been so for long, shape (n, k)."""
        of_stall = [] if self.stall is None else [found.attached[:, None]]
        of_shed = [] if self.shed_wake is None else [self.shed_wake.balance(found.across)]
        return np.hstack([np.empty((len(self.chord), 0)), *of_stall, *of_shed])

    def read(self, states: Array) -> AirState:
        """States of shape (n, k) as those of the air at this moment."""
        first = 0 if self.stall is None else 1
        attached = None if self.stall is None else states[:, 0].copy()
        return AirState(attached, None if self.shed_wake is None else states[:, first:].copy(), 0.0)

    def write(self, state: AirState) -> list[Array]:
        """The reverse of `read`, as columns."""
        of_stall = [] if state.attached is None else [state.attached[:, None]]
        return of_stall if state.shed is None else [*of_stall, state.shed]

    def find_rates(self, state: AirState, found: Loads) -> Array:
        """Rates of the states that `read` gave, with loads for them, shape (n, k)."""
        rates = [np.empty((len(self.chord), 0))]
        if self.stall is not None and state.attached is not None:
            f, f_st, W = state.attached, found.attached, found.speed
            rates.append(self.stall.find_rate(f, f_st, self.chord, W)[:, None])
        if self.shed_wake is not None and state.shed is not None:
            rates.append(self.shed_wake.find_rate(state.shed, found.across, found.speed))
        return np.hstack(rates)

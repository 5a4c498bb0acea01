"""A turbine in equilibrium with a steady wind, at one wind speed after another.

The turbine is built once. Wind, speed of the rotor and pitch are set from outside, and the state is
the one in which it turns steadily, see `turbine_fenicsx.analysis.turning`. Loads of the weight and
of wind that is not the same everywhere change with the azimuth. So there is a state for each of
some azimuths within a third of a revolution, and means over them count.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.turning import turning_equilibrium
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.records.conventions import BLADES, OPENFAST_SIGNS
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import place_inflow
from turbine_fenicsx.turbine.components.brakes import Brakes
from turbine_fenicsx.turbine.components.component import Component
from turbine_fenicsx.turbine.components.model import build_turbine, list_components
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.pitch import BEARINGS
from turbine_fenicsx.turbine.components.rotor_air import WIND, RotorLoads
from turbine_fenicsx.turbine.run.start import IN_WIND, list_held, turn_blades
from turbine_fenicsx.turbine.steady.operating_states import (
    OperatingState,
    Schedule,
    find_efficiency,
)
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.settable_wind import SettableWind

log = logging.getLogger(__name__)

ACCURACY = 1e-4
"""Of the power that the pitch keeps, relative to it."""

TURNING = {**IN_WIND, "tolerance": 1e-6}
"""Accuracy of the equilibria, relative to the displacements."""

MOST = 12
"""Maximum number of equilibria for a pitch."""

LARGEST_CHANGE = np.radians(3.0)
"""Of the pitch at a time [rad]; power falls as the pitch rises."""


def prepare(case: Case) -> Case:
    """The case in steady wind without controller, whose bearings are held at any angle."""
    w = case.wind
    wind = type(w)(
        speed=10.0,
        shear=w.shear,
        direction=w.direction,
        inclination=w.inclination,
        density=w.density,
        hub_height=w.hub_height,
    )
    pitch = type(case.pitch)(
        bearings=True, ring_mass=case.pitch.ring_mass, ring_euler=case.pitch.ring_euler
    )
    new: dict[str, Any] = {
        **{name: type(getattr(case, name))() for name in ("control", "generator")},
        "wind": wind,
        "pitch": pitch,
        "event": {},
        "loads": type(case.loads)(gravity=case.loads.gravity),
        "turbine": case.turbine.model_copy(update={"rotor_speed": 1.0}),
        "time": case.time.model_copy(update={"start": "turning"}),
    }
    return case.model_copy(update=new)


class SteadyTurbine:
    """The turbine of a case in steady wind.

    Args:
        case: The case.
        comm: Communicator.
        azimuths: Number of azimuths in a third of a revolution, which the three blades share.
        locked: Names of joint coordinates that a brake holds, besides bearings.
        more: Further components.

    Attributes:
        wind: The wind.
        case: The case as it is built.
        turbine: Its turbine.
        efficiency: Electrical power over that of the air.

    Note:
        Collective.
    """

    def __init__(
        self,
        case: Case,
        comm: MPI.Intracomm,
        azimuths: int = 2,
        locked: Sequence[str] = (),
        more: Sequence[Component] = (),
    ) -> None:
        self.case, self.efficiency = prepare(case), find_efficiency(case)
        w = self.case.wind
        height = self.case.hub_height
        self.wind = SettableWind(SteadyWind(10.0, height, w.shear, w.direction, w.inclination))
        inflow = place_inflow(self.case, self.wind)
        self._pitch = 0.0
        held: dict[str, Callable[[], float]] = dict.fromkeys(locked, float)
        held |= {name: partial(self._find_bearing, name) for name in BEARINGS}
        components = [*list_components(self.case), *more, Brakes(held)]
        self.turbine = build_turbine(self.case, comm, components, inflow)
        self._air = RotorLoads(self.turbine)
        self._azimuths, self._ratio = azimuths, 1.0
        self._held = [x for x in list_held(self.case, self.turbine.system) if x not in held]

    def find(
        self, schedule: Schedule, wind: float, near: State | None = None
    ) -> tuple[OperatingState, list[State]]:
        """The operating state at a wind speed, and the equilibria there at some azimuths.

        Args:
            near: An equilibrium of another wind speed, where it is looked for first.

        Raises:
            ModelError: if the schedule has none.
            StepFailure: if there is no equilibrium, or none with the power that the pitch keeps.
        """
        operating = schedule.at(wind)
        state = self.solve(operating, near)
        power = schedule.find_power(wind)
        if power is None:
            return operating, self._turn_on(operating, state)
        slope, before = schedule.find_slope(operating), None
        for _ in range(MOST):
            # the mean power is about this part of that at the first azimuth
            excess = self._ratio * self.find_power(state, operating) - power
            at_end = excess < 0.0 and operating.pitch <= operating.least_pitch
            if at_end or abs(excess) <= ACCURACY * power:
                states = self._turn_on(operating, state)
                powers = [self.find_power(each, operating) for each in states]
                self._ratio = float(np.mean(powers)) / powers[0]
                lacking = float(np.mean(powers)) - power
                if (at_end and lacking < 0.0) or abs(lacking) <= 5.0 * ACCURACY * power:
                    return operating, states
                _destroy(states[1:])
                excess, before = lacking, None
            if before is not None:
                slope = (excess - before[1]) / (operating.pitch - before[0])
            before = operating.pitch, excess
            change = np.sign(excess) * LARGEST_CHANGE
            if slope < 0.0:
                change = np.clip(-excess / slope, -LARGEST_CHANGE, LARGEST_CHANGE)
            pitch = max(operating.pitch + float(change), operating.least_pitch)
            operating = replace(operating, pitch=pitch)
            last, state = state, self.solve(operating, state)
            last.destroy()
        state.destroy()
        raise StepFailure(
            f"no pitch keeps {1e-6 * power:g} MW in a wind of {wind:g} m/s: after "
            f"{MOST} of them power differs by {1e-6 * excess:g} MW"
        )

    def _turn_on(self, operating: OperatingState, state: State) -> list[State]:
        """An equilibrium, and those at the other azimuths."""
        system, speed, states = self.turbine.system, operating.rotor_speed, [state]
        for k in range(1, self._azimuths):
            start = state.copy()
            try:
                angle = 2.0 * np.pi * k / (len(BLADES) * self._azimuths)
                turning_frame(system, ROTOR, speed, start).turn(start, angle)
                states.append(self._solve_from(start, speed))
            except StepFailure:
                _destroy(states)
                raise
            finally:
                start.destroy()
        return states

    def solve(self, operating: OperatingState, near: State | None = None) -> State:
        """The equilibrium in an operating state.

        Args:
            near: Another equilibrium, where it is looked for first.

        Raises:
            StepFailure: if there is none.
        """
        system, speed = self.turbine.system, operating.rotor_speed
        self.wind.set_speed(operating.wind)
        self._pitch = operating.pitch
        self.turbine.part(WIND).source.speed = speed
        start = system.initial_state() if near is None else near.copy()
        try:
            turn_blades(self.case, system, start, [operating.pitch] * len(BLADES))
            if near is None:
                turning_frame(system, ROTOR, speed, start).turn(start, self.case.turbine.azimuth)
            return self._solve_from(start, speed)
        except StepFailure:
            if near is None:
                raise
            return self.solve(operating)
        finally:
            start.destroy()

    def _solve_from(self, start: State, speed: float) -> State:
        """The equilibrium at a speed of the rotor, looked for from a state."""
        return turning_equilibrium(
            self.turbine.system, ROTOR, speed, start, periodic=True, held=self._held, **TURNING
        )

    def _find_bearing(self, name: str) -> float:
        """Coordinate of a bearing at the present pitch [rad]."""
        return OPENFAST_SIGNS[name] * self._pitch

    def find_power(self, state: State, operating: OperatingState) -> float:
        """Power of the air in an equilibrium [W]."""
        return float(self._air.evaluate(state).moment[0]) * operating.rotor_speed


def _destroy(states: Sequence[State]) -> None:
    """Free states. Collective."""
    for state in states:
        state.destroy()

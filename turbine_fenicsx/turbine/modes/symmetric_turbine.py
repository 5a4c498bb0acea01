"""A turbine whose rotor is the same at every azimuth: uniform wind along its shaft, no weight."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence

from mpi4py import MPI

import numpy as np

from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import InputError, StepFailure
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.component import Component
from turbine_fenicsx.turbine.components.nacelle import ROTOR
from turbine_fenicsx.turbine.components.rotor_air import WIND
from turbine_fenicsx.turbine.steady.operating_states import OperatingState
from turbine_fenicsx.turbine.steady.steady_turbine import SteadyTurbine

log = logging.getLogger(__name__)

ALONG = 1e-7
"""Maximum angle between wind and shaft [rad]."""

FREE_POWER = 1e-3
"""Power coefficient below which a rotor turns freely."""

FIRST_RATIO = 1.0 / 14.0
"""Guess of the wind over the speed of the tips of a rotor that turns freely."""

LARGEST_RATIO = 0.5
"""Largest wind over the speed of the tips of a rotor that turns freely."""

CHANGE, NEAREST = 0.1, 0.1
"""Change of the wind at a time where a rotor that turns freely is looked for, relative to it, and
least distance from winds that were tried, relative to theirs."""

MOST_WINDS = 40
"""Maximum number of winds for a rotor that turns freely."""

MOST = 8
"""Maximum number of equilibria in which the wind follows the shaft."""


class SymmetricTurbine(SteadyTurbine):
    """The turbine of a case in uniform wind along its shaft, where the tower bends too.

    Args:
        case: The case, as `make_symmetric` gives it.
        comm: Communicator.
        locked: Names of joint coordinates that a brake holds.
        amplitude: Of the angle of attack, over which polars are averaged [rad].
        more: Further components.

    Raises:
        InputError: if the blades are not reduced or beams, or have no aerodynamics.

    Note:
        Collective.
    """

    def __init__(
        self,
        case: Case,
        comm: MPI.Intracomm,
        locked: Sequence[str] = (),
        amplitude: float = 0.0,
        more: Sequence[Component] = (),
    ) -> None:
        if not case.has_reduced_blades:
            raise InputError(
                'modes in wind need blades that move by few functions: blade.model = "reduced" '
                'or "beam"'
            )
        if case.aero.file is None and case.turbine.file is None:
            raise InputError("modes in wind need the aerodynamics of the blades: give aero.file")
        super().__init__(case, comm, azimuths=1, locked=locked, more=more)
        self._free_ratio = FIRST_RATIO
        if self.turbine.system.has_large_bodies:
            raise InputError(
                'modes in wind need a tower that moves by few functions too: tower.model = "beam" '
                'or "reduced", or tower.flexible = false'
            )
        self.turbine.part(WIND).source.source.average_polars(amplitude)

    def solve(self, operating: OperatingState, near: State | None = None) -> State:
        """The equilibrium in wind along the shaft, which follows from it."""
        state = super().solve(operating, near)
        for _ in range(MOST):
            axis = turning_frame(self.turbine.system, ROTOR, operating.rotor_speed, state).axis
            along = np.arctan2(axis[0], axis[2]), np.arcsin(np.clip(axis[1], -1.0, 1.0))
            turned = np.max(np.abs(np.subtract(along, self.wind.angles)))
            if turned <= ALONG:
                break
            self.wind.set_angles(*along)
            last, state = state, super().solve(operating, state)
            last.destroy()
        return state

    def find_free(
        self, speed: float, pitch: float, near: State | None = None
    ) -> tuple[OperatingState, State]:
        """The state in which the rotor turns freely: the wind gives it no torque.

        Args:
            speed: Of the rotor, positive [rad/s].
            pitch: Of all blades [rad].
            near: Another equilibrium, where it is looked for first.

        Raises:
            StepFailure: if there is no equilibrium, or no wind without torque.
        """
        radius = self.case.blade.hub_radius + self.case.blade.length
        wind, ends = self._free_ratio * speed * radius, dict[bool, tuple[float, float]]()
        for _ in range(MOST_WINDS):
            if wind > LARGEST_RATIO * speed * radius:
                break
            operating = OperatingState(wind, speed, pitch, pitch)
            state = self.solve(operating, near)
            power = self.find_power(state, operating)
            rated = 0.5 * self.case.wind.density * np.pi * radius**2 * wind**3
            if abs(power) <= FREE_POWER * rated:
                self._free_ratio = wind / (speed * radius)
                return operating, state
            state.destroy()
            # winds with power and without lie on both sides, then the secant comes nearer
            ends[power > 0.0] = wind, power
            if len(ends) < 2:
                wind *= 1.0 + (CHANGE if power < 0.0 else -CHANGE)
                continue
            (low, lacks), (high, excess) = ends[False], ends[True]
            part = np.clip(lacks / (lacks - excess), NEAREST, 1.0 - NEAREST)
            wind = low + float(part) * (high - low)
        raise StepFailure(
            f"no wind lets the rotor turn freely at {speed:.4g} rad/s and this pitch: "
            f"at {operating.wind:.4g} m/s it takes {-1e-6 * power:.3g} MW"
        )


def make_symmetric(case: Case) -> Case:
    """The case without weight, and without what makes its wind differ around the rotor."""
    wind, aero = case.wind, case.aero
    return case.model_copy(
        update={
            "loads": case.loads.model_copy(update={"gravity": 0.0}),
            "wind": type(wind)(
                speed=10.0, shear=0.0, density=wind.density, hub_height=wind.hub_height
            ),
            "aero": aero.model_copy(update={"skewed_wake": False, "tower_shadow": "none"}),
        }
    )


def list_left_out(case: Case) -> Iterator[str]:
    """Parts of a case that modes in wind leave out, in words of its tables."""
    w = case.wind
    if case.loads.gravity:
        yield "the weight"
    if w.blows and w.shear:
        yield "wind.shear"
    if w.has_box or w.file is not None:
        yield "turbulence"
    if w.table is not None or w.gust != "none":
        yield "changes of the wind"
    if w.direction or w.inclination or case.turbine.tilt:
        yield "yaw and tilt"
    if case.aero.tower_shadow != "none":
        yield "aero.tower_shadow"
    if case.event:
        yield "events"

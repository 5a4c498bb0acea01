"""The steady states in which a controller keeps a turbine, and its small changes there."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from turbine_fenicsx.analysis.feedback import Feedback
from turbine_fenicsx.foundation.errors import InputError, StepFailure
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.records.conventions import OPENFAST_SIGNS
from turbine_fenicsx.system.state import State
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.control import make_pi
from turbine_fenicsx.turbine.components.drivetrain import fast_shaft
from turbine_fenicsx.turbine.components.pitch import BEARINGS
from turbine_fenicsx.turbine.steady.operating_states import SLOPE, OperatingState
from turbine_fenicsx.turbine.steady.steady_turbine import ACCURACY, SteadyTurbine

SPEED_ACCURACY = 1e-5
"""Of the speed at which wind and generator balance, relative to it."""


def check_controller(case: Case) -> None:
    """Refuse a case without the built-in controller by an InputError."""
    if case.control.kind != "pi":
        raise InputError(
            'modes with a controller need one whose equations are known: control.kind = "pi", '
            f"got {quote(case.control.kind)}"
        )


class ControlledStates:
    """A turbine in steady wind whose controller has found its balance.

    From rated wind on the pitch keeps the power, below it stays at its smallest, and the speed is
    the one at which the torque of the generator is that of the wind.

    Args:
        case: A case with the built-in controller.
        rotor: Its turbine.
    """

    def __init__(self, case: Case, rotor: SteadyTurbine) -> None:
        self._controller, self._ratio = make_pi(case.control), case.drivetrain.ratio
        self._rotor, self._drive = rotor, case.pitch
        self._pitch = self._controller.pitch_law.fine

    def find(self, wind: float, near: State | None = None) -> tuple[OperatingState, State]:
        """The operating state in a wind, and its equilibrium.

        Args:
            near: An equilibrium of another wind speed, where it is looked for first.

        Raises:
            StepFailure: if there is none.
        """
        operating, (state,) = self._rotor.find(self, wind, near)
        power = self.find_power(wind)
        if self._rotor.find_power(state, operating) < (1.0 - 10.0 * ACCURACY) * power:
            operating, state = self._find_below_rated(operating, state)
        self._pitch = operating.pitch
        return operating, state

    def at(self, wind: float) -> OperatingState:
        """The operating state from rated wind on with the pitch found last; see `Schedule`."""
        law = self._controller.pitch_law
        return OperatingState(wind, law.speed / self._ratio, self._pitch, law.fine)

    def find_power(self, _: float) -> float:
        """Power that the pitch keeps [W]."""
        speed, law = self._controller.pitch_law.speed, self._controller.torque_law
        return speed * law.torque(speed)

    def find_slope(self, operating: OperatingState) -> float:
        """A guess, as of a table."""
        return SLOPE * self.find_power(operating.wind)

    def _find_below_rated(
        self, rated: OperatingState, state: State
    ) -> tuple[OperatingState, State]:
        """The state in which the generator takes all power at the smallest pitch.

        Args:
            rated: That at rated speed, where it could take more.
            state: The equilibrium there, which is freed.
        """
        fine, N = self._controller.pitch_law.fine, self._ratio
        states = {rated.rotor_speed: state}

        def take(speed: float) -> OperatingState:
            return OperatingState(rated.wind, speed, fine, fine)

        def lack(speed: float) -> float:
            if speed not in states:
                states[speed] = self._rotor.solve(take(speed), list(states.values())[-1])
            torque = self._controller.find_torque(N * speed, fine)
            return self._rotor.find_power(states[speed], take(speed)) / speed - N * torque

        ends = self._controller.torque_law.cut_in_speed / N, rated.rotor_speed
        try:
            if lack(ends[0]) <= 0.0:
                raise StepFailure(
                    f"a wind of {rated.wind:g} m/s does not turn the rotor at the speed of "
                    f"{ends[0]:.4g} rad/s from which on the controller brakes it"
                )
            found = take(float(brentq(lack, *ends, rtol=SPEED_ACCURACY)))
            # the turbine is left as the last state that it solved for
            return found, self._rotor.solve(found, list(states.values())[-1])
        finally:
            for each in states.values():
                each.destroy()

    def linearise(self, operating: OperatingState) -> Feedback:
        """The controller and the pitch drives about one of its states."""
        N, drive = self._ratio, self._drive
        A, B, C = self._controller.linearise(N * operating.rotor_speed, operating.pitch)
        # theta'' + 2 zeta w theta' + w^2 (theta - command) = 0
        w, zeta = drive.frequency, drive.damping_ratio
        rates: Array = np.zeros((4, 4))
        rates[:2, :2], rates[2, 3] = A, 1.0
        rates[3] = [*(w * w * C[1]), -w * w, -2.0 * zeta * w]
        outputs = np.zeros((3, 4))
        outputs[0, :2], outputs[1, 2], outputs[2, 3] = C[0], 1.0, 1.0
        return Feedback(
            fast_shaft(self._rotor.turbine.system, N),
            {name: float(OPENFAST_SIGNS[name]) for name in BEARINGS},
            rates,
            np.array([*B, 0.0, 0.0]),
            outputs,
        )

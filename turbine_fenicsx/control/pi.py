"""Variable speed and collective pitch by a PI controller with scheduled gains.

Jonkman et al., NREL/TP-500-38060 (2009), section 7: the generator speed w is filtered by a low pass
of first order, the torque follows from it by `TorqueLaw`, and

    theta = G(theta) (K_P e + K_I int e dt),    e = w - w_ref,    G(theta) = 1/(1 + theta/theta_K).

The integral stops where theta meets its limits. Small changes about a steady state in which the
pitch is within them and e = 0 follow, as G depends on theta, with g = G/(1 + G theta/theta_K):

    w_f' = omega (w - w_f),    I' = w_f,    T = T'(w_f) w_f,    theta = g (K_P w_f + K_I I).

At a limit the pitch stays there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp

import numpy as np

from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.control.torque_law import TorqueLaw
from turbine_fenicsx.foundation.argument_checks import (
    check_not_negative,
    check_number,
    check_positive,
)
from turbine_fenicsx.foundation.errors import ModelError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array

SPEED_CHANGE = 1e-4
"""Change of the speed for the slope of the torque, relative to it."""


@dataclass(frozen=True)
class PitchLaw:
    """Gains and limits of the pitch; defaults are those of the NREL 5 MW turbine.

    Args:
        speed: w_ref, kept by the pitch [rad/s].
        proportional_gain: K_P [s].
        integral_gain: K_I [-].
        gain_angle: theta_K, where the gains are half of those at zero [rad].
        fine: Smallest pitch, that below rated power [rad].
        largest: Largest pitch [rad].
        rate: Largest rate [rad/s].
        rated_margin: Power is kept constant from this pitch above the fine one on [rad].
    """

    speed: float = 122.9096
    proportional_gain: float = 0.01882681
    integral_gain: float = 0.008068634
    gain_angle: float = 0.1099965
    fine: float = 0.0
    largest: float = 1.570796
    rate: float = 0.1396263
    rated_margin: float = 0.01745329

    def __post_init__(self) -> None:
        for name in ("speed", "integral_gain", "gain_angle", "rate"):
            check_positive(f"{name.replace('_', ' ')} of the pitch law", getattr(self, name))
        check_not_negative("proportional gain of the pitch law", self.proportional_gain)
        check_not_negative("rated margin of the pitch law", self.rated_margin)
        check_number("fine pitch of the pitch law", self.fine)
        if not self.fine < check_number("largest pitch of the pitch law", self.largest):
            raise ModelError(
                f"largest pitch of the pitch law must be above the fine pitch {self.fine:g} rad, "
                f"got {self.largest:g} rad"
            )

    def keeps_power(self, theta: float) -> bool:
        """Whether the generator keeps its power at this pitch, whatever its speed."""
        return theta >= self.fine + self.rated_margin

    def schedule(self, theta: float) -> float:
        """The factor G of both gains."""
        return 1.0 / (1.0 + max(theta - self.fine, 0.0) / self.gain_angle)


@dataclass(eq=False)
class PIController:
    """The controller.

    Args:
        torque_law: Torque over speed.
        pitch_law: Gains and limits of the pitch.
        filter_frequency: Corner of the low pass of the generator speed [rad/s].
        torque_rate: Largest rate of the torque [N m/s].
    """

    torque_law: TorqueLaw = field(default_factory=TorqueLaw)
    pitch_law: PitchLaw = field(default_factory=PitchLaw)
    filter_frequency: float = 1.570796
    torque_rate: float = 15000.0
    _filtered: float = 0.0
    _integral: float = 0.0
    _theta: float = 0.0
    _torque: float = 0.0

    def __post_init__(self) -> None:
        check_positive("filter frequency of the controller", self.filter_frequency)
        check_positive("torque rate of the controller", self.torque_rate)

    def command(self, measured: Measurements) -> Commands:
        """Torque by the law, pitch by PI; see the head of this file."""
        pitch, dt = self.pitch_law, measured.dt
        if measured.first:
            self._start(measured)
        else:
            memory = exp(-self.filter_frequency * dt)
            self._filtered += (1.0 - memory) * (measured.generator_speed - self._filtered)
            e = self._filtered - pitch.speed
            G = pitch.schedule(self._theta)
            # theta = G (K_P e + K_I int e dt), within its limits
            K_P, K_I = G * pitch.proportional_gain, G * pitch.integral_gain
            integral = self._integral + e * dt
            self._integral = min(max(integral, pitch.fine / K_I), pitch.largest / K_I)
            wanted = min(max(K_P * e + K_I * self._integral, pitch.fine), pitch.largest)
            self._theta = approach(self._theta, wanted, pitch.rate * dt)
            wanted = self.find_torque(self._filtered, self._theta)
            self._torque = approach(self._torque, wanted, self.torque_rate * dt)
        return Commands(self._torque, (self._theta, self._theta, self._theta))

    def find_torque(self, speed: float, theta: float) -> float:
        """The torque of a generator speed and a pitch that have lasted for long [N m]."""
        return self.torque_law.torque(speed, self.pitch_law.keeps_power(theta))

    def linearise(self, speed: float, theta: float) -> tuple[Array, Array, Array]:
        """Small changes about a steady state; see the head of this file.

        Args:
            speed: Of the generator [rad/s].
            theta: The pitch; at its limits, or where it keeps the speed w_ref [rad].

        Returns:
            For the states (w_f | I) their rates by states, shape (2, 2), and by the speed, shape
            (2,), and the outputs (T | theta) by states, shape (2, 2).
        """
        pitch, omega = self.pitch_law, self.filter_frequency
        step = SPEED_CHANGE * speed
        above, below = (self.find_torque(speed + x, theta) for x in (step, -step))
        G = pitch.schedule(theta)
        g = G / (1.0 + G * theta / pitch.gain_angle)
        g *= pitch.fine < theta < pitch.largest
        A = np.array([[-omega, 0.0], [1.0, 0.0]])
        gains = [g * pitch.proportional_gain, g * pitch.integral_gain]
        C = np.array([[(above - below) / (2.0 * step), 0.0], gains])
        return A, np.array([omega, 0.0]), C

    def _start(self, measured: Measurements) -> None:
        """Begin as if the present pitch had been commanded for long."""
        pitch = self.pitch_law
        mean = sum(measured.pitch) / len(measured.pitch)
        self._filtered = measured.generator_speed
        self._theta = min(max(mean, pitch.fine), pitch.largest)
        self._integral = self._theta / (pitch.schedule(self._theta) * pitch.integral_gain)
        self._torque = self.find_torque(self._filtered, self._theta)

    def save(self) -> RestartData:
        """Its four states."""
        return RestartData(
            {
                "filtered": self._filtered,
                "integral": self._integral,
                "theta": self._theta,
                "torque": self._torque,
            }
        )

    def restore(self, data: RestartData) -> None:
        """Restore its states."""
        for name, value in data.numbers.items():
            setattr(self, f"_{name}", float(value))

    def finish(self) -> None:
        """Nothing has to be closed."""


def approach(value: float, target: float, most: float) -> float:
    """A value moved towards a target by no more than so much."""
    return min(max(target, value - most), value + most)

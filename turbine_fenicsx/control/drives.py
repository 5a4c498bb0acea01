"""Drives of bearings as motions that are known over a step: pitch and yaw.

A drive is a function of time for a `PrescribedMotion`. It gets its target between two steps. From
the state at that time its motion is a closed formula, which is the same for steps of any length.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from turbine_fenicsx.foundation.argument_checks import check_number, check_positive

_STATE = ("time", "angle", "rate", "target")


@dataclass(eq=False)
class PitchDrive:
    """A drive of second order: theta'' + 2 zeta w theta' + w^2 (theta - command) = 0.

    Args:
        sign: Factor that makes the joint coordinate of a pitch angle.
        frequency: Natural frequency w [rad/s].
        damping_ratio: zeta [-].
        angle: Pitch at its time [rad].
        rate: Its rate [rad/s].
        target: The command [rad]; the angle if None.
        time: Since when the command is held [s].

    Raises:
        ModelError: for a frequency or damping that is not positive.
    """

    sign: float
    frequency: float
    damping_ratio: float
    angle: float = 0.0
    rate: float = 0.0
    target: float | None = None
    time: float = 0.0

    def __post_init__(self) -> None:
        check_positive("frequency of a pitch drive", self.frequency)
        check_positive("damping ratio of a pitch drive", self.damping_ratio)
        if self.target is None:
            self.target = check_number("angle of a pitch drive", self.angle)

    def __call__(self, time: float) -> float:
        """The joint coordinate at a time that is not before the last command [rad]."""
        return self.sign * self.find_motion(time)[0]

    def find_motion(self, time: float) -> tuple[float, float]:
        """Pitch [rad] and its rate [rad/s] at a time [s]."""
        assert self.target is not None
        w, zeta, tau = self.frequency, self.damping_ratio, time - self.time
        e, v = self.angle - self.target, self.rate
        # e(tau) = C e + S (v + zeta w e),   v(tau) = C v - S (w^2 e + zeta w v)
        C, S = _decay(w, zeta, tau)
        return (
            self.target + C * e + S * (v + zeta * w * e),
            C * v - S * (w * w * e + zeta * w * v),
        )

    def hold(self, target: float, time: float) -> None:
        """Move on to a time [s], and from there towards a new command [rad]."""
        self.angle, self.rate = self.find_motion(time)
        self.target, self.time = target, time

    def save(self) -> list[float]:
        """Its state."""
        return [float(getattr(self, name)) for name in _STATE]

    def restore(self, state: list[float]) -> None:
        """Restore a state."""
        for name, value in zip(_STATE, state, strict=True):
            setattr(self, name, float(value))


def _decay(w: float, zeta: float, tau: float) -> tuple[float, float]:
    """C and S of free vibration: exp(-zeta w tau) times cos(w_d tau) and sin(w_d tau)/w_d.

    w_d^2 = w^2 (1 - zeta^2) may be zero or negative.
    """
    decay, square = zeta * w, 1.0 - zeta * zeta
    w_d = w * np.sqrt(abs(square))
    if w_d * tau < 1e-6:  # critical, or a short time
        factor = float(np.exp(-decay * tau))
        return factor * (1.0 - 0.5 * square * (w * tau) ** 2), factor * tau
    if square > 0.0:
        factor = float(np.exp(-decay * tau))
        return factor * float(np.cos(w_d * tau)), factor * float(np.sin(w_d * tau)) / w_d
    slow, fast = float(np.exp(-(decay - w_d) * tau)), float(np.exp(-(decay + w_d) * tau))
    return 0.5 * (slow + fast), 0.5 * (slow - fast) / w_d


@dataclass(eq=False)
class YawDrive:
    """A drive that turns at a rate which is held over the step.

    Args:
        sign: Factor that makes the joint coordinate of a yaw angle about the upward vertical.
        angle: Yaw at its time [rad].
        rate: Yaw rate [rad/s].
        time: Since when the rate is held [s].
    """

    sign: float
    angle: float = 0.0
    rate: float = field(default=0.0)
    time: float = 0.0

    def __call__(self, time: float) -> float:
        """The joint coordinate at a time [rad]."""
        return self.sign * self.find_angle(time)

    def find_angle(self, time: float) -> float:
        """Yaw at a time [rad]."""
        return self.angle + self.rate * (time - self.time)

    def hold(self, rate: float, time: float) -> None:
        """Move on to a time [s], and from there at a new rate [rad/s]."""
        self.angle, self.rate, self.time = self.find_angle(time), rate, time

    def save(self) -> list[float]:
        """Its state."""
        return [self.angle, self.rate, self.time]

    def restore(self, state: list[float]) -> None:
        """Restore a state."""
        self.angle, self.rate, self.time = map(float, state)

"""Torque of a variable-speed generator over its speed, in five regions.

Below the cut-in speed there is none (region 1); in region 2 it is K w^2, which keeps the tip-speed
ratio; above rated speed power is constant (region 3). Straight lines join them (regions 1 1/2 and
2 1/2), the latter that of an induction generator with a slip. Jonkman et al., Definition of a 5-MW
Reference Wind Turbine for Offshore System Development, NREL/TP-500-38060 (2009), section 7.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from turbine_fenicsx.foundation.argument_checks import check_positive
from turbine_fenicsx.foundation.errors import ModelError


@dataclass(frozen=True)
class TorqueLaw:
    """The law; defaults are those of the NREL 5 MW turbine.

    Args:
        cut_in_speed: End of region 1 [rad/s].
        optimal_speed: Beginning of region 2 [rad/s].
        gain: K of region 2 [N m s^2/rad^2].
        rated_speed: Beginning of region 3 [rad/s].
        rated_power: Mechanical power of the generator in region 3 [W].
        slip: Of region 2 1/2: its line is zero at rated_speed/(1 + slip) [-].
        largest: Largest torque [N m].
    """

    cut_in_speed: float = 70.16224
    optimal_speed: float = 91.21091
    gain: float = 2.332287
    rated_speed: float = 121.6805
    rated_power: float = 5.29661e6
    slip: float = 0.1
    largest: float = 47402.91

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            check_positive(f"{name.replace('_', ' ')} of the torque law", value)
        if not self.cut_in_speed < self.optimal_speed < self.rated_speed:
            raise ModelError(
                "speeds of the torque law must rise from cut-in to optimal to rated, got "
                f"{self.cut_in_speed:g}, {self.optimal_speed:g} and {self.rated_speed:g} rad/s"
            )
        if not self.optimal_speed < self.transition_speed <= self.rated_speed:
            raise ModelError(
                f"region 2 of the torque law has no end: with the gain {self.gain:g} N m s^2/rad^2 "
                f"and the slip {self.slip:g} its torque does not meet the line to rated torque "
                f"between {self.optimal_speed:g} and {self.rated_speed:g} rad/s"
            )

    @property
    def synchronous_speed(self) -> float:
        """Where the line of region 2 1/2 is zero [rad/s]."""
        return self.rated_speed / (1.0 + self.slip)

    @property
    def transition_slope(self) -> float:
        """Slope of the line of region 2 1/2 [N m s/rad]."""
        rated_torque = self.rated_power / self.rated_speed
        return rated_torque / (self.rated_speed - self.synchronous_speed)

    @property
    def transition_speed(self) -> float:
        """Where K w^2 meets that line [rad/s]; zero where it does not."""
        b, w_0 = self.transition_slope, self.synchronous_speed
        square = b * (b - 4.0 * self.gain * w_0)
        return 0.0 if square < 0.0 else (b - sqrt(square)) / (2.0 * self.gain)

    def torque(self, speed: float, above_rated: bool = False) -> float:
        """Torque at a speed.

        Args:
            speed: Of the generator [rad/s].
            above_rated: Whether power is kept although the speed is below rated, as in a lull.
        """
        if speed >= self.rated_speed or (above_rated and speed > self.cut_in_speed):
            wanted = self.rated_power / speed
        elif speed <= self.cut_in_speed:
            wanted = 0.0
        elif speed < self.optimal_speed:
            share = (speed - self.cut_in_speed) / (self.optimal_speed - self.cut_in_speed)
            wanted = share * self.gain * self.optimal_speed**2
        elif speed < self.transition_speed:
            wanted = self.gain * speed * speed
        else:
            wanted = self.transition_slope * (speed - self.synchronous_speed)
        return min(wanted, self.largest)

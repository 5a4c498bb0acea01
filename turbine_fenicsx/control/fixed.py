"""Commands that never change, for runs in which events alone act."""

from __future__ import annotations

from dataclasses import dataclass

from turbine_fenicsx.control.interface import Angles, Commands, Measurements
from turbine_fenicsx.foundation.restart_data import RestartData


@dataclass(frozen=True)
class FixedCommands:
    """A controller that always wants the same.

    Args:
        generator_torque: On the fast shaft [N m].
        pitch: Of the blades [rad].
    """

    generator_torque: float
    pitch: Angles

    def command(self, measured: Measurements) -> Commands:
        """The commands."""
        return Commands(self.generator_torque, self.pitch)

    def save(self) -> RestartData:
        """It has no memory."""
        return RestartData()

    def restore(self, data: RestartData) -> None:
        """It has no memory."""

    def finish(self) -> None:
        """Nothing has to be closed."""

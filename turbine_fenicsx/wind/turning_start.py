"""Air loads on a rotor that turns steadily, where an equilibrium is looked for at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.load_slopes import find_slopes
from turbine_fenicsx.forces.load_states import StateResponse, find_states
from turbine_fenicsx.forces.section_loads import LineLoad, SectionMotion
from turbine_fenicsx.foundation.argument_checks import check_array, check_number
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.foundation.types import Array
from turbine_fenicsx.wind.aerodynamics import fit_rotation


class TurningAtRest:
    """Another `LineLoad`; where nothing moves its sections turn about the shaft all the same.

    Statics knows no velocities, but air loads come from them. The shaft is where the roots of the
    blades are. In a step the motion is left as it is.

    Args:
        roots: Numbers of the first stations of three blades or more.
        shaft: Direction of the shaft in the initial configuration, shape (3,).
        centre: Rotor centre there, shape (3,) [m].
        speed: Speed of the rotor about the shaft [rad/s].

    Attributes:
        source: The other load.
        speed: The speed, which may be changed between equilibria.
    """

    def __init__(
        self,
        source: LineLoad,
        roots: npt.ArrayLike,
        shaft: npt.ArrayLike,
        centre: npt.ArrayLike,
        speed: float,
    ) -> None:
        self.source, self._roots = source, np.asarray(roots, dtype=int)
        self._shaft = check_array("shaft of the rotor", shaft, (3,), "three numbers")
        self._centre = check_array("centre of the rotor", centre, (3,), "three numbers")
        self.speed = check_number("speed of the rotor", speed)
        self._at_rest = False

    def start_step(self, times: StepTimes) -> None:
        """A step without end is no step: nothing moves in it."""
        self._at_rest = not np.isfinite(times.dt)
        self.source.start_step(times)

    def loads(self, motion: SectionMotion, time: float) -> tuple[Array, Array]:
        """Loads of the source; see `LineLoad.loads`."""
        return self.source.loads(self._turn(motion) if self._at_rest else motion, time)

    def find_slopes(self, motion: SectionMotion, times: StepTimes) -> Array:
        """Slopes of the source; see `SlopedLoad.find_slopes`."""
        return find_slopes(self.source, motion, times)

    @property
    def state_models(self) -> Sequence[str]:
        """Those of the source."""
        return find_states(self.source).state_models

    def balance(self, motion: SectionMotion, time: float) -> Array:
        """States of the source in balance with a motion that has its velocities."""
        return find_states(self.source).balance(motion, time)

    def read_states(self) -> Array | None:
        """Those of the source."""
        return find_states(self.source).read_states()

    def respond(self, motion: SectionMotion, time: float, states: Array) -> StateResponse:
        """StateResponse of the source to a motion that has its velocities."""
        return find_states(self.source).respond(motion, time, states)

    def accept(self, motion: SectionMotion, times: StepTimes) -> None:
        """The source moves on."""
        self.source.accept(motion, times)

    def save(self) -> RestartData:
        """Data of the source."""
        return self.source.save()

    def restore(self, data: RestartData) -> None:
        """Resume where the data of the source were saved."""
        self.source.restore(data)

    def _turn(self, motion: SectionMotion) -> SectionMotion:
        """The motion with the velocities of the rotation."""
        before, after = (x[self._roots] for x in (motion.initial, motion.position))
        turn = fit_rotation(before, after)
        centre = after.mean(axis=0) + turn @ (self._centre - before.mean(axis=0))
        omega = self.speed * (turn @ self._shaft) / np.linalg.norm(self._shaft)
        return motion._replace(
            velocity=motion.velocity + np.cross(omega, motion.position - centre),
            angular_velocity=motion.angular_velocity + omega,
        )

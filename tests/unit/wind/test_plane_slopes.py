"""Claims about the slopes of air loads: those of differences, with the wake as it is."""

from dataclasses import replace

import numpy as np
import pytest
from turning_rotors import DT, aerodynamics, frames, plain_blade, run, turning

from turbine_fenicsx.forces.force import StepTimes
from turbine_fenicsx.forces.load_slopes import find_slopes
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.skew import SkewedWake
from turbine_fenicsx.wind.stall import OeyeStall
from turbine_fenicsx.wind.turning_start import TurningAtRest


class OneStation:
    """Loads of another source, whose slopes are found by moving one station alone."""

    def __init__(self, source, motion, station):
        self._motion, self._station = motion, station
        self.start_step, self.accept = source.start_step, source.accept
        self.save, self.restore, self._loads = source.save, source.restore, source.loads

    def loads(self, motion, time):
        moved = [x.copy() for x in self._motion]
        for whole, part in zip(moved, motion, strict=True):
            whole[self._station] = part[self._station]
        return self._loads(type(motion)(*moved), time)


def swinging(blade, time):
    """A rotor that turns, flaps and twists, not equally along the blades."""
    motion, n = turning(blade, time, flap=1.5), 3 * len(blade.radius)
    change = np.random.default_rng(1).normal(size=(n, 3))
    return motion._replace(
        axes=rotation_about(frames()[0][0], 0.02) @ motion.axes,
        velocity=motion.velocity + change,
        angular_velocity=motion.angular_velocity + 0.3 * change[::-1],
    )


@pytest.mark.parametrize("options", [{}, {"stall": OeyeStall(), "skew": SkewedWake()}])
@pytest.mark.parametrize(("induction", "dt"), [(False, DT), (True, DT), (False, 4.0)])
def test_slopes_are_those_of_differences(options, induction, dt):
    blade = replace(plain_blade(), reference=0.4, prebend=np.linspace(0.0, -3.0, 20))
    wind = SteadyWind(10.0, 150.0)
    source = aerodynamics(blade, wind=wind, induction=induction, **options)
    run(source, blade, 3)
    times = StepTimes.from_start(3 * DT, dt)
    source.start_step(times)
    motion = swinging(blade, times.middle)
    found = find_slopes(source, motion, times)
    expected = np.stack(
        [find_slopes(OneStation(source, motion, k), motion, times)[k] for k in range(60)]
    )
    # the polars have kinks, and sections that move change the directions of the wake a little
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            a, b = found[:, rows, columns], expected[:, rows, columns]
            errors = np.max(np.abs(a - b), axis=(1, 2)) / np.max(np.abs(b))
            errors = errors.reshape(3, 20)[:, 1:]  # roots say where the shaft is
            assert np.median(errors) < 4e-3
            assert np.max(errors) < 0.03


def test_a_rotor_that_starts_turning_has_the_slopes_of_its_source():
    blade = plain_blade()
    source = aerodynamics(blade)
    run(source, blade, 1)
    times = StepTimes.from_start(DT, DT)
    motion = swinging(blade, times.middle)
    wrapped = TurningAtRest(source, [0, 20, 40], (1.0, 0.0, 0.0), np.zeros(3), 0.75)
    assert np.array_equal(find_slopes(wrapped, motion, times), source.find_slopes(motion, times))

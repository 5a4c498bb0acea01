"""What the tests of Newton's method share."""

import pytest

from turbine_fenicsx.time_stepping.energy_momentum import EnergyMomentum


@pytest.fixture
def solve():
    """Makes solvers, which are freed after the test on all ranks, whatever happened on one."""
    made = []

    def make(system, chosen):
        made.append(EnergyMomentum(system, options=chosen))
        return made[-1]

    yield make
    for solver in made:
        solver.destroy()

"""Runs of a flexible machine that are recorded, stopped, and go on, for tests of restarts."""

import copy

import numpy as np

from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.simulation.simulation import Simulation


class Keeper:
    """Stands for `Checkpoints`: keeps the restart data of every step."""

    def __init__(self):
        self.saved = {}

    def due(self, time, wall_time):
        return True

    def write(self, index, time, wall_time, data):
        self.saved[index] = copy.deepcopy(data)


class Recorder:
    """Writes down what observers see, except wall times."""

    def __init__(self):
        self.seen = {}

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, s):
        state, b = s.state, s.balance
        vectors = [x.array.copy() for x in (*state.u, *state.v, *state.coupling)]
        arrays = [
            state.q,
            state.q_dot,
            state.joint_coordinates,
            state.joint_rates,
            state.multipliers,
        ]
        numbers = [state.time, b.total, s.external_work, s.energy_error, s.constraint_error]
        self.seen[s.index] = (numbers, [x.copy() for x in arrays], vectors, s.report)

    def finish(self):
        pass


def equal(a, b):
    """Whether two records of a step are the same bit for bit, except for a missing report."""
    same = a[0] == b[0] and (a[3] == b[3] or None in (a[3], b[3]))
    return same and all(
        np.array_equal(x, y) for k in (1, 2) for x, y in zip(a[k], b[k], strict=True)
    )


class Fussy:
    """A step solver that fails where ``fails(time, dt)`` says so, else the real one."""

    def __init__(self, solver, fails):
        self.solver, self.fails = solver, fails

    def __getattr__(self, name):
        return getattr(self.solver, name)

    def advance(self, state, dt, out):
        if self.fails(state.time, dt):
            raise StepFailure(f"no solution from t = {state.time}")
        return self.solver.advance(state, dt, out)


def simulate(system, data=None, *, step=0.02, end=0.16, fails=None, **options):
    """Run from the start or from restart data; returns what it recorded and saved, and itself."""
    recorder, keeper = Recorder(), Keeper()
    options = {"checkpoints": keeper} | options
    simulation = Simulation(system, step, end, [recorder], **options)
    if fails is not None:
        simulation.stepper = Fussy(simulation.stepper, fails)
    simulation.run(data)
    return recorder.seen, keeper.saved, simulation


def goes_on_everywhere(system, make_options, every=1):
    """A run, and the same from each of its checkpoints on. Returns the run and what it saved."""
    whole, saved, simulation = simulate(system, **make_options())
    last = max(whole)
    for index in range(0, last + 1, every):
        part, _, again = simulate(system, saved[index], **make_options())
        assert sorted(part) == list(range(index, last + 1)), index
        for k, record in part.items():
            assert equal(record, whole[k]), (index, k)
        assert again.halvings == simulation.halvings
        again.stepper.destroy()
    return whole, saved, simulation

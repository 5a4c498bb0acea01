"""The first signal asks a run to stop, the second one stops the program."""

import os
import signal

import numpy as np
import pytest

from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.foundation.interrupts import SIGNALS, catch_signals, end_immediately
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel


def handlers():
    return [signal.getsignal(number) for number in SIGNALS]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
def test_the_first_signal_is_only_noted(number):
    with catch_signals() as interrupt:
        assert not interrupt()
        os.kill(os.getpid(), number)
        assert interrupt()
        assert interrupt.received == number.name


def test_the_second_signal_acts_as_usual():
    with pytest.raises(KeyboardInterrupt), catch_signals() as interrupt:
        os.kill(os.getpid(), signal.SIGTERM)
        assert interrupt()
        os.kill(os.getpid(), signal.SIGINT)


def test_handlers_are_those_from_before_in_the_end():
    before = handlers()
    for signals in ([], [signal.SIGTERM]):
        with catch_signals():
            assert signals or all(a != b for a, b in zip(handlers(), before, strict=True))
            for number in signals:
                os.kill(os.getpid(), number)
        assert handlers() == before
    with pytest.raises(RuntimeError), catch_signals():
        raise RuntimeError
    assert handlers() == before


def test_a_signal_ends_at_once_what_cannot_be_finished():
    with pytest.raises(KeyboardInterrupt), catch_signals(), end_immediately():
        os.kill(os.getpid(), signal.SIGTERM)
        raise AssertionError


def test_a_signal_that_has_come_already_ends_it_before_it_begins():
    with catch_signals(), pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGTERM)
        with end_immediately():
            raise AssertionError


def test_afterwards_signals_are_only_noted_again():
    with catch_signals() as interrupt:
        with end_immediately():
            with end_immediately():
                pass
            assert interrupt.at_once
        os.kill(os.getpid(), signal.SIGTERM)
        assert interrupt()
    with end_immediately():  # where nobody catches signals
        pass


class Recorder:
    """Counts steps, and sends a signal to its own process on one rank after some of them."""

    def __init__(self, comm, rank=0, after=None):
        self.mine, self.after, self.times = comm.rank == rank, after, []

    def start(self, snapshot, resumed):
        self.observe(snapshot)

    def observe(self, snapshot):
        self.times.append(snapshot.state.time)
        if self.mine and snapshot.index == self.after:
            os.kill(os.getpid(), signal.SIGTERM)

    def finish(self):
        pass


@pytest.mark.parametrize("rank", [0, -1])
@pytest.mark.parametrize(("after", "n"), [(0, 1), (3, 3), (5, 5)])
def test_a_signal_to_any_rank_ends_the_run_on_all_after_the_step(comm, machine, rank, after, n):
    """One that comes before the first step is noticed after it."""
    m = machine(spin=3.0)
    system = MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity()])
    recorder = Recorder(comm, rank % comm.size, after)
    with catch_signals() as interrupt:
        simulation = Simulation(system, 0.02, 0.1, [recorder], stop=interrupt)
        last = simulation.run()
    assert simulation.stopped
    assert last.index == n
    assert np.array_equal(recorder.times, 0.02 * np.arange(n + 1))


def test_a_run_that_was_stopped_can_run_again(comm, machine):
    m = machine(spin=3.0)
    system = MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity()])
    answers = iter([True])
    simulation = Simulation(system, 0.02, 0.1, stop=lambda: next(answers, False))
    assert (simulation.run().index, simulation.stopped) == (1, True)
    assert (simulation.run().index, simulation.stopped) == (5, False)

"""Code of users that fails, ends the program or differs on one rank: no rank waits for ever."""

import sys

import numpy as np
import pytest
from bricks import brick, clamped, facets_at

from turbine_fenicsx import (
    BodyForce,
    History,
    JointTorque,
    MultibodySystem,
    NodeForce,
    PointForce,
    PrescribedMotion,
    Pressure,
    Revolute,
    RigidBody,
    Simulation,
    SurfaceTraction,
)
from turbine_fenicsx.foundation.errors import ForeignError
from turbine_fenicsx.simulation.observers.history import Channel

pytestmark = pytest.mark.parallel

BALL = RigidBody("ball", 1.0, (1.0, 1.0, 1.0), position=(0.0, 5.0, 0.0))
HINGE = Revolute("hinge", None, BALL, point=(0.0, 5.0, 0.0), axis=(0.0, 0.0, 1.0))
UP = (0.0, 0.0, 1.0)


def list_parts(kind, comm, function):
    """A system with a load of some kind that has a function of time."""
    beam = brick(comm)
    tip = facets_at(beam.mesh, 1.0)
    loads = {
        "node": lambda: NodeForce("load", beam, point=(1.0, 0, 0), force=UP, function=function),
        "body": lambda: BodyForce("load", beam, field=np.ones_like, function=function),
        "traction": lambda: SurfaceTraction("load", beam, tip, UP, function),
        "pressure": lambda: Pressure("load", beam, tip, 1.0, function),
        "point": lambda: PointForce("load", BALL, point=(0, 5, 0), force=UP, function=function),
        "torque": lambda: JointTorque("load", "hinge", 1.0, function),
        "motion": lambda: PrescribedMotion("hinge", function),
    }
    return [beam, clamped(beam), BALL, HINGE, loads[kind]()]


KINDS = ["node", "body", "traction", "pressure", "point", "torque", "motion"]


def run(comm, parts, observers=()):
    return Simulation(MultibodySystem(comm, parts), 0.01, 0.03, list(observers)).run()


@pytest.mark.parametrize("kind", KINDS)
def test_a_function_has_the_value_of_rank_0_everywhere(comm, kind):
    """It depends on the rank, and on chance, but begins at zero as a motion must."""
    random = np.random.default_rng(comm.rank)

    def function(t):
        assert comm.rank == 0 or t == 0.0
        return t**2 * (1.0 + comm.rank + random.random())

    last = run(comm, list_parts(kind, comm, function))
    found = comm.allgather((last.external_work, last.balance.total, last.energy_error))
    assert found == [found[0]] * comm.size


@pytest.mark.parametrize("kind", KINDS)
def test_a_function_that_ends_the_program_is_an_error_on_all_ranks(comm, kind):
    def function(t):
        if t > 0.012:
            sys.exit(3)
        return 0.0

    with pytest.raises(ForeignError, match=r"failed: it ends the program by sys\.exit\(3\)"):
        run(comm, list_parts(kind, comm, function))


class Magnet:
    """A force of one's own that does something in a step."""

    name, kind = "pull", "conservative"

    def __init__(self, force=lambda: None, energy=lambda: 0.0):
        self._force, self._energy = force, energy

    def bind(self, layout):
        _, self.index = layout.frames(BALL)
        return self

    def force(self, y0, y1, step):
        self._force()
        return np.zeros(12), np.zeros((12, 12))

    def energy(self, y):
        return self._energy()


def test_energies_of_own_forces_are_those_of_rank_0(comm):
    last = run(comm, [BALL, Magnet(energy=lambda: float(comm.rank))])
    assert comm.allgather(last.balance.spring) == [0.0] * comm.size


@pytest.mark.parametrize("method", ["force", "energy"])
def test_own_forces_that_end_the_program_are_errors_on_all_ranks(comm, method):
    with pytest.raises(ForeignError, match=rf"{method}\(\) of Magnet 'pull' failed: it ends the"):
        run(comm, [BALL, Magnet(**{method: lambda: sys.exit(3)})])


class Watch:
    """An observer that does something on the last rank."""

    def __init__(self, comm, act):
        self._act, self._mine, self.seen = act, comm.rank == comm.size - 1, 0

    def start(self, snapshot, resumed):
        pass

    def observe(self, snapshot):
        self.seen += 1
        if self._mine and snapshot.index == 2:
            self._act()

    def finish(self):
        pass


def fail():
    raise KeyError("nothing of this name")


@pytest.mark.parametrize(
    ("act", "error", "words"),
    [
        (fail, KeyError, "nothing of this name"),
        (lambda: sys.exit(3), ForeignError, r"observer Watch failed: it ends the program by sys"),
    ],
)
def test_an_observer_that_fails_on_one_rank_is_an_error_on_all(comm, act, error, words):
    first, second = Watch(comm, act), Watch(comm, lambda: None)
    with pytest.raises(error, match=words):
        run(comm, [BALL], [first, second])
    assert (first.seen, second.seen) == (2, 2)


@pytest.mark.parametrize(("act", "error"), [(fail, KeyError), (lambda: sys.exit(3), ForeignError)])
def test_a_channel_that_fails_on_one_rank_is_an_error_on_all(comm, act, error, shared_tmp_path):
    def values(snapshot):
        if comm.rank == comm.size - 1 and snapshot.index == 2:
            act()
        return [1.0]

    history = History(comm, shared_tmp_path / "history.csv", [Channel(("a",), values)])
    with pytest.raises(error):
        run(comm, [BALL], [history])
    if comm.rank == 0:
        assert (shared_tmp_path / "history.csv").read_text().split() == ["a", "1.0", "1.0"]

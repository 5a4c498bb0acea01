"""Claims about who watches a run: what is called when, and what survives a restart."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.restart_data import RestartData
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx.simulation.observer import describe_shortfall
from turbine_fenicsx.simulation.observers.history import Channel, History, energy_channel
from turbine_fenicsx.simulation.simulation import Simulation

pytestmark = pytest.mark.parallel


class Caller:
    """Writes down what it is called for."""

    def __init__(self, fails=()):
        self.calls, self.fails = [], fails

    def start(self, snapshot, resumed):
        self.note("start", snapshot.index, resumed)

    def observe(self, snapshot):
        self.note("observe", snapshot.index)

    def finish(self):
        self.note("finish")

    def note(self, *call):
        self.calls.append(call)
        if call[0] in self.fails:
            raise RuntimeError(call[0])


class Mean(Caller):
    """Mean of the total energy and of the directors over all states of a run, earlier parts too."""

    name = "mean"

    def __init__(self):
        super().__init__()
        self.n, self.sum, self.q = 0, 0.0, 0.0

    def start(self, snapshot, resumed):
        super().start(snapshot, resumed)
        if not resumed:
            self.add(snapshot)

    def observe(self, snapshot):
        super().observe(snapshot)
        self.add(snapshot)

    def add(self, snapshot):
        self.n += 1
        self.sum += snapshot.balance.total
        self.q = self.q + snapshot.state.q

    def save(self):
        self.note("save")
        return RestartData({"n": self.n, "sum": self.sum}, {"q": np.copy(self.q)})

    def restore(self, data):
        self.note("restore")
        self.n, self.sum = data.numbers["n"], data.numbers["sum"]
        self.q = data.arrays["q"]


@pytest.fixture
def system(machine):
    return machine(spin=3.0).system()


def simulate(system, folder, end, observers, resume=False):
    checkpoints = Checkpoints(system, folder / "checkpoints", every=0.04)
    simulation = Simulation(system, 0.02, end, observers, checkpoints=checkpoints)
    last = simulation.resume() if resume else simulation.run()
    simulation.stepper.destroy()
    return last


def test_methods_are_called_in_their_order(system, shared_tmp_path):
    first, second = Mean(), Mean()
    simulate(system, shared_tmp_path, 0.02, [first])
    steps = [("start", 0, False), ("save",), ("observe", 1), ("save",), ("finish",)]
    assert first.calls == steps
    simulate(system, shared_tmp_path, 0.04, [second], resume=True)
    assert second.calls == [
        ("restore",),
        ("start", 1, True),
        ("save",),
        ("observe", 2),
        ("save",),
        ("finish",),
    ]


@pytest.mark.parametrize("fails", ["start", "observe"])
def test_what_was_started_is_finished(system, fails):
    before, bad, behind = Caller(), Caller([fails]), Caller()
    with pytest.raises(RuntimeError, match=fails):
        Simulation(system, 0.02, 0.04, [before, bad, behind]).run()
    assert before.calls[-1] == ("finish",)
    assert (("finish",) in bad.calls) == (fails == "observe")
    assert (("finish",) in behind.calls) == (fails == "observe")
    # those behind may do something on all ranks, where it may have failed on one
    seen = [("start", 0, False), ("observe", 1), ("finish",)]
    assert behind.calls == ([] if fails == "start" else seen)


def test_what_an_observer_saves_survives_a_restart_bit_for_bit(system, shared_tmp_path):
    whole, half, rest = Mean(), Mean(), Mean()
    end = simulate(system, shared_tmp_path / "whole", 0.2, [whole])
    simulate(system, shared_tmp_path / "parts", 0.1, [half])
    again = simulate(system, shared_tmp_path / "parts", 0.2, [rest], resume=True)
    assert half.n == 6 and rest.n == whole.n == 11
    assert rest.sum == whole.sum and np.array_equal(rest.q, whole.q)
    assert again.energy_error == end.energy_error
    assert np.array_equal(again.state.q, end.state.q)


def test_an_observer_that_is_new_at_a_restart_begins_there(system, shared_tmp_path):
    simulate(system, shared_tmp_path, 0.1, [])
    new = Mean()
    simulate(system, shared_tmp_path, 0.2, [new], resume=True)
    assert new.calls[0] == ("start", 5, True) and new.n == 5


@pytest.mark.parametrize("lost", [0, 1, 3])
def test_a_run_resumes_where_its_series_reach(comm, system, shared_tmp_path, caplog, lost):
    """A row too few takes it to the checkpoint before."""
    path = shared_tmp_path / "history.csv"

    def series():
        index = Channel(("index",), lambda s: [s.index])
        return [History(comm, path, [energy_channel(), index])]

    simulate(system, shared_tmp_path, 0.2, series())
    whole = path.read_text()
    comm.barrier()
    if comm.rank == 0:
        path.write_text("".join(whole.splitlines(keepends=True)[: 12 - lost]))
    comm.barrier()
    last = simulate(system, shared_tmp_path, 0.2, series(), resume=True)
    assert last.index == 10
    if lost < 3:  # the two checkpoints are at 0.16 and 0.2 s
        assert path.read_text() == whole
    if comm.rank == 0:
        words = {
            0: "",
            1: "cannot be reached, history.csv holds 10 of its 11 rows up to t = 0.2 s",
            3: "history.csv holds 8 of its 11 rows up to t = 0.2 s; the others are lost",
        }
        assert words[lost] in caplog.text
        assert bool(caplog.text) == (lost > 0)


def test_a_series_keeps_its_columns(comm, system, shared_tmp_path):
    path = shared_tmp_path / "history.csv"
    more = Channel(("index",), lambda s: [s.index])
    simulate(system, shared_tmp_path, 0.1, [History(comm, path, [energy_channel()])])
    again = History(comm, path, [energy_channel(), more])
    simulate(system, shared_tmp_path, 0.2, [again], resume=True)
    lines = path.read_text().splitlines()
    assert len(lines) == 12 and {line.count(",") for line in lines} == {12}


def test_a_run_that_begins_anew_leaves_nothing_of_the_one_before(comm, system, shared_tmp_path):
    path = shared_tmp_path / "history.csv"
    history = History(comm, path, [energy_channel()])
    for end in (0.1, 0.04):
        simulate(system, shared_tmp_path, end, [history])
    assert len(path.read_text().splitlines()) == 4
    assert Checkpoints(system, shared_tmp_path / "checkpoints").load().numbers["index"] == 2


def test_a_simulation_without_checkpoints_cannot_resume(system, shared_tmp_path):
    simulation = Simulation(system, 0.02, 0.02)
    with pytest.raises(ValueError, match=r"it has none: give it checkpoints=Checkpoints\("):
        simulation.resume()
    simulation = Simulation(system, 0.02, 0.02, checkpoints=Checkpoints(system, shared_tmp_path))
    with pytest.raises(InputError, match="there is no checkpoint in"):
        simulation.resume()


def test_two_observers_of_one_name_are_refused(system):
    with pytest.raises(ValueError, match="2 observers are called 'mean'"):
        Simulation(system, 0.02, 0.02, [Mean(), Caller(), Mean()])


@pytest.mark.parametrize("missing", ["name", "save", "restore"])
def test_half_a_restartable_observer_is_refused(system, missing):
    methods = {"name": "half", "save": Mean.save, "restore": Mean.restore}
    del methods[missing]
    half = type("Half", (Caller,), methods)()
    with pytest.raises(TypeError, match=r"needs a name, save\(\) and restore\(\), but .*Half"):
        Simulation(system, 0.02, 0.02, [half])


def test_a_shortfall_is_a_clause_or_none():
    assert describe_shortfall("a.csv", 5, 5, "rows", 1.0) is None
    assert describe_shortfall("a.csv", 3, 5, "rows", 1.0) == (
        "a.csv holds 3 of its 5 rows up to t = 1 s"
    )

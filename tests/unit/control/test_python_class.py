"""Controllers in Python files of users."""

import itertools
import os
import signal
import time
from functools import partial
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.control import foreign
from turbine_fenicsx.control.command_check import check_commands
from turbine_fenicsx.control.foreign import CallHistory, ForeignController, unpack
from turbine_fenicsx.control.interface import Commands, Measurements
from turbine_fenicsx.control.python_class import PythonClass
from turbine_fenicsx.foundation import interrupts
from turbine_fenicsx.foundation.errors import ForeignError, InputError
from turbine_fenicsx.foundation.interrupts import catch_signals
from turbine_fenicsx.foundation.restart_data import RestartData

GOOD = """
class Counting:
    def __init__(self):
        self.calls = 0
        self.ended = False

    def __call__(self, measured):
        self.calls += 1
        return 10.0 * self.calls + measured.generator_speed, measured.pitch

    def finish(self):
        assert not self.ended
        self.ended = True
"""


def measure(time, speed=1.0):
    return Measurements(time, 0.1, time == 0.0, speed, 0.0, 0.0, (0.1, 0.2, 0.3), 0.0, 0.0)


def write(folder, text, name="mine.py"):
    path = folder / name
    path.write_text(text)
    return path


def test_measurements_survive_a_list_of_numbers():
    measured = measure(0.0)._replace(wind_speed=7.0, yaw_error=0.4)
    assert Measurements.from_row(np.array(measured.to_row())) == measured


@pytest.mark.parallel
def test_a_class_is_called_on_rank_0_and_goes_on_after_a_restart(comm, shared_tmp_path):
    if comm.rank == 0:
        write(shared_tmp_path, GOOD)
    comm.barrier()

    def make():
        path = shared_tmp_path / "mine.py"
        return ForeignController(comm, lambda: PythonClass(path, "Counting"), "'Counting'")

    one, other = make(), make()
    answers = [one.command(measure(0.1 * k, float(k))) for k in range(6)]
    assert answers[2] == Commands(32.0, (0.1, 0.2, 0.3), 0.0)
    three = make()
    for k in range(3):
        three.command(measure(0.1 * k, float(k)))
    other.restore(three.save())
    assert [other.command(measure(0.1 * k, float(k))) for k in range(3, 6)] == answers[3:]
    one.finish()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "there is no file"),
        ("class Other: pass", "has no class 'Counting'"),
        ("Counting = 3", "has no class 'Counting'"),
        ("import nonsense_of_nobody", r"cannot be run: ModuleNotFoundError.*\(line 1\)"),
        ("class Counting:", "cannot be run: IndentationError"),
        ("class Counting:\n    pass", "cannot be called"),
        ("class Counting:\n    def __init__(self, x):\n        pass", "cannot be made: TypeError"),
        (
            "class Counting:\n    def __call__(self, m):\n        return 1 / 0",
            r"failed at t = 0 s: ZeroDivisionError: division by zero \(line 3\)",
        ),
        (
            "class Counting:\n    def __call__(self, m):\n        return None",
            r"must return Commands\(generator_torque, pitch, yaw_rate, brake\), got None",
        ),
    ],
)
def test_files_and_classes_that_fail_are_sentences(text, message, tmp_path):
    path = tmp_path / "mine.py"
    if text is not None:
        path.write_text(text)
    make = partial(PythonClass, path, "Counting")
    with pytest.raises(InputError, match=message):
        ForeignController(MPI.COMM_SELF, make, "'Counting'").command(measure(0.0))


@pytest.mark.parametrize(
    ("commands", "message"),
    [
        ((1.0, (0.0, np.nan, 0.0)), "'it' commands no number as pitch at t = 3 s"),
        ((np.inf, (0.0, 0.0, 0.0), np.nan), "no number as generator torque and yaw rate"),
        ((1.0, (0.0, 0.0)), "must command the pitch of 3 blades"),
        ((1.0, 0.1), "must return Commands"),
        ((10**400, (0.0, 0.0, 0.0)), "must return Commands"),
        ((1.0, itertools.repeat(0.0)), "must command the pitch of 3 blades"),
        (itertools.repeat(0.0), "must return Commands"),
        ((3e38, (0.0, 0.0, 0.0)), r"a generator torque of 3e\+38 N m .*expected -1e\+09 to 1e\+09"),
        ((0.0, (0.0, 0.0, -1e30)), r"a pitch of -1e\+30 rad at t = 3 s: expected -6.283 to 6.283"),
        ((0.0, (90.0, 90.0, 90.0)), "a pitch of 90 rad"),
        ((0.0, (0.0, 0.0, 0.0), 30.0), "a yaw rate of 30 rad/s at t = 3 s: expected -1 to 1 rad/s"),
        ((0.0, (0.0, 0.0, 0.0), 0.0, 1.1), "a brake of 1.1 at t = 3 s: expected 0 to 1"),
        ((1.0, (0.0, 0.0, 0.0), 0.0, 0.0, 0.0), "must command the pitch of 3 blades"),
    ],
)
def test_commands_that_are_none_are_refused(commands, message):
    with pytest.raises(InputError, match=message):
        check_commands(commands, "'it'", 3.0)


WILD = """
import sys

class Wild:
    def __call__(self, measured):
        {call}

    def finish(self):
        {finish}

class Mute:
    def __repr__(self):
        raise ValueError

class Strange(BaseException):
    def __str__(self):
        raise ValueError
"""


def wild(folder, call="return 1.0, (0.0, 0.0, 0.0)", finish="pass"):
    """A controller on one rank whose methods have these bodies."""
    path = write(folder, WILD.format(call=call, finish=finish))
    return ForeignController(MPI.COMM_SELF, lambda: PythonClass(path, "Wild"), "'Wild'")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("sys.exit(5)", r"controller 'Wild' of '.*mine.py' failed at t = 0 s: SystemExit: 5 \(li"),
        ("raise Strange", r"failed at t = 0 s: Strange: its text cannot be had \(line 6\)$"),
        ("raise GeneratorExit", r"failed at t = 0 s: GeneratorExit \(line 6\)$"),
        ('raise ValueError("boom\\nsecond line")', r"ValueError: boom second line \(line 6\)$"),
        ("return Mute()", "'Wild' of '.*mine.py' must return Commands.*got <Mute instance at "),
        ("return 10**400, (0.1,) * 3", r"must return Commands.*got \(1000.*0, \(0.1, 0.1, 0.1\)\)"),
        ("return self(measured)", r"failed at t = 0 s: RecursionError: .* \(line 6\)$"),
        ("yield", "must return Commands.*got <generator"),
    ],
)
def test_whatever_a_controller_does_is_one_sentence_with_its_file(call, message, tmp_path):
    with pytest.raises(ForeignError, match=message) as caught:
        wild(tmp_path, call).command(measure(0.0))
    assert len(str(caught.value).splitlines()) == 1


def test_ctrl_c_stays_an_interrupt_and_what_the_code_raises_of_the_kind_does_not(tmp_path):
    controller = wild(tmp_path, "raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        controller.command(measure(0.0))
    with catch_signals(), pytest.raises(ForeignError, match="KeyboardInterrupt"):
        controller.command(measure(0.0))


def test_control_characters_in_errors_are_written_out(tmp_path):
    with pytest.raises(ForeignError, match=r"ValueError: \\x1b\[31mred\\x07 \(line"):
        wild(tmp_path, r"raise ValueError('\x1b[31mred\a')").command(measure(0.0))


def test_the_folder_stays_what_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    change = "__import__('os').chdir('/')"
    controller = wild(tmp_path, f"{change}; return 1.0, (0.0, 0.0, 0.0)", f"{change}")
    controller.command(measure(0.0))
    assert Path.cwd() == tmp_path
    controller.finish()
    assert Path.cwd() == tmp_path


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_loop_without_end_ends_some_time_after_a_signal(tmp_path, monkeypatch, number):
    monkeypatch.setattr(interrupts, "STUCK", 0.1)
    send = f"__import__('os').kill({os.getpid()}, {number.value})"
    controller = wild(tmp_path, f"{send}\n        while True: pass")
    with catch_signals() as interrupt, pytest.raises(KeyboardInterrupt):
        controller.command(measure(0.0))
    assert interrupt.received == number.name
    with catch_signals() as interrupt:  # what ends in time is not ended
        wild(tmp_path, f"{send}; return 1.0, (0.0, 0.0, 0.0)").command(measure(0.0))
        time.sleep(0.2)
    assert interrupt.received == number.name


def test_a_finish_that_fails_is_a_warning(tmp_path, caplog):
    wild(tmp_path, finish="sys.exit(3)").finish()
    assert [r.levelname for r in caplog.records] == ["WARNING"]
    assert "finish() of the controller 'Wild'" in caplog.text
    assert "the results are complete: SystemExit: 3 (line 9)" in caplog.text


# --- its own state

KEEPING = """
class Keeping:
    def __init__(self):
        self.sum, self.seen, self.given = 0.0, [], None

    def __call__(self, measured):
        self.sum += measured.generator_speed
        self.seen.append(measured.time)
        return 100.0 * self.sum + len(self.seen), (0.0, 0.0, 0.0)

    def save(self):
        return {save}

    def restore(self, data):
        self.given = data["table"], len(data["seen"])
        self.sum, self.seen = data["sum"], data["seen"]
"""
STATE = '{"sum": self.sum, "seen": self.seen, "table": (1, "a", None, True, [2.5])}'


def keeping(comm, folder, save=STATE):
    """A controller that saves its state."""
    if comm.rank == 0:
        write(folder, KEEPING.replace("{save}", save))
    comm.barrier()
    path = folder / "mine.py"
    return ForeignController(comm, lambda: PythonClass(path, "Keeping"), "the controller")


def unpack_calls(data):
    """The calls in what a controller has saved, on rank 0."""
    return list(unpack(data.arrays["calls"].tobytes(), data.numbers["width"]))


def count_calls(controller):
    """Calls that a controller keeps; none on other ranks than 0."""
    return sum(calls.count for _, calls in controller._windows)


def test_a_class_that_saves_its_state_gets_it_back_and_sees_little_again(comm, shared_tmp_path):
    """The state before the last one, so that the last calls show whether all was saved."""
    one, other = (keeping(comm, shared_tmp_path) for _ in range(2))
    for k in range(5):
        one.command(measure(0.1 * k, 0.1 * k))
        if k == 2:
            one.save()
    data = one.save()
    if comm.rank == 0:
        assert len(unpack_calls(data)) == 2
    one.command(measure(0.5, 0.5))  # what it saved is a copy
    other.restore(comm.bcast(data))
    for k in range(5, 8):
        again = other.command(measure(0.1 * k, 0.1 * k))
        if k > 5:
            assert again == one.command(measure(0.1 * k, 0.1 * k))
    if comm.rank == 0:
        assert other._responder._controller.given == ([1, "a", None, True, [2.5]], 3)


@pytest.mark.parametrize("save", ["None", '{"sum": 0.0, "seen": self.seen, "table": 0}'])
def test_a_save_that_forgets_is_noticed(save, tmp_path):
    """It is restored, and then commands something else than it did."""
    one, other = (keeping(MPI.COMM_SELF, tmp_path, save) for _ in range(2))
    for k in range(1, 6):
        one.command(measure(0.1 * k, 0.1 * k))
        if k == 3:
            one.save()
    words = (
        r"restore\(\) .* failed: TypeError"
        if save == "None"
        else "something that save.. leaves out"
    )
    with pytest.raises(ForeignError, match=words):
        other.restore(one.save())


def test_after_a_failure_its_last_state_and_the_calls_since_are_saved(comm, shared_tmp_path):
    save = STATE + " if len(self.seen) < 5 else 1 / 0"
    one, other = (keeping(comm, shared_tmp_path, save) for _ in range(2))
    for k in range(6):
        answer = one.command(measure(0.1 * k, 0.1 * k))
        if k in (1, 3):
            one.save()
    with pytest.raises(ForeignError, match=r"save\(\) of .* failed: ZeroDivisionError"):
        one.save()
    other.restore(comm.bcast(one.save()))
    assert one.command(measure(0.6)) == other.command(measure(0.6)) != answer
    if comm.rank == 0:
        assert other._responder._controller.given[1] == 2


@pytest.mark.parametrize(
    ("save", "message"),
    [
        ("{1: 2}", " has a key of type int, expected text"),
        ("object()", "the result is of type object; expected numbers, text, None"),
        ("{'a': [1, __import__('numpy').zeros(3)]}", r"\['a'\]\[1\] is of type ndarray, use .tol"),
        ("[2**64]", r"\[0\] is an integer beyond 64 bits"),
        ("b'x'", "is of type bytes"),
        ("(l := [], l.append(l), l)[2]", "is deeper than 32 lists, or contains itself"),
    ],
)
def test_a_state_that_is_no_plain_data_is_a_sentence(save, message, tmp_path):
    controller = keeping(MPI.COMM_SELF, tmp_path, save)
    controller.command(measure(0.0))
    with pytest.raises(ForeignError, match=rf"save\(\) of the controller 'Keeping' .*{message}"):
        controller.save()


def test_save_without_restore_is_refused(tmp_path):
    path = write(tmp_path, KEEPING.replace("{save}", "1").replace("def restore", "def other"))
    with pytest.raises(InputError, match="has save, but save and restore need both"):
        PythonClass(path, "Keeping")


def test_a_state_that_cannot_be_restored_is_a_sentence(tmp_path):
    one, other = (keeping(MPI.COMM_SELF, tmp_path, "{'sum': 1.0, 'table': 0}") for _ in range(2))
    one.command(measure(0.0))
    one.save()
    with pytest.raises(ForeignError, match=r"restore\(\) of .* failed: KeyError: 'seen' \(line 15"):
        other.restore(one.save())


# --- what it has seen


def test_a_controller_that_does_not_do_the_same_again_is_a_sentence(tmp_path):
    one = wild(tmp_path, "return 1.0, (0.0, 0.1, 0.0)")
    for k in range(3):
        one.command(measure(0.1 * k))
    other = wild(tmp_path, "return 1.0, (0.0, 0.1 if measured.time < 0.15 else 0.12, 0.0)")
    with pytest.raises(ForeignError, match=r"does not do the same again.*t = 0.2 s, it commands"):
        other.restore(one.save())


def test_rounding_of_another_computer_is_no_difference(tmp_path):
    one = wild(tmp_path, "return 1e5, (0.0, 0.1, 0.0)")
    one.command(measure(0.0))
    other = wild(tmp_path, "return 1e5 * (1.0 + 1e-12), (1e-15, 0.1, 0.0)")
    other.restore(one.save())


def test_data_of_another_layout_are_a_sentence(tmp_path):
    data = RestartData(arrays={"seen": np.zeros((3, 22))})
    with pytest.raises(InputError, match="in layout 1, and this version reads layout 2"):
        wild(tmp_path).restore(data)


@pytest.mark.parametrize("count", [0, 1, 9, 10, 25])
def test_a_history_of_calls_is_packed_and_unpacked(monkeypatch, count):
    monkeypatch.setattr(foreign, "BLOCK", 10)
    rows = np.random.default_rng(0).standard_normal((count, 3))
    calls = CallHistory()
    for row in rows:
        calls.append(row.tolist())
    assert calls.count == count
    assert np.array_equal(np.array(list(unpack(calls.pack(), 3))).reshape(-1, 3), rows)
    assert len(calls._rest) == 3 * (count % 10)


def test_calls_are_kept_on_rank_0_alone_and_those_of_one_who_saves_are_few(
    comm, shared_tmp_path, monkeypatch
):
    monkeypatch.setattr(foreign, "WINDOW", 10)
    if comm.rank == 0:
        write(shared_tmp_path, GOOD, "good.py")
    comm.barrier()
    path = shared_tmp_path / "good.py"
    good = ForeignController(comm, lambda: PythonClass(path, "Counting"), "'Counting'")
    own = keeping(comm, shared_tmp_path)
    for k in range(25):
        good.command(measure(0.1 * k))
        own.command(measure(0.1 * k))
    assert count_calls(good) == (25 if comm.rank == 0 else 0)
    assert count_calls(own) == (15 if comm.rank == 0 else 0)

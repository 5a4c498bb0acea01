"""Controllers in Python files of users."""

from functools import partial

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx.control.foreign import ForeignController
from turbine_fenicsx.control.interface import Commands, Measurements, check_commands
from turbine_fenicsx.control.python_class import PythonClass
from turbine_fenicsx.foundation.errors import InputError

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
            r"must return Commands\(generator_torque, pitch, yaw_rate\), got None",
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
        ((1.0, (0.0, 0.0, 0.0), 0.0, 0.0), "must command the pitch of 3 blades"),
    ],
)
def test_commands_that_are_none_are_refused(commands, message):
    with pytest.raises(InputError, match=message):
        check_commands(commands, "'it'", 3.0)

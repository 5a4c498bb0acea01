"""``run.log`` has a line for everything that happens, and never gets in the way of a run."""

import logging
import re

import pytest

from turbine_fenicsx.forces.gravity import Gravity
from turbine_fenicsx.foundation.errors import InputError, StepFailure
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx.simulation.observers.run_log import StepLog, log_to_file
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.system.system import MultibodySystem

pytestmark = pytest.mark.parallel

PACKAGE = logging.getLogger("turbine_fenicsx")


@pytest.fixture
def rotor(comm, machine):
    """The rigid part of the machine, for speed."""
    m = machine(spin=3.0)
    return MultibodySystem(comm, [m.nacelle, m.hub, m.yaw, m.rotor, Gravity()])


def lines(comm, path):
    """Messages of the log without time and level, on all ranks."""
    comm.barrier()
    text = path.read_text()
    stamp = r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d{3} (INFO|WARNING) "
    assert all(re.match(stamp, line) for line in text.splitlines()), text
    return [re.sub(stamp, "", line) for line in text.splitlines()]


def simulate(system, folder, end, data=None, fails=None, append=False):
    """Run 0.02 s steps, logged."""
    checkpoints = Checkpoints(system, folder / "checkpoints", every=0.04)
    simulation = Simulation(system, 0.02, end, [StepLog()], checkpoints=checkpoints)
    if fails is not None:
        advance = simulation.stepper.advance

        def fussy(state, dt, out):
            if fails(state.time, dt):
                raise StepFailure("no solution")
            return advance(state, dt, out)

        simulation.stepper.advance = fussy
    with log_to_file(system.comm, folder / "run.log", append):
        simulation.run(data)


def test_every_step_and_every_checkpoint_has_a_line(comm, rotor, shared_tmp_path):
    simulate(rotor, shared_tmp_path, 0.1)
    found = lines(comm, shared_tmp_path / "run.log")
    assert [line.split(" t = ")[0] for line in found] == [
        "begin at",
        "checkpoint of step 0 at",
        "step 1",
        "step 2",
        "checkpoint of step 2 at",
        "step 3",
        "step 4",
        "checkpoint of step 4 at",
        "step 5",
        "checkpoint of step 5 at",
    ]
    step = r"step 3 t = 0\.06 s dt = 0\.02 s, \d+ Newton, \d+ Krylov, residual \S+, energy error "
    assert re.match(step + r"\S+ J, constraints \S+$", found[5])


def test_a_halved_step_has_a_line_with_the_reason(comm, rotor, shared_tmp_path):
    simulate(rotor, shared_tmp_path, 0.06, fails=lambda t, dt: 0.01 < t < 0.025 and dt > 0.01)
    found = lines(comm, shared_tmp_path / "run.log")
    assert [line for line in found if "half" in line] == ["no solution; now with half of it"]
    sizes = [line.split(" dt = ")[1].split(" s,")[0] for line in found if " dt = " in line]
    assert sizes == ["0.02", "0.01", "0.01", "0.02"]


def test_a_run_that_goes_on_says_so_behind_what_was_there(comm, rotor, shared_tmp_path):
    simulate(rotor, shared_tmp_path, 0.04)
    before = lines(comm, shared_tmp_path / "run.log")
    comm.barrier()
    data = Checkpoints(rotor, shared_tmp_path / "checkpoints").load()
    simulate(rotor, shared_tmp_path, 0.06, data, append=True)
    found = lines(comm, shared_tmp_path / "run.log")
    assert found[: len(before)] == before
    assert found[len(before)] == "resumed at t = 0.04 s"
    (step,) = (line for line in found[len(before) :] if line.startswith("step"))
    assert step.startswith("step 3 t = 0.06 s dt = 0.02 s, ")


def test_a_new_run_begins_a_new_log(comm, rotor, shared_tmp_path):
    for _ in range(2):
        simulate(rotor, shared_tmp_path, 0.02)
        found = lines(comm, shared_tmp_path / "run.log")
        assert [line.startswith("begin") for line in found].count(True) == 1
        comm.barrier()


def test_logging_ends_with_the_run(comm, shared_tmp_path):
    before = (PACKAGE.level, list(PACKAGE.handlers))
    with (
        pytest.raises(RuntimeError),
        log_to_file(comm, shared_tmp_path / "run.log", False),
    ):
        raise RuntimeError
    assert (PACKAGE.level, PACKAGE.handlers) == before


def test_a_full_disk_is_no_reason_to_stop(comm, rotor, shared_tmp_path, capfd):
    """What the log has no room for is lost, the run is not."""
    if comm.rank == 0:
        (shared_tmp_path / "run.log").symlink_to("/dev/full")
    comm.barrier()
    raised = None
    try:
        simulate(rotor, shared_tmp_path, 0.04)
    except OSError as error:
        raised = str(error)
    assert comm.allgather(raised) == [None] * comm.size
    assert not PACKAGE.handlers
    assert capfd.readouterr().err == ""


def test_a_log_that_cannot_be_opened_is_refused_on_all_ranks(comm, shared_tmp_path):
    if comm.rank == 0:
        (shared_tmp_path / "run.log").mkdir()
    comm.barrier()
    raised = None
    try:
        with log_to_file(comm, shared_tmp_path / "run.log", False):
            PACKAGE.info("hello")
    except InputError as error:
        raised = str(error)
    except OSError as error:
        raised = repr(error)
    finally:
        messages = comm.allgather(raised)
    assert not PACKAGE.handlers
    (message,) = set(messages)
    assert message is not None and message.startswith("cannot write ")

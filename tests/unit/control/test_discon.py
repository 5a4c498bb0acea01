"""Bladed-style libraries: what ROSCO answers, and what goes wrong with files and libraries."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
from patience import patience
from rosco_files import rosco_files

from turbine_fenicsx.control import discon
from turbine_fenicsx.control.discon import Discon, check_library
from turbine_fenicsx.control.foreign import ForeignController
from turbine_fenicsx.control.interface import Measurements
from turbine_fenicsx.foundation.errors import InputError

RATED = 122.9096
FAKE = """
#include <stdio.h>
#include <stdlib.h>
#include <math.h>
#include <unistd.h>
void DISCON(float *swap, int *fail, const char *in, const char *out, char *message) {{
    {body}
}}
"""


@pytest.fixture(scope="module")
def nrel():
    """Library of ROSCO and its input for the NREL 5 MW turbine."""
    return rosco_files()


def make_library(folder, body):
    """A library with the body of its routine in C."""
    source, library = folder / "fake.c", folder / "fake.so"
    source.write_text(FAKE.format(body=body))
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
    infile = folder / "fake.in"
    infile.write_text("1\n")
    return library, infile


def measure(time, speed=RATED, first=False):
    return Measurements(
        time, 0.05, first, speed, speed / 97.0, 0.0, (0.07,) * 3, 40000.0, 5e6, 12.0
    )


SPEEDS = RATED + np.sin(0.1 * np.arange(60))


def test_rosco_pitches_when_the_rotor_is_too_fast(nrel, tmp_path):
    controller = Discon(*nrel, tmp_path / "controller")
    first = controller.respond(measure(0.0, first=True))
    assert np.isclose(first.generator_torque, 43093.5) and np.allclose(first.pitch, 0.07)
    for k in range(1, 40):
        commands = controller.respond(measure(0.05 * k, RATED + 3.0))
    controller.finish()
    assert commands.pitch[0] > 0.08
    assert (tmp_path / "controller" / "control.RO.dbg").exists()
    assert "ROSCO" in (tmp_path / "controller" / "library.log").read_text()
    assert not list(Path.cwd().glob("*.RO.*"))


@pytest.mark.parallel
def test_a_controller_that_was_shown_all_again_goes_on_bit_for_bit(nrel, comm, shared_tmp_path):
    def make(name):
        return ForeignController(comm, lambda: Discon(*nrel, shared_tmp_path / name), "ROSCO")

    one, other = make("one"), make("other")
    answers = [one.command(measure(0.05 * k, w, k == 0)) for k, w in enumerate(SPEEDS)]
    half = ForeignController(comm, lambda: Discon(*nrel, shared_tmp_path / "half"), "ROSCO")
    for k, w in enumerate(SPEEDS[:30]):
        half.command(measure(0.05 * k, w, k == 0))
    other.restore(half.save())
    again = [other.command(measure(0.05 * k, w)) for k, w in enumerate(SPEEDS) if k >= 30]
    assert again == answers[30:]
    for each in (one, half, other):
        each.finish()


def test_a_missing_table_ends_the_library_but_not_the_run(nrel, tmp_path):
    """The input names a table of the rotor, without which Fortran stops."""
    infile = tmp_path / "DISCON.IN"
    infile.write_text(nrel[1].read_text())
    controller = Discon(nrel[0], infile, tmp_path)
    with pytest.raises(InputError, match=r"ends its process at t = 0 s: .*Cp_Ct_Cq.NREL5MW.txt"):
        controller.respond(measure(0.0, first=True))


def test_what_the_library_refuses_is_told_in_its_words(nrel, tmp_path):
    infile = tmp_path / "DISCON.IN"
    infile.write_text("nothing\n")
    controller = Discon(nrel[0], infile, tmp_path)
    with pytest.raises(InputError, match=r"stops at t = 0 s: ROSCO:SetParameters.*F_LPFCornerFreq"):
        controller.respond(measure(0.0, first=True))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("swap[46] = NAN;", "'fake' commands no number as generator torque at t = 0 s"),
        ("abort();", r"crashes \(SIGABRT\) at t = 0 s"),
        ('fprintf(stderr, "no licence\\n"); exit(0);', "ends its process at t = 0 s: no licence"),
        ('*fail = -1; sprintf(message, "too fast");', "stops at t = 0 s: too fast"),
        ("swap[46] = 3e38;", r"'fake' commands a generator torque of 3e\+38 N m at t = 0 s"),
        ("swap[42] = 1e30;", r"'fake' commands a pitch of 1e\+30 rad at t = 0 s: expected"),
        ("*fail = -1;", "stops at t = 0 s: it does not say why"),
        ("sleep(30);", "has not answered within 0.5 s at t = 0 s"),
    ],
)
def test_libraries_that_fail_are_sentences(body, message, tmp_path, monkeypatch):
    monkeypatch.setattr(discon, "PATIENCE", 0.5 if "sleep" in body else 60.0)
    files = make_library(tmp_path, body)
    controller = ForeignController(MPI.COMM_SELF, lambda: Discon(*files, tmp_path), "'fake'")
    with pytest.raises(InputError, match=message):
        controller.command(measure(0.0, first=True))
    controller.finish()


def test_records_are_those_of_bladed(tmp_path):
    """Torque is the sum of what it was told, pitch the status of the call."""
    body = """
        swap[46] = swap[1] + swap[2] + swap[19] + swap[20] + swap[60];
        swap[41] = swap[42] = swap[43] = swap[0];
        swap[47] = swap[3] + swap[32] + swap[33];
    """
    controller = Discon(*make_library(tmp_path, body), tmp_path)
    torque, pitch, rate, brake = controller.respond(measure(2.0, first=True))
    assert np.isclose(torque, 2.0 + 0.05 + RATED + RATED / 97.0 + 3.0, rtol=1e-6)
    assert pitch == (0.0, 0.0, 0.0) and np.isclose(rate, 0.21) and brake == 0.0
    assert controller.respond(measure(2.05)).pitch == (1.0, 1.0, 1.0)
    controller.finish()


def test_ctrl_c_for_the_run_leaves_the_library_alone(tmp_path):
    controller = Discon(*make_library(tmp_path, "swap[46] = 1.0;"), tmp_path)
    assert os.getpgid(controller._child.pid) != os.getpgrp()
    controller.respond(measure(0.0, first=True))
    os.kill(controller._child.pid, signal.SIGKILL)
    controller._child.wait()  # so that the request already finds nobody
    with pytest.raises(InputError, match=r"crashes \(SIGKILL\) at t = 0.05 s"):
        controller.respond(measure(0.05))


def test_files_that_are_missing_or_wrong_are_sentences(tmp_path):
    library, infile = make_library(tmp_path, "swap[46] = 0.0;")
    gone, text = tmp_path / "gone", tmp_path / "text"
    text.write_text("")
    assert check_library(library, infile) == ""
    assert check_library(gone, infile) == f"control.library = '{gone}': there is no such file"
    assert check_library(library, gone) == f"control.input = '{gone}': there is no such file"
    assert check_library(infile, infile).endswith("is no shared library of Linux")
    assert check_library(library, text).endswith("the file is empty")
    with pytest.raises(InputError, match="there is no such file"):
        Discon(gone, infile, tmp_path)


def test_a_library_without_the_routine_is_a_sentence(tmp_path):
    _, infile = make_library(tmp_path, "swap[46] = 0.0;")
    source, library = tmp_path / "other.c", tmp_path / "other.so"
    source.write_text("void OTHER(void) {}")
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
    with pytest.raises(InputError, match=r"cannot be loaded: .*undefined symbol: DISCON"):
        Discon(library, infile, tmp_path).respond(measure(0.0, first=True))


def test_warnings_of_the_library_are_shown_once_for_each_text(tmp_path, caplog):
    body = """
        static int calls = 0;
        *fail = 1;
        sprintf(message, calls++ % 2 ? "pitch is\\nslow" : "too cold");
    """
    controller = Discon(*make_library(tmp_path, body), tmp_path)
    for k in range(6):
        controller.respond(measure(0.05 * k, first=k == 0))
    controller.finish()
    texts = [r.getMessage().partition(" warns at t = ")[2] for r in caplog.records]
    assert texts == ["0 s: too cold", "0.05 s: pitch is slow"]
    assert {r.levelname for r in caplog.records} == {"WARNING"}


def test_a_library_that_puts_numbers_into_its_warnings_is_cut_short(tmp_path, caplog):
    body = '*fail = 1; sprintf(message, "t = %g", swap[1]);'
    controller = Discon(*make_library(tmp_path, body), tmp_path)
    for k in range(50):
        controller.respond(measure(0.05 * k, first=k == 0))
    controller.finish()
    assert len(caplog.records) == discon.MOST_WARNINGS + 1
    assert caplog.records[-1].getMessage().endswith("warns of more, which is not shown")


def test_contactor_and_brake_are_obeyed(tmp_path):
    """Records 35 and 36; who does not touch them has the contactor closed and the brake open."""
    body = """
        swap[46] = 100.0;
        if (swap[1] > 0.07) swap[34] = 0.0;
        if (swap[1] > 0.12) swap[35] = 1.0;
    """
    controller = Discon(*make_library(tmp_path, body), tmp_path)
    found = [controller.respond(measure(0.05 * k, first=k == 0)) for k in range(4)]
    controller.finish()
    assert [c.generator_torque for c in found] == [100.0, 100.0, 0.0, 0.0]
    assert [c.brake for c in found] == [0.0, 0.0, 0.0, 1.0]


def test_noise_on_any_descriptor_is_no_command(tmp_path):
    """Whole packets too, of the size of a reply, before and after it."""
    body = """
        static char noise[4096];
        for (int i = 0; i < 4096; i++) noise[i] = 'x';
        for (int fd = 0; fd < 64; fd++) { write(fd, noise, 48); write(fd, noise, 4096); }
        swap[46] = 7.0;
    """
    controller = Discon(*make_library(tmp_path, body), tmp_path)
    for k in range(3):
        commands = controller.respond(measure(0.05 * k, first=k == 0))
        assert commands == (7.0, (0.0, 0.0, 0.0), 0.0, 0.0)
    controller.finish()
    assert "xxxx" in (tmp_path / "library.log").read_text()


LOOP = """
import sys
from pathlib import Path
from turbine_fenicsx.control.discon import Discon
from turbine_fenicsx.control.interface import Measurements
library, infile, folder = map(Path, sys.argv[1:])
controller = Discon(library, infile, folder)
print(controller._child.pid, flush=True)
controller.respond(Measurements(0.0, 0.05, True, 1.0, 1.0, 0.0, (0.0,) * 3, 0.0, 0.0))
"""


def is_alive(pid):
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_a_library_that_loops_dies_with_the_run(tmp_path):
    body = 'fclose(fopen("begun", "w")); for (volatile int i = 0;; i++) {}'
    files = make_library(tmp_path, body)
    command = [sys.executable, "-c", LOOP, *map(str, files), str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as run:
        pid = int(run.stdout.readline())
        assert wait_until((tmp_path / "begun").exists)
        assert is_alive(pid)
        run.kill()
        run.wait()
        gone = wait_until(lambda: not is_alive(pid))
    if not gone:
        os.kill(pid, signal.SIGKILL)
    assert gone


def wait_until(condition, seconds=30.0):
    """Whether a condition is met in time."""
    deadline = time.monotonic() + patience(seconds)
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.02)
    return condition()


def test_a_child_whose_parent_has_ended_before_ends_itself(tmp_path):
    script = discon.discon_child.__file__
    files = [str(path) for path in make_library(tmp_path, "swap[46] = 1.0;")]
    one, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with one, other:
        command = [sys.executable, "-I", script, *files, "x", str(other.fileno()), "1"]
        result = subprocess.run(command, pass_fds=(other.fileno(),), timeout=patience(30.0))
    assert result.returncode == 0

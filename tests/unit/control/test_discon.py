"""Bladed-style libraries: what ROSCO answers, and what goes wrong with files and libraries."""

import os
import signal
import subprocess
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
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

"""The command ``damping``: what it prints, writes and refuses."""

import csv

import pytest
from beam_turbines import write_beam_case

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.records import names
from turbine_fenicsx.records.damping_tables import DAMPING, read_decay, read_work

pytest.importorskip("slepc4py")
EVEN = (
    "turbine.hub.centre=[0.0, 0.0, 0.0]",
    "turbine.hub.inertia=[900.0, 900.0, 1500.0, 0.0, 0.0, 0.0]",
    "tower.flexible=false",
)
FLAP = "first flap, collective"
OPTIONS = ("--wind", "9", "--count", "4", "--lock", "yaw")


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Path of a case whose rotor is the same at every azimuth."""
    return write_beam_case(tmp_path_factory.mktemp("beams"))


def test_three_ways_agree_and_steps_that_dissipate_show(case, capfd):
    out = case.parent / "out"
    command = ["damping", str(case), *OPTIONS, "--mode", FLAP, "--cycles", "2", "-o", str(out)]
    assert main([*command, "--set", *EVEN, "time.step=0.01"]) == 0
    printed = capfd.readouterr()
    assert f"{FLAP}: two runs of " in printed.err
    assert printed.out.startswith(f"{FLAP} at 9 m/s, ")
    assert "  work: air " in printed.out and "damping.csv, decay.csv, work.csv, " in printed.out
    # the case dissipates numerically, so nothing is undone
    assert "steps undone" not in printed.out
    with (out / DAMPING).open() as file:
        (row,) = csv.DictReader(file)
    rates = {
        source: float(row[names.DECAY_RATE(source=source)])
        for source in ("eigenvalue", "run", "air", "structure", "drive")
    }
    assert rates["run"] > 1.03 * rates["eigenvalue"]
    parts = rates["air"] + rates["structure"] + rates["drive"]
    assert parts == pytest.approx(rates["eigenvalue"], rel=1e-9)
    assert len(read_decay(out)[names.TIME]) > 50 and len(read_work(out)[names.RADIUS]) == 8
    assert (out / "damping.png").stat().st_size > 20000
    assert main(command) == 2
    assert "holds dampings; --overwrite replaces them" in capfd.readouterr().err


def test_a_mode_that_is_not_there_is_refused_with_those_that_are(case, capfd):
    command = ["damping", str(case), *OPTIONS, "--mode", "99", "--set", *EVEN]
    assert main(command) == 2
    assert "--mode 99: no such mode at 9 m/s, but 1 first flap" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--wind", "8,9"), "--wind 8,9: give one wind speed"),
        (("--wind", "9", "--kick", "3"), "--kick 3: give a velocity above 0 and up to 10 m/s"),
        (("--wind", "9", "--cycles", "0"), "--cycles 0: must be from 0.5 to 1000"),
        (("--wind", "9", "--amplitude", "x"), "--amplitude x: give an angle from 0 to 5 deg"),
        (("--wind", "9", "--count", "0"), "--count 0: must be at least 1"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(case, options, words, capfd):
    assert main(["damping", str(case), "--mode", "1", *options]) == 2
    assert words in capfd.readouterr().err

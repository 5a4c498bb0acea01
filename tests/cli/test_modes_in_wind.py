"""The command ``modes --wind``: what it prints, writes, leaves out and refuses."""

import csv

import numpy as np
import pytest
from beam_turbines import CONTROLLED, write_beam_case
from reduced_turbines import COMM, write_case

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import read_campbell
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.modes.mode_files import ModeTable, Place
from turbine_fenicsx.turbine.modes.mode_table import ModeRow
from turbine_fenicsx.turbine.modes.wind_modes import (
    WindModesWanted,
    find_flutter,
    find_wind_modes,
)

pytest.importorskip("slepc4py")
EVEN = (
    "turbine.hub.centre=[0.0, 0.0, 0.0]",
    "turbine.hub.inertia=[900.0, 900.0, 1500.0, 0.0, 0.0, 0.0]",
    "tower.model=beam",
)
OPTIONS = ("--wind", "8,9,10", "--count", "8", "--lock", "yaw", "--set", *EVEN)


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Path of a case whose rotor is the same at every azimuth."""
    return write_beam_case(tmp_path_factory.mktemp("beams"))


@pytest.fixture(scope="module")
def found(case):
    """Folder with modes at three wind speeds, and what was printed."""
    out = case.parent / "out"
    assert main(["modes", str(case), *OPTIONS, "-o", str(out), "--quiet"]) == 0
    return out


def read(out, name):
    with (out / name).open() as file:
        return list(csv.DictReader(file))


def test_tables_have_the_modes_at_each_wind(found):
    rows = read(found, "modes.csv")
    winds = [float(row[names.WIND_SPEED]) for row in rows]
    assert winds == np.repeat([8.0, 9.0, 10.0], 8).tolist()
    for first in range(0, 24, 8):
        here = rows[first : first + 8]
        assert len({row["name"] for row in here}) == 8
        assert len({row[names.PITCH] for row in here}) == 1
        assert [row["mode"] for row in here] == [str(k) for k in range(1, 9)]
    by_name = {row["name"]: float(row[names.DAMPING_RATIO]) for row in rows[8:16]}
    flap = [x for name, x in by_name.items() if name.startswith("first flap")]
    edge = [x for name, x in by_name.items() if name.startswith("first edge")]
    assert flap and edge and min(flap) > max(edge) > 0.0


def test_the_diagram_is_over_the_wind(found):
    branches = read_campbell(found / "campbell.csv")
    assert len(branches) == 8 and (found / "campbell.png").stat().st_size > 20000
    assert branches[0].places.tolist() == [8.0, 9.0, 10.0]
    # modes keep their numbers from wind to wind
    for branch in branches:
        assert np.max(np.abs(np.diff(branch.frequencies))) < 0.2 * np.max(branch.frequencies)


def test_a_page_reports_them(found, capfd):
    assert main(["report", str(found), "--no-pictures"]) == 0
    page = (found / "report.html").read_text()
    assert "Modes at 10 m/s" in page and "over the wind speed" in page


def test_the_screen_tells_the_least_damping_and_what_is_left_out(case, capfd):
    assert main(["modes", str(case), *OPTIONS[:2], "--count", "4", *OPTIONS[4:]]) == 0
    printed = capfd.readouterr()
    lines = [line for line in printed.err.splitlines() if line.startswith("wind ")]
    assert len(lines) == 3 and lines[1].startswith("wind 2 of 3: 9 m/s, ")
    assert all(": least damping " in line for line in lines)
    assert (
        "modes in wind are those in uniform wind along the shaft: the weight, wind.shear"
        in printed.err
    )
    assert printed.out.startswith("modes at 10 m/s, ") and "seen from the ground" in printed.out


def test_a_wake_that_stays_and_lift_without_delay_change_the_damping(case):
    given = Case.load(case, EVEN)
    dampings = []
    for air in ({}, {"frozen_wake": True}, {"quasi_steady": True}):
        wanted = WindModesWanted((9.0,), 6, locked=("yaw",), **air)
        (table,), _ = find_wind_modes(given, None, COMM, wanted)
        dampings.append({row.name: row.damping_ratio for row in table.rows})
    for other in dampings[1:]:
        changes = [abs(other[name] / damping - 1.0) for name, damping in dampings[0].items()]
        assert 1e-4 < max(changes) < 0.5


def test_a_controller_takes_part(case, capfd):
    out = case.parent / "controlled"
    options = ("--controller", "--wind", "9,12", *OPTIONS[2:], *CONTROLLED, "-o", str(out))
    assert main(["modes", str(case), *options]) == 0
    printed = capfd.readouterr()
    assert "the controller" not in printed.err
    assert printed.out.count("speed of the rotor") == 1
    below, above = (row for row in read(out, "modes.csv") if row["name"] == "speed of the rotor")
    # the pitch keeps the speed from rated wind on; below, generator and wind balance each other
    assert float(below[names.SPEED]) < 9.5 < float(above[names.SPEED]) < 9.55
    assert float(below[names.PITCH]) == pytest.approx(np.degrees(0.35))
    assert float(above[names.PITCH]) > 21.0
    for row in (below, above):
        assert row["mode"] == "9" and float(row[names.FREQUENCY]) < 0.2
        assert 0.1 < float(row[names.DAMPING_RATIO]) <= 1.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--frozen-wake",), "--frozen-wake needs --wind"),
        (("--schedule", "x.csv"), "--schedule needs --wind"),
        (("--keep-power", "--flutter", "7:9:1 rpm"), "--keep-power needs --wind"),
        (("--controller",), "--controller needs --wind"),
        (("--controller", "--wind", "9", "--schedule", "x.csv"), "--controller and --schedule: "),
        (("--controller", *OPTIONS), "are known: control.kind = \"pi\", got 'none'"),
        (("--flutter", "0:9:1 rpm"), "--flutter 0:9:1 rpm: the rotor must turn"),
        (("--flutter", "7:9"), "--flutter 7:9: give START:END:STEP and rpm"),
        (("--amplitude", "9 deg", "--wind", "9"), "--amplitude 9 deg: give an angle from 0 to 5"),
        (("--wind", "0:3:1"), "--wind 0:3:1: give START:END:STEP or wind speeds that rise"),
        (("--wind", "9", "--set", *EVEN[:2]), "modes in wind need a tower that moves by few"),
        (("--wind", "9", "--set", EVEN[2]), "rigid body 'hub' has no equal 1/3 of a revolution"),
        (("--wind", "9", "--schedule", "none.csv"), "none.csv"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(case, options, words, capfd):
    capfd.readouterr()
    assert main(["modes", str(case), *options]) == 2
    assert words in capfd.readouterr().err


def test_a_rotor_that_no_wind_turns_is_refused(case, capfd):
    options = ("--flutter", "25:30:5", "rpm", "--count", "4", *OPTIONS[4:])
    assert main(["modes", str(case), *options]) == 3
    printed = capfd.readouterr().err
    assert "no wind lets the rotor turn freely at 2.618 rad/s and this pitch: at " in printed
    assert "there are modes at none of the places" in printed


def test_modes_that_begin_to_grow_are_found_between_speeds():
    def table(speed, *dampings):
        rows = [ModeRow(1.0 + k, x, 0.0, f"mode {k}", {}, {}) for k, x in enumerate(dampings)]
        return ModeTable(Place(speed, 5.0, 0.0, True), tuple(rows))

    tables = [
        table(1.0, 0.04, 0.02, -0.1),
        table(2.0, 0.03, -0.02, -0.1),
        table(3.0, -0.01, 0.0, 0.0),
    ]
    (first, row), (second, other) = find_flutter(tables)
    assert (row.name, other.name) == ("mode 1", "mode 0")
    assert (first, second) == pytest.approx((1.5, 2.75))
    assert find_flutter(tables[:1]) == []


def test_full_blades_are_refused(tmp_path, capfd):
    command = ["modes", str(write_case(tmp_path)), "--wind", "9", "--set", "blade.model=full"]
    assert main(command) == 2
    assert "modes in wind need blades that move by few functions" in capfd.readouterr().err


def test_a_schedule_without_the_wind_leaves_it_out(case, capfd):
    table = case.parent / "schedule.csv"
    table.write_text(f"{names.WIND_SPEED},{names.ROTOR_SPEED},{names.PITCH}\n8,25,0\n9,26,1\n")
    options = ("--wind", "9,10", "--count", "3", "--lock", "yaw", "--set", *EVEN)
    assert main(["modes", str(case), "--schedule", str(table), *options]) == 0
    assert "no modes at 10 m/s: " in capfd.readouterr().err

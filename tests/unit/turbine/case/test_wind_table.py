"""Claims about wind over the time from a file."""

import numpy as np
import pytest
from aero_files import write_aerodyn
from case_mistakes import mistakes

from turbine_fenicsx import run_case
from turbine_fenicsx.foundation.errors import InputError, ModelError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import E1, E2, E3
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import make_inflow
from turbine_fenicsx.turbine.case.wind_checks import describe_aerodynamics
from turbine_fenicsx.wind.inflow import SteadyWind
from turbine_fenicsx.wind.tabulated_wind import TabulatedWind, read_uniform_wind

RIGID = {"model": "rigid", "rotor_speed": "11 rpm"}
CSV = "time [s], speed [m/s], direction [deg]\n0, 8, 0\n10, 12, 30\n20, 12, 30\n"
HUB = "! steady, then a gust from the right\n0 10 0 0 0 0.2 0 0\n10 10 -20 1 0.1 0.2 0.3 2\n"


@pytest.fixture
def write(comm, tmp_path_factory):
    """Writes the aerodynamics and a file of wind; a function that makes tables of a case."""
    folder = on_rank0(comm, lambda: tmp_path_factory.mktemp("wind"))
    aero = on_rank0(comm, lambda: str(write_aerodyn(folder)))

    def tables(text, name, **wind):
        on_rank0(comm, lambda: (folder / name).write_text(text))
        wind = {"file": str(folder / name), "hub_height": 90.0, **wind}
        time = {"step": 0.05, "end": 1.0}
        output = {"fields_every": 0}
        return {
            **{"turbine": RIGID, "wind": wind, "aero": {"file": aero, "stations": 8}},
            **{"time": time, "output": output, "pitch": {"drive": "prescribed"}},
        }

    return tables


def test_speed_and_direction_follow_the_table_and_the_rest_the_case(write):
    given = Case.parse(write(CSV, "w.csv", shear=0.3))
    assert given.warnings == []
    wind = make_inflow(given)
    at_hub = wind.velocity(np.zeros(3), 5.0)
    angle = np.radians(15.0)
    assert at_hub == pytest.approx(10.0 * (np.cos(angle) * E3 + np.sin(angle) * E1))
    low = wind.velocity(-45.0 * E2, 0.0)
    assert low == pytest.approx(8.0 * 0.5**0.3 * E3)
    assert wind.velocity(-91.0 * E2, 0.0) == pytest.approx(np.zeros(3))


def test_a_constant_table_is_the_steady_wind():
    times = np.array([0.0, 1.0])
    columns = {"speed": 9.0, "shear": 0.14, "direction": 0.2, "inclination": 0.1}
    table = TabulatedWind(times, {k: 0 * times + v for k, v in columns.items()}, 90.0, 120.0)
    steady = SteadyWind(9.0, 90.0, 0.14, 0.2, 0.1)
    places = np.random.default_rng(1).uniform(-100, 150, (50, 3))
    assert table.velocity(places, 0.4) == pytest.approx(steady.velocity(places, 0.4), abs=1e-13)


def test_openfast_files_have_the_formula_of_inflowwind(write):
    given = Case.parse(write(HUB, "gust.wnd"))
    wind = make_inflow(given)
    R = given.blade.hub_radius + given.blade.length
    # downwind, left, up of OpenFAST
    x, y, z = 3.0, 40.0, 120.0
    angle = np.radians(-20.0)
    left = y * np.cos(angle) + x * np.sin(angle)
    linear = (0.1 * left + 0.3 * (z - 90.0)) / (2.0 * R)
    V = 10.0 * ((z / 90.0) ** 0.2 + linear) + 2.0
    expected = np.array([V * np.cos(angle), -V * np.sin(angle), 1.0])
    place = y * E1 + (z - 90.0) * E2 + x * E3
    found = wind.velocity(place, 10.0)
    assert found @ np.array([E3, E1, E2]).T == pytest.approx(expected)
    assert wind.velocity(np.zeros(3), 0.0) == pytest.approx(10.0 * E3)


@pytest.mark.parametrize(
    ("name", "text", "sign"),
    [
        ("w.csv", "time [s], speed, direction [deg]\n0, 10, 350\n10, 10, 10\n20, 10, 180\n", 1.0),
        ("w.wnd", "0 10 350 0 0 0.2 0 0\n10 10 10 0 0 0.2 0 0\n20 10 180 0 0 0.2 0 0\n", -1.0),
    ],
)
def test_directions_turn_the_short_way(write, name, text, sign):
    wind = make_inflow(Case.parse(write(text, name)))
    for time, direction in ((2.5, -5.0), (5.0, 0.0), (7.5, 5.0), (15.0, 95.0)):
        angle = sign * np.radians(direction)
        expected = 10.0 * (np.cos(angle) * E3 + np.sin(angle) * E1)
        assert wind.velocity(np.zeros(3), time) == pytest.approx(expected, abs=1e-12)


def test_an_upflow_angle_may_be_the_ninth_number(tmp_path):
    path = tmp_path / "up.hh"
    path.write_text("# OpenFAST 3\n0, 10, 5, 0, 0, 0.1, 0, 0, 8\n")
    times, columns = read_uniform_wind(path)
    assert times.tolist() == [0.0]
    assert columns["inclination"] == pytest.approx([np.radians(8.0)])
    assert columns["direction"] == pytest.approx([np.radians(-5.0)])


def test_keys_that_the_file_has_are_without_effect(write):
    csv = Case.parse(write(CSV, "w.csv", direction="5 deg", shear=0.1))
    assert csv.warnings == ["wind.direction has no effect beside wind.file, which has its own"]
    hub = Case.parse(write(HUB, "w.wnd", direction="5 deg", shear=0.1, inclination="3 deg"))
    assert hub.warnings == [
        f"wind.{key} has no effect beside wind.file, which has its own"
        for key in ("shear", "direction")
    ]


@pytest.mark.parametrize(
    ("text", "name", "sentence"),
    [
        ("time,direction\n0,1\n9,1\n", "w.csv", "w.csv has no column speed, the wind at the heigh"),
        ("time,sped\n0,1\n9,1\n", "w.csv", "w.csv has an unknown column 'sped', expected time and"),
        ("time,speed\n0,1\n9,-1\n", "w.csv", "w.csv, line 3: speed = -1 m/s must lie between 0 an"),
        (
            "time,speed\n0,1\n0.9,1\n",
            "w.csv",
            "w.csv goes from 0 to 0.9 s, expected times from 0 t",
        ),
        ("0 8 0 0 0 0.2 0\n", "w.wnd", "w.wnd, line 1: expected 8 or 9 finite numbers, time, "),
        ("0 8 0 0 0 0 0 0\n1 8 0 0 0 0 0 x\n", "w.hh", "w.hh, line 2: expected 8 or 9 finite num"),
        ("1 8 0 0 0 0 0 0\n1 8 0 0 0 0 0 0\n", "w.wnd", "w.wnd, line 2: times must rise, got 1 s"),
        ("0 -8 0 0 0 0 0 0\n", "w.wnd", "w.wnd, line 1: speed = -8 must lie between 0 and 200"),
        ("0 8 0 0 0 3 0 0\n", "w.wnd", "w.wnd, line 1: shear = 3 must lie between -1 and"),
        ("0 8 0 0 0 0 0 1e9\n", "w.wnd", "w.wnd, line 1: gust = 1e+09 must lie between -200 and 2"),
        ("! nothing\n", "w.wnd", "w.wnd holds no wind, expected lines of 8 or 9 numbers"),
        ("0 8 0 0 0 0.2 0 0\n", "w.wnd", "w.wnd goes from 0 to 0 s, expected times from 0 to time"),
    ],
)
def test_a_wrong_file_is_one_sentence(write, text, name, sentence):
    (found,) = mistakes(write(text, name))
    assert found.startswith(f"wind.file: {sentence}")


def test_a_table_of_wind_needs_a_speed_and_numbers_that_fit():
    times = np.array([0.0, 1.0])
    for columns in ({}, {"speed": times, "sped": times}, {"speed": np.zeros(3)}):
        with pytest.raises(ModelError, match="table of wind needs"):
            TabulatedWind(times, columns, 90.0, 120.0)
    with pytest.raises(ModelError, match="must rise"):
        TabulatedWind(times[::-1], {"speed": times}, 90.0, 120.0)


@pytest.mark.parallel
def test_a_run_in_a_table_of_wind_keeps_its_balance(comm, write, tmp_path_factory):
    given = Case.parse(write(CSV, "w.csv"))
    assert (
        describe_aerodynamics(given)[0] == "wind of 'w.csv', 8 to 12 m/s in 3 lines from 0 to 20 s"
    )
    folder = on_rank0(comm, lambda: tmp_path_factory.mktemp("run"))
    summary = run_case(given, folder, comm, progress="none")
    assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]
    lines = [x.split() for x in (folder / "history.out").read_text().splitlines()]
    names = next(x for x in lines if x[:1] == ["Time"])
    assert float(lines[-1][names.index("Wind1VelX")]) == pytest.approx(8.4 * np.cos(np.radians(3)))
    text = (folder / "case.json").read_text()
    assert "w.csv" in text


def test_a_file_that_cannot_be_read_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match="cannot read the wind file"):
        read_uniform_wind(tmp_path / "none.wnd")

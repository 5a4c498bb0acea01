"""Claims about the command that writes the turbulence of a case for other programs."""

import pytest
from aero_files import write_aerodyn

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.inflow import load_box
from turbine_fenicsx.wind.turbsim import read_turbsim

CASE = """
[turbine]
model = "rigid"
[aero]
file = "rotor.dat"
[wind]
speed = "10 m/s"
hub_height = "90 m"
turbulence = {model = "mann", points = 4, time_step = "1 s", duration = "60 s"}
"""


@pytest.fixture
def case(tmp_path):
    write_aerodyn(tmp_path)
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


def test_it_writes_the_wind_of_a_run_in_both_formats(case, tmp_path, capsys):
    bts, box = tmp_path / "a.bts", tmp_path / "b.bin"
    for out in (bts, box):
        assert main(["wind", str(case), "-o", str(out)]) == 0
    shown = capsys.readouterr()
    assert "60 x 4 x 4 points, 10 x 43.125 x 43.125 m, a plane every 1 s" in shown.out
    assert "10 m/s at 90 m, standard deviations" in shown.out
    assert "turbulence by Mann's model" in shown.err and shown.err.count("is kept in") == 1
    wind = load_box(Case.load(case))
    place = [[0.0, 21.5, 68.4]]
    assert read_turbsim(bts).velocity(place, 7.0) == pytest.approx(
        wind.velocity(place, 7.0), abs=1e-3
    )
    files = [str(tmp_path / f"b_{k}.bin") for k in "uvw"]
    read = case.with_name("read.toml")
    table = f"box = {{files = {files}, points = [60, 4, 4], spacing = [10, 43.125, 43.125]}}"
    read.write_text(CASE[: CASE.index("turbulence")] + table)
    again = load_box(Case.load(read))
    assert again.velocity(place, 7.0) == pytest.approx(wind.velocity(place, 7.0), abs=1e-6)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["-o", "a.txt"], "--out a.txt: expected a name that ends with .bts or .bin"),
        (["-o", "nowhere/a.bts"], "cannot write 'nowhere/a.bts': 'nowhere' is no folder that"),
        (["-o", "case.bts"], "'case.bts' is there already: --overwrite replaces it"),
        (
            ["-o", "a.bts", "--set", "wind={speed = 8}"],
            'wind.turbulence.model = "none": expected one, to have turbulence to write',
        ),
    ],
)
def test_what_it_cannot_do_is_said(case, monkeypatch, capsys, arguments, sentence):
    monkeypatch.chdir(case.parent)
    case.with_name("case.bts").touch()
    assert main(["wind", "case.toml", *arguments]) == 2
    assert f"error: {sentence}" in capsys.readouterr().err

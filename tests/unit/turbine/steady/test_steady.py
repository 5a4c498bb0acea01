"""Claims about steady states: found speed and pitch, loads of free bodies, tables and refusals."""

import csv
import logging
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
import yaml
from aero_files import write_aerodyn

from turbine_fenicsx.cli.commands.steady import parse_winds
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.steady_plots import OVER_WIND, choose_columns, plot_steady
from turbine_fenicsx.records.steady_tables import read_steady
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.rotor_air import WIND
from turbine_fenicsx.turbine.steady.find_steady import find_steady
from turbine_fenicsx.turbine.steady.operating_states import (
    RPM,
    OperatingState,
    find_schedule,
    read_schedule,
)
from turbine_fenicsx.turbine.steady.steady_results import SteadyReader
from turbine_fenicsx.turbine.steady.steady_turbine import SteadyTurbine
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_performance

COMM = MPI.COMM_WORLD
DEMOS = Path(__file__).parents[4] / "demos"
WINDS = (6.0, 7.0, 18.0)
CONTROLLED = {
    "drivetrain": {"model": "stiff", "ratio": 97.0, "generator_inertia": 500.0},
    "control": {"kind": "pi"},
}


def make_case(folder, model="rigid", **tables):
    turbine = {"model": model, **tables.pop("turbine", {})}
    wind = {"speed": 9.0, "shear": 0.0, "hub_height": 90.0, **tables.pop("wind", {})}
    pitch = {"bearings": True, "drive": "actuator"}
    if model == "rigid":
        del pitch["bearings"]
    aero = {"file": str(write_aerodyn(folder)), "stations": 8}
    return Case.parse({"turbine": turbine, "wind": wind, "aero": aero, "pitch": pitch, **tables})


@pytest.fixture(scope="module")
def rigid(tmp_path_factory):
    """Case, folder and steady states of stiff blades with the controller of the 5 MW turbine."""
    folder = tmp_path_factory.mktemp("steady")
    case = make_case(folder, loads={"gravity": 0.0}, **CONTROLLED)
    return case, folder / "out", find_steady(case, folder / "out", COMM, WINDS)


def test_stiff_blades_have_power_and_thrust_of_the_steady_rotor(rigid):
    case, _, states = rigid
    rotor = Rotor(load_aero_blade(case), hub_height=90.0)
    for state in states:
        o, n = state.operating, state.numbers
        steady = find_performance(rotor, Operation(o.wind, o.rotor_speed, o.pitch), sectors=1)
        assert n["aero_power_[W]"] == pytest.approx(steady.power, rel=1e-8)
        assert n["aero_thrust_[N]"] == pytest.approx(steady.thrust, rel=1e-8)
        assert n["power_coefficient_[-]"] == pytest.approx(steady.power_coefficient, rel=1e-8)
        assert n["thrust_coefficient_[-]"] == pytest.approx(steady.thrust_coefficient, rel=1e-8)
        assert np.allclose(state.along["deflection_x_[m]"], 0.0, atol=1e-9)


def test_the_best_ratio_is_kept_below_rated_power_and_the_power_above(rigid):
    case, _, (low, middle, high) = rigid
    ratios = [state.numbers["tip_speed_ratio_[-]"] for state in (low, middle)]
    assert ratios[0] == pytest.approx(ratios[1]) and low.operating.pitch == 0.0
    rotor = Rotor(load_aero_blade(case), hub_height=90.0)
    best = low.numbers["power_coefficient_[-]"]
    for factor in (0.95, 1.05):
        other = Operation(6.0, factor * low.operating.rotor_speed)
        assert find_performance(rotor, other, sectors=1).power_coefficient < best
    assert high.numbers["aero_power_[W]"] == pytest.approx(5.29661e6, rel=2e-4)
    assert high.operating.rotor_speed == pytest.approx(case.control.pitch.speed / 97.0)
    assert high.operating.pitch > 0.1


def test_tables_hold_the_steady_states_and_serve_as_schedule(rigid, tmp_path):
    _, folder, states = rigid
    with (folder / "steady.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["wind_speed_[m/s]"]) for row in rows] == list(WINDS)
    with (folder / "steady_blade.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 8 * len(WINDS)
    first = yaml.safe_load((folder / "steady.yaml").read_text())[0]
    found = first["outputs"]["distributed"]["aero_force_axial"]
    assert found["values"] == pytest.approx(states[0].along["force_x_[N/m]"])
    assert first["configuration"]["wind_speed"] == 6.0
    schedule = read_schedule(str(folder / "steady.csv"))
    middle = schedule.at(6.5)
    speeds = [state.operating.rotor_speed for state in states[:2]]
    assert middle.rotor_speed == pytest.approx(np.mean(speeds), rel=1e-6)
    other = tmp_path / "other.csv"
    other.write_text("wind_speed_[m/s],aero_power_[W]\n6,1e6\n9,2e6\n")
    pytest.importorskip("matplotlib")
    bare = tmp_path / "bare.csv"
    bare.write_text("wind_speed_[m/s],mass_[kg]\n7,1\n")
    with pytest.raises(InputError, match="the table 'bare' has no column that is drawn"):
        plot_steady(folder, [bare])
    assert plot_steady(folder, [other]) == ["steady.png", "steady_blade.png"]
    drawn = choose_columns(OVER_WIND, read_steady(folder / "steady.csv"))
    assert len(drawn) == 9 and "tip_rotation_z_[deg]" not in drawn  # rigid blades and tower


def test_winds_without_a_steady_state_are_left_out_with_a_warning(rigid, tmp_path, caplog):
    case, folder, _ = rigid
    table = str(folder / "steady.csv")
    with caplog.at_level(logging.WARNING):
        found = find_steady(case, tmp_path / "out", COMM, (8.0, 30.0), table)
    assert [state.operating.wind for state in found] == [8.0]
    assert "no steady state at 30 m/s" in caplog.text and "6 to 18" in caplog.text
    with pytest.raises(InputError, match="holds steady states; --overwrite replaces them"):
        find_steady(case, folder, COMM, (8.0,))


def test_a_flexible_turbine_carries_air_and_weight_to_the_ground(tmp_path):
    """Sums over stations and masses, of which the multipliers at the foot know nothing."""
    case = make_case(
        tmp_path,
        "hybrid",
        turbine={"tilt": "5 deg", "precone": "-2 deg"},
        mesh={"elements": [1, 1, 8]},
        tower={"flexible": True, "elements": [4, 1, 3]},
        wind={"shear": 0.2},
    )
    steady = SteadyTurbine(case, COMM, azimuths=1)
    operating = OperatingState(9.0, 9.0 * RPM, 0.02, 0.02)
    state = steady.solve(operating)
    read = SteadyReader(steady).read(operating, [state]).numbers
    system, turbine = steady.turbine.system, steady.turbine
    loads = find_loads(system, WIND, state)
    foot = np.array([0.0, -case.tower.height, 0.0])
    force = loads.force.sum(axis=0)
    moment = (np.cross(loads.motion.position - foot, loads.force) + loads.moment).sum(axis=0)
    masses = [body.mass for body in system.rigid_bodies]
    places = [system.coordinates_of(state.q)[body][:3] for body in system.rigid_bodies]
    for model, u in zip(system.flexible_models, state.u, strict=True):
        masses += model.nodal_mass.tolist()
        places += [*(model.positions + u.array_r.reshape(-1, 3))]
    weights = np.outer(masses, [0.0, -9.81, 0.0])
    force += weights.sum(axis=0)
    moment += np.cross(np.array(places) - foot, weights).sum(axis=0)
    for kind, unit, expected in (("force", "N", force), ("moment", "Nm", moment)):
        found = [read[f"tower_base_{kind}_{axis}_[{unit}]"] for axis in "xyz"]
        assert np.allclose(found, expected[[2, 0, 1]], atol=1e-4 * np.abs(expected).max())
    assert read["tip_deflection_x_[m]"] > 0.01 and turbine.case.control.kind == "none"
    state.destroy()


def test_rosco_limits_the_thrust_by_its_least_pitch(tmp_path):
    """Below rated power the pitch is that of the table, above the one that keeps the power."""
    rosco = tmp_path / "DISCON.IN"
    values = {
        "VS_ControlMode": "2",
        "PS_Mode": "1",
        "PC_FinePit": "0.0",
        "PC_RefSpd": "122.9",
        "VS_GenEff": "94.4",
        "VS_MinOMSpd": "65.0",
        "VS_RtPwr": "5e6",
        "VS_TSRopt": "7.5",
        "WE_GearboxRatio": "97.0",
        "PS_BldPitchMin_N": "3",
        "PS_WindSpeeds": "3.0 9.0 11.0",
        "PS_BldPitchMin": "0.05 0.0 0.04",
    }
    rosco.write_text("".join(f"{value} ! {key} - text\n" for key, value in values.items()))
    case = make_case(tmp_path)
    schedule, free = (
        find_schedule(case, str(rosco)),
        find_schedule(make_case(tmp_path, **CONTROLLED)),
    )
    rotor = Rotor(load_aero_blade(case), hub_height=90.0)
    limited = schedule.at(10.0)
    assert limited.pitch == limited.least_pitch == pytest.approx(0.02)
    thrusts = [
        find_performance(rotor, Operation(10.0, limited.rotor_speed, pitch), sectors=1).thrust
        for pitch in (limited.pitch, free.at(10.0).pitch)
    ]
    assert thrusts[0] < 0.95 * thrusts[1]
    high = schedule.at(18.0)
    assert high.pitch > 0.1 and high.least_pitch == pytest.approx(0.04)
    assert high.rotor_speed == pytest.approx(122.9 / 97.0)
    assert schedule.find_power(9.0) == pytest.approx(5e6 / 0.944)


def test_cases_that_do_not_say_how_they_are_run_are_refused(tmp_path):
    with pytest.raises(InputError, match="does not say how the turbine is run: give --schedule"):
        find_schedule(make_case(tmp_path))
    bare = Case.parse({"turbine": {"model": "rigid"}})
    with pytest.raises(InputError, match=r"need the aerodynamics of the blades: give aero\.file"):
        find_steady(bare, tmp_path / "out", COMM, (8.0,))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("wind_speed_[m/s],pitch_[deg]\n3,0\n", "needs the columns"),
        ("wind_speed_[m/s],rotor_speed_[rpm],pitch_[deg]\n3,x,0\n", "a number in each column"),
        ("wind_speed_[m/s],rotor_speed_[rpm],pitch_[deg]\n3,1,0\n3,1,0\n", "speeds that rise"),
        ("wind_speed_[m/s],rotor_speed_[rpm],pitch_[deg]\n3,1,200\n", "beyond 180 degrees"),
    ],
)
def test_wrong_schedules_are_refused(tmp_path, text, reason):
    (tmp_path / "s.csv").write_text(text)
    with pytest.raises(InputError, match=reason):
        read_schedule(str(tmp_path / "s.csv"))


def test_the_published_table_of_the_demo_is_a_schedule():
    path = str(DEMOS / "iea15" / "iea15_steady.csv")
    rated = read_schedule(path).at(12.0)
    assert rated.rotor_speed == pytest.approx(7.5 * RPM, rel=1e-3)
    assert np.degrees(rated.pitch) == pytest.approx(6.12, abs=0.1)


def test_wind_speeds_are_ranges_or_lists():
    assert parse_winds("3:5:0.5") == [3.0, 3.5, 4.0, 4.5, 5.0]
    assert parse_winds("8,10,12") == [8.0, 10.0, 12.0]
    for wrong in ("", "5:3:1", "3:5", "3:5:0", "0,1", "8,7", "nan", "1e9", "3:4:1e-9", "a:b:c"):
        with pytest.raises(InputError, match="--wind"):
            parse_winds(wrong)


CASE = """
[turbine]
model = "rigid"
[wind]
speed = 9.0
hub_height = 90.0
[aero]
file = "{file}"
stations = 8
"""


def test_the_command_prints_a_table_and_refuses_what_it_cannot_do(tmp_path, capfd):
    file, schedule = tmp_path / "case.toml", tmp_path / "s.csv"
    file.write_text(CASE.format(file=write_aerodyn(tmp_path)))
    schedule.write_text("wind_speed_[m/s],rotor_speed_[rpm],pitch_[deg]\n8,10,0\n12,12,3\n")
    command = ["steady", str(file), "-o", str(tmp_path / "out"), "--schedule", str(schedule)]
    assert main([*command, "--wind", "8,10"]) == 0
    seen = capfd.readouterr()
    assert "  10.00  11.000   1.500" in seen.out and "steady_blade.csv" in seen.out
    out = ["-o", str(tmp_path / "out")]
    for other, sentence in (
        (["run", str(file), *out], "holds steady states; --overwrite replaces them"),
        (["restart", *out[1:]], "there is no run in"),
    ):
        assert main(other) == 2
        assert sentence in capfd.readouterr().err
    assert main([*command, "--wind", "20", "--overwrite"]) == 3
    assert "no steady state at 20 m/s" in capfd.readouterr().err
    assert main([*command, "--wind", "8", "--overwrite", "--azimuths", "0"]) == 2
    assert "--azimuths 0: must be from 1" in capfd.readouterr().err
    assert main([*command, "--wind", "8", "--overwrite", "--beside", str(file)]) == 2
    assert "needs a column 'wind_speed_[m/s]'" in capfd.readouterr().err

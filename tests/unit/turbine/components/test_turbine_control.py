"""A controlled turbine from a case: pitch at the start, drivetrain, restarts, columns."""

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from aero_files import write_aerodyn
from rosco_files import rosco_files
from windio_files import find_turbine

from turbine_fenicsx import Case, build_turbine, restart_case, run_case
from turbine_fenicsx.analysis.modes import modes
from turbine_fenicsx.analysis.statics import equilibrium
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.simulation.simulation import Simulation
from turbine_fenicsx.turbine.components.control import list_actuators
from turbine_fenicsx.turbine.components.sensors import Sensors
from turbine_fenicsx.turbine.run.run import make_stepper
from turbine_fenicsx.turbine.run.start import make_start
from turbine_fenicsx.turbine.run.summary import rotor_inertia

pytestmark = pytest.mark.parallel

PITCH = np.radians(20.0)
ACTUATOR = {"drive": "actuator", "initial": "20 deg"}
TRAIN = {
    "model": "two_mass",
    "ratio": 97.0,
    "generator_inertia": 534.116,
    "stiffness": "867.637 MN m/rad",
    "damping": "6.215 MN m s/rad",
    "efficiency": 0.944,
}
MINE = """
from turbine_fenicsx.control.interface import Commands

class Mine:
    def __init__(self):
        self.total = 0.0

    def __call__(self, measured):
        self.total += measured.generator_speed * measured.dt
        pitch = tuple(angle + 0.01 for angle in measured.pitch)
        return Commands(1e4 + self.total + 1e-6 * measured.flap_moments[0], pitch, yaw_rate=0.05)
"""


def make_case(control=None, **tables):
    """A rigid turbine at rated speed without weight, driven by a torque."""
    return Case.parse(
        {
            "turbine": {"model": "rigid", "rotor_speed": "12.1 rpm", "blade_arm": "29.25 m"},
            "pitch": ACTUATOR,
            "drivetrain": TRAIN,
            "control": control or {"kind": "pi"},
            "loads": {"rotor_torque": "5 MN m", "duration": 4.0, "gravity": 0.0},
            "time": {"step": 0.05, "end": 1.0},
            "output": {"fields_every": 0.0},
            **tables,
        }
    )


def read(folder, name="history.csv"):
    """Columns of a time series by name."""
    if name == "history.out":
        lines = (folder / name).read_text().splitlines()
        rows = np.array([line.split() for line in lines[8:]], dtype=float).T
        return dict(zip(lines[6].split(), rows, strict=True))
    with (folder / name).open(newline="") as file:
        header, *values = csv.reader(file)
    return dict(zip(header, np.array(values, dtype=float).T, strict=True))


# --- pitch at the start


def test_rigid_blades_start_at_their_pitch(comm):
    case = make_case()
    turbine = build_turbine(case, comm)
    state = make_start(case, turbine.system)
    names = turbine.system.joint_coordinate_names
    signs = [state.joint_coordinates[names.index(f"pitch_{k}")] / PITCH for k in (1, 2, 3)]
    assert np.allclose(signs, [-1.0, 1.0, -1.0])
    assert turbine.system.constraint_error(state) < 1e-14
    first = turbine.system.first_coordinate[turbine.part("blade_2")]
    chord = state.q[first + 3 : first + 6]
    before = np.asarray(turbine.part("blade_2").directors)[:, 0]
    assert np.isclose(chord @ before, np.cos(PITCH))
    state.destroy()


@pytest.mark.parametrize("start", ["undeformed", "turning"])
def test_flexible_blades_start_at_their_pitch_without_a_shock(comm, start):
    case = Case.parse(
        {
            "turbine": {"rotor_speed": "8 rpm", "azimuth": "30 deg"},
            "mesh": {"elements": [1, 1, 4]},
            "pitch": {"bearings": True, **ACTUATOR},
            "yaw": {"drive": "lock"},
            "loads": {"gravity": 0.0},
            "time": {"step": 0.05, "start": start},
        }
    )
    turbine = build_turbine(case, comm)
    state = make_start(case, turbine.system)
    assert turbine.system.constraint_error(state) < 1e-12
    balance = turbine.system.balance(state)
    if start == "undeformed":
        assert abs(balance.strain) < 1e-9 * balance.kinetic
    stepper = make_stepper(case, turbine.system)
    last = Simulation(turbine.system, 0.05, 0.2, stepper=stepper, start=state).run()
    stepper.destroy()
    assert abs(last.energy_error) < 1e-11 * balance.kinetic
    if start == "turning":
        assert np.isclose(last.balance.strain, balance.strain, rtol=1e-6)
        assert abs(last.works.sum()) < 1e-7 * balance.strain  # the drives hold and do nothing
    state.destroy()


def test_prescribed_and_spring_drives_start_at_their_pitch_too(comm):
    for pitch in (
        {"drive": "prescribed", "initial": "20 deg"},
        {"drive": "spring", "initial": "20 deg", "stiffness": 1e8},
    ):
        case = make_case({"kind": "none"}, pitch=pitch, loads={"gravity": 0.0})
        turbine = build_turbine(case, comm)
        state = make_start(case, turbine.system)
        last = Simulation(turbine.system, 0.01, 0.05, start=state).run()
        k = turbine.system.joint_coordinate_names.index("pitch_2")
        assert np.isclose(last.state.joint_coordinates[k], PITCH, rtol=2e-2)
        state.destroy()


# --- drivetrain


def test_rotor_and_generator_are_two_masses_on_a_spring(comm):
    case = make_case(
        turbine={"model": "rigid", "blade_arm": "29.25 m"},
        pitch={"drive": "prescribed"},
        control={"kind": "none"},
        yaw={"drive": "lock"},
    )
    turbine = build_turbine(case, comm)
    state = equilibrium(turbine.system, held=["rotor"])
    found = modes(turbine.system, state, 2)
    J1, J2 = rotor_inertia(turbine), 97.0**2 * 534.116
    expected = np.sqrt(867.637e6 * (1.0 / J1 + 1.0 / J2)) / (2.0 * np.pi)
    frequencies = [mode.frequency for mode in found.modes]
    assert np.isclose(max(frequencies), expected, rtol=1e-9)
    found.destroy()


# --- runs


def test_columns_are_the_work_that_was_done(comm, shared_tmp_path):
    result = run_case(make_case(), shared_tmp_path, comm, "none")
    comm.barrier()
    assert result["worst_energy_error_[J]"] < 1e-11 * result["largest_energy_[J]"]
    history, out = read(shared_tmp_path), read(shared_tmp_path, "history.out")
    work = -np.diff(history["work_of_generator_[J]"])
    assert np.allclose(0.944 * work / 0.05, 1e3 * out["GenPwr"], rtol=1e-5)
    torque, speed = 1e3 * out["GenTq"], out["GenSpeed"] * np.pi / 30.0
    assert np.allclose(torque * speed, work / 0.05, rtol=1e-5)
    assert np.allclose(torque, 5.29661e6 / 122.9096, rtol=0.05)
    assert np.isclose(out["BldPitch1"][0], 20.0, atol=1e-3)
    assert {"RotTorq", "BlPitchC1", "BlPitchC3"} <= out.keys()


def test_sensors_see_wind_yaw_and_azimuth(comm, shared_tmp_path):
    """Wind from the right of a nacelle that looks along e3, the rotor turned by 30 degrees."""
    if comm.rank == 0:
        write_aerodyn(shared_tmp_path)
    comm.barrier()
    case = make_case(
        turbine={"model": "rigid", "rotor_speed": "12.1 rpm", "azimuth": "150 deg"},
        wind={"speed": 11.0, "direction": "20 deg", "shear": 0.0},
        aero={"file": str(shared_tmp_path / "rotor.dat")},
        yaw={"drive": "lock"},
    )
    turbine = build_turbine(case, comm)
    state = make_start(case, turbine.system)
    seen = Sensors(turbine, list_actuators(turbine))(SimpleNamespace(state=state), 0.05, True)
    assert np.isclose(seen.wind_speed, 11.0)
    assert np.isclose(seen.yaw_error, np.radians(20.0)) and seen.yaw == 0.0
    assert np.isclose(seen.azimuth, np.radians(30.0))  # blade 1 points up at 120 degrees
    assert np.isclose(seen.rotor_speed, 12.1 * np.pi / 30.0)
    assert np.isclose(seen.generator_speed, 97.0 * seen.rotor_speed)
    assert np.allclose(seen.pitch, PITCH)
    state.destroy()


def test_the_balance_closes_in_wind_under_control(comm, shared_tmp_path):
    if comm.rank == 0:
        write_aerodyn(shared_tmp_path)
    comm.barrier()
    case = make_case(
        wind={"speed": 12.0, "shear": 0.2},
        aero={"file": str(shared_tmp_path / "rotor.dat")},
        yaw={"drive": "lock"},
        loads={"gravity": 9.81},
        event={"grid": {"kind": "grid_loss", "time": 0.5}},
    )
    result = run_case(case, shared_tmp_path / "out", comm, "none")
    assert result["worst_energy_error_[J]"] < 1e-11 * result["largest_energy_[J]"]


def controls(kind, folder):
    """Tables of a controller."""
    if kind == "python":
        return {"kind": f"python:{folder / 'mine.py'}:Mine"}
    if kind == "discon":
        library, infile = rosco_files()
        return {"kind": "discon", "library": str(library), "input": str(infile)}
    return {"kind": "pi"}


@pytest.mark.parametrize("kind", ["pi", "python", "discon"])
def test_a_restart_goes_on_bit_for_bit(comm, shared_tmp_path, kind):
    if comm.rank == 0:
        (shared_tmp_path / "mine.py").write_text(MINE)
    comm.barrier()
    tables = {
        "control": controls(kind, shared_tmp_path),
        "yaw": {"drive": "drive"},
        "event": {"stop": {"time": 0.8, "kind": "emergency_stop"}},
    }
    whole, halves = shared_tmp_path / "whole", shared_tmp_path / "halves"
    run_case(make_case(**tables), whole, comm, "none")
    time = {"step": 0.05, "end": 0.4}
    run_case(make_case(**tables, time=time), halves, comm, "none")
    restart_case(halves, comm, ["time.end=1"], "none")
    comm.barrier()
    rows = [
        [line.rsplit(",", 1)[0] for line in (each / "history.csv").read_text().splitlines()]
        for each in (whole, halves)
    ]
    assert len(rows[0]) == 22 and rows[0] == rows[1]
    if kind == "python":
        yaw = read(whole, "history.out")["NacYaw"]
        assert np.isclose(yaw[-1], np.degrees(0.05), rtol=1e-6)


def test_a_controller_that_has_changed_is_not_gone_on_with(comm, shared_tmp_path):
    path = shared_tmp_path / "mine.py"
    if comm.rank == 0:
        path.write_text(MINE)
    comm.barrier()
    case = make_case(controls("python", shared_tmp_path), time={"step": 0.05, "end": 0.1})
    run_case(case, shared_tmp_path / "out", comm, "none")
    if comm.rank == 0:
        path.write_text(MINE + "\n# changed\n")
    comm.barrier()
    with pytest.raises(InputError, match="the controller has changed"):
        restart_case(shared_tmp_path / "out", comm, ["time.end=0.2"], "none")


def test_a_wrong_controller_is_told_before_the_run(comm, shared_tmp_path):
    path = shared_tmp_path / "mine.py"
    if comm.rank == 0:
        path.write_text("class Other: ...\n")
    comm.barrier()
    case = make_case(controls("python", shared_tmp_path))
    with pytest.raises(InputError, match="has no class 'Mine'"):
        run_case(case, shared_tmp_path / "out", comm, "none")


def test_the_demo_of_a_gust_is_valid():
    find_turbine("IEA-15-240-RWT.yaml")  # or the test is skipped
    demo = Path(__file__).parents[4] / "demos" / "iea15_gust" / "iea15_gust.toml"
    assert Case.load(demo).warnings == []


def test_the_demo_of_an_emergency_stop_runs(comm, shared_tmp_path):
    """Three steps of it, with the loss of the grid in the second."""
    find_turbine("IEA-15-240-RWT.yaml")  # or the test is skipped
    demo = Path(__file__).parents[4] / "demos" / "emergency_stop" / "emergency_stop.toml"
    assert Case.load(demo).warnings == []
    few = ["time.end=0.15", "event.grid.time=0.05", "output.fields_every=0"]
    case = Case.load(demo, few)
    result = run_case(case, shared_tmp_path / "out", comm, "none")
    comm.barrier()
    assert result["worst_energy_error_[J]"] < 1e-11 * result["largest_energy_[J]"]
    torque = read(shared_tmp_path / "out", "history.out")["GenTq"]
    assert torque[0] > 1.5e4 and list(torque[1:]) == [0.0, 0.0]


# --- a brake that the controller closes

BRAKING = """
class Mine:
    def __call__(self, measured):
        return 0.0, measured.pitch, 0.0, 1.0 if measured.time > 0.29 else 0.0
"""


def brake_case(folder, comm, torque):
    """A case whose controller closes the brake at 0.3 s."""
    if comm.rank == 0:
        (folder / "brake.py").write_text(BRAKING)
    comm.barrier()
    return make_case(
        {"kind": f"python:{folder / 'brake.py'}:Mine"},
        drivetrain={**TRAIN, "brake_torque": torque},
        loads={"gravity": 0.0},
    )


def test_the_brake_that_a_controller_closes_slows_the_rotor(comm, shared_tmp_path):
    torque, out = 5e6, shared_tmp_path / "out"
    run_case(brake_case(shared_tmp_path, comm, torque), out, comm, "none")
    found = read(out)
    t, heat = found["time_[s]"], found["dissipated_by_brake_[J]"]
    speed = np.diff(found["angle_rotor_[rad]"]) / np.diff(t)
    before = t[1:] < 0.31
    assert np.ptp(speed[before]) < 1e-6 * speed[0]
    assert speed[-1] < 0.98 * speed[0]
    assert heat[1:][before].max() == 0.0 and heat[-1] > 0.0


def test_a_brake_without_a_torque_is_warned_of_once(comm, shared_tmp_path, caplog):
    run_case(brake_case(shared_tmp_path, comm, 0.0), shared_tmp_path / "out", comm, "none")
    texts = [r.getMessage() for r in caplog.records if r.levelname == "WARNING"]
    expected = (
        "the controller closes the shaft brake at t = 0.3 s, but there is none: "
        "drivetrain.brake_torque is 0"
    )
    assert texts == ([expected] if comm.rank == 0 else [])

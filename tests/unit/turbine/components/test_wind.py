"""Claims about the component of the wind: rigid and flexible blades in a case."""

from mpi4py import MPI

import numpy as np
import pytest
from aero_files import write_aerodyn, write_turbsim
from histories import read_rows
from xdmf_bricks import needs_pyvista
from xdmf_bricks import read as read_series

from turbine_fenicsx import ModelError, StepTimes, restart_case, run_case
from turbine_fenicsx.analysis import turning
from turbine_fenicsx.analysis.turning_frame import turning_frame
from turbine_fenicsx.foundation.errors import StepFailure
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.foundation.rotations import rotation_about
from turbine_fenicsx.simulation.observers.station_loads import find_loads
from turbine_fenicsx.turbine.case.aero_blade import load_aero_blade
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.generator import find_steady_loads
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run import start as start_module
from turbine_fenicsx.turbine.run.inspection import inspect_mesh
from turbine_fenicsx.turbine.run.start import make_start
from turbine_fenicsx.wind.rotor import Operation, Rotor, find_performance, find_section_loads

RPM = np.pi / 30.0
QUIET = {"output": {"fields_every": 0}, "pitch": {"drive": "prescribed"}}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Aerodynamics and turbulence; equal on all ranks."""
    comm = MPI.COMM_WORLD

    def write():
        folder = tmp_path_factory.mktemp("wind")
        return str(write_aerodyn(folder)), str(write_turbsim(folder / "t.bts"))

    return on_rank0(comm, write)


def case(files, model="rigid", wind=None, end=0.2, stations=20, **tables):
    wind = {"hub_height": 90.0, **(wind or {"speed": 9.0, "shear": 0.0})}
    turbine = {"model": model, "rotor_speed": "11 rpm", **tables.pop("turbine", {})}
    if model == "hybrid":
        tables = {"mesh": {"elements": [1, 1, 8]}, **tables}
        tables.setdefault("solver", {"tolerance": 1e-10})
    data = {"turbine": turbine, "wind": wind, "aero": {"file": files[0], "stations": stations}}
    return Case.parse({**data, "time": {"step": 0.02, "end": end}, **QUIET, **tables})


def run(comm, tmp_path_factory, given, name="run", **options):
    folder = on_rank0(comm, lambda: tmp_path_factory.mktemp(name))
    return folder, run_case(given, folder, comm, progress="none", **options)


@pytest.fixture(scope="module")
def rigid(files, tmp_path_factory):
    output = {"fields_every": 0, "channels": ["default", "B1N*", "B2N1Fx", "RtFld*"]}
    given = case(files, loads={"gravity": 0}, output=output)
    return run(MPI.COMM_WORLD, tmp_path_factory, given)


def read_out(folder):
    """Rows of ``history.out``."""
    lines = (folder / "history.out").read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if line.split()[:1] == ["Time"])
    names = lines[head].split()
    rows = [map(float, line.split()) for line in lines[head + 2 :]]
    return [dict(zip(names, row, strict=True)) for row in rows]


def test_rigid_blades_begin_with_power_and_thrust_of_the_steady_rotor(files, rigid):
    given = case(files)
    rotor = Rotor(load_aero_blade(given), hub_height=90.0)
    steady = find_performance(rotor, Operation(9.0, 11.0 * RPM), sectors=1)
    first, *_ = read_rows(rigid[0])
    assert first["rotor_speed_[rpm]"] == pytest.approx(11.0)
    assert first["rotor_wind_[m/s]"] == pytest.approx(9.0)
    assert first["hub_wind_x_[m/s]"] == 9.0
    assert first["aero_thrust_[N]"] == pytest.approx(steady.thrust, rel=1e-9)
    assert first["aero_torque_[Nm]"] == pytest.approx(steady.torque, rel=1e-9)
    assert first["aero_power_[W]"] == pytest.approx(steady.power, rel=1e-9)


def test_the_work_of_the_wind_is_its_power_times_the_time(rigid):
    table = read_rows(rigid[0])
    work = sum(0.02 * row["aero_power_[W]"] for row in table[1:])
    assert table[-1]["work_of_wind_[J]"] == pytest.approx(work, rel=1e-8)


@pytest.mark.parallel
@needs_pyvista
@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_loads_and_wind_are_written_as_vectors(comm, files, tmp_path_factory, model):
    output, stations = {"output": {"fields_every": 0.04}}, 20 if model == "rigid" else 6
    given = case(files, model, {"speed": 9.0, "shear": 0.3}, end=0.08, stations=stations, **output)
    folder, _ = run(comm, tmp_path_factory, given)
    restart_case(folder, comm, ["time.end=0.12"], progress="none")
    found = read_series(folder / "wind.xdmf")
    assert found["times"] == pytest.approx([0.0, 0.04, 0.08, 0.12])
    part, n = found["0/cell/part"], 3 * stations
    assert np.bincount(part.astype(int)).tolist() == [400, *[stations - 1] * 3]
    points, force = found["3/points"], found["3/point/force_per_length"]
    blade = load_aero_blade(given)
    thrust = np.tile(blade.parts, 3) @ force[:n, 2]
    assert thrust == pytest.approx(read_rows(folder)[-1]["aero_thrust_[N]"], rel=1e-3)
    assert not force[n:].any()
    expected = 9.0 * ((points[:, 1] + 90.0) / 90.0) ** 0.3
    assert found["3/point/wind"][:, 2] == pytest.approx(expected, rel=1e-6)
    # stations are where the blades are at the time, not in the middle of the step
    turned = [
        np.arctan2(points[stations, 0], points[stations, 1])
        for points in (found["0/points"], found["3/points"])
    ]
    assert abs(turned[1] - turned[0]) == pytest.approx(0.12 * 11.0 * RPM, rel=2e-2)


@pytest.mark.parallel
@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_works_of_the_blades_add_up_to_that_of_the_wind(comm, files, tmp_path_factory, model):
    wind, stations = {"speed": 9.0, "shear": 0.3}, 20 if model == "rigid" else 6
    given = case(files, model, wind, end=0.2, stations=stations)
    folder, _ = run(comm, tmp_path_factory, given)
    last = read_rows(folder)[-1]
    works = [last[f"aero_work_{k}_[J]"] for k in (1, 2, 3)]
    assert works[1] > 1.02 * works[0] > 0.0  # the upright one meets more wind
    assert sum(works) == pytest.approx(last["work_of_wind_[J]"], rel=1e-11)
    short = case(files, model, wind, end=0.1, stations=stations)
    folder, _ = run(comm, tmp_path_factory, short)
    restart_case(folder, comm, ["time.end=0.2"], progress="none")
    assert [read_rows(folder)[-1][f"aero_work_{k}_[J]"] for k in (1, 2, 3)] == works


def test_power_is_work_over_time_in_long_steps_of_a_coned_rotor(comm, files, tmp_path_factory):
    # the sections have moments about spans that lean, and points move on chords of 7 degrees
    given = case(
        files,
        turbine={"precone": "-4 deg"},
        generator={"keeps": "speed"},
        loads={"gravity": 0},
        yaw={"drive": "lock"},
        time={"step": 0.1, "end": 0.5},
    )
    folder, _ = run(comm, tmp_path_factory, given)
    table = read_rows(folder)
    assert table[0]["aero_power_[W]"] == pytest.approx(find_steady_loads(given).power, rel=1e-9)
    before, last = table[-2:]
    work = last["work_of_wind_[J]"] - before["work_of_wind_[J]"]
    assert last["aero_power_[W]"] == pytest.approx(work / 0.1, rel=1e-8)


@pytest.mark.parallel
@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_the_energy_balance_closes(comm, files, rigid, tmp_path_factory, model):
    if model == "rigid":
        _, summary = rigid
    else:
        given = case(files, model, end=0.1, stations=6)
        folder, summary = run(comm, tmp_path_factory, given)
        if comm.rank == 0:
            assert read_rows(folder)[-1]["aero_thrust_[N]"] > 1e5
    assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]
    assert summary["mean_newton_iterations"] < (4 if model == "rigid" else 12)


def test_openfast_reads_the_same(files, rigid):
    found, last = read_out(rigid[0])[-1], read_rows(rigid[0])[-1]
    assert found["RtAeroPwr"] == pytest.approx(last["aero_power_[W]"], rel=1e-5)
    assert found["RtAeroFxh"] == pytest.approx(last["aero_thrust_[N]"], rel=1e-5)
    assert found["RtAeroMxh"] == pytest.approx(last["aero_torque_[Nm]"], rel=1e-5)
    assert found["RtVAvgxh"] == pytest.approx(9.0, rel=1e-2)
    assert (found["Wind1VelX"], found["Wind1VelY"], found["Wind1VelZ"]) == (9.0, 0.0, 0.0)
    assert found["RtFldPwr"] == found["RtAeroPwr"] and "RtAeroMzh" not in found
    assert abs(found["RtFldMzh"]) < 1e-3 * found["RtFldMxh"]


def test_nodes_have_the_flow_of_the_steady_rotor(files, rigid):
    """In the first step, in which the speed changes by less than a thousandth."""
    first, blade = read_out(rigid[0])[0], load_aero_blade(case(files))
    rotor, operation = Rotor(blade, hub_height=90.0), Operation(9.0, 11.0 * RPM)
    loads, n = find_section_loads(rotor, operation, np.zeros(1)), len(blade.radius)
    assert first["B2N1Fx"] == pytest.approx(first["B1N1Fx"], rel=1e-6) and "B2N1Fy" not in first
    at = {
        end: np.array([first[f"B1N{k}{end}"] for k in range(1, n + 1)])
        for end in ("Fx", "Fy", "Fn", "Ft", "Alpha", "Phi", "AxInd", "TnInd", "Vrel", "Cl", "Cd")
    }
    near = {"rtol": 3e-3, "atol": 1e-9}
    assert np.allclose(at["Fx"], loads.normal[0], **near)
    assert np.allclose(at["Fy"], -loads.tangential[0], rtol=6e-3, atol=5.0)
    phi, a, swirl = (x[0] for x in loads.induction)
    assert np.allclose(at["AxInd"], a, **near) and np.allclose(at["TnInd"], swirl, rtol=6e-3)
    assert np.allclose(np.radians(at["Phi"]), phi, **near)
    alpha = phi - blade.twist
    assert np.allclose(np.radians(at["Alpha"]), alpha, atol=1e-3)
    polar = blade.table(np.radians(at["Alpha"]))
    assert np.allclose(at["Cl"], polar.lift, rtol=1e-3, atol=1e-4)
    assert np.allclose(at["Cd"], polar.drag, rtol=1e-3, atol=1e-4)
    W = np.hypot(9.0 * (1.0 - a), 11.0 * RPM * blade.radius * (1.0 + swirl))
    assert np.allclose(at["Vrel"], W, **near)
    q, c, s = 0.5 * 1.225 * blade.chord * W**2, np.cos(alpha), np.sin(alpha)
    assert np.allclose(at["Fn"], q * (polar.lift * c + polar.drag * s), rtol=6e-3)
    assert np.allclose(at["Ft"], q * (polar.lift * s - polar.drag * c), rtol=1e-2, atol=5.0)
    steady = find_performance(rotor, operation, sectors=1)
    for name, value in (
        ("RtFldCp", steady.power_coefficient),
        ("RtFldCt", steady.thrust_coefficient),
        ("RtFldCq", steady.power_coefficient / (11.0 * RPM * rotor.tip_distance / 9.0)),
        ("RtTSR", 11.0 * RPM * rotor.tip_distance / 9.0),
    ):
        assert first[name] == pytest.approx(value, rel=3e-3)


@pytest.mark.parallel
@pytest.mark.parametrize("model", ["rigid", "hybrid"])
def test_a_run_in_turbulence_goes_on_bit_for_bit(comm, files, tmp_path_factory, model):
    aero = {"file": files[0], "stations": 6, "dynamic_stall": "oeye", "skewed_wake": True}
    given = case(files, model, {"file": files[1]}, end=0.12, aero=aero)
    whole, _ = run(comm, tmp_path_factory, given)
    half = case(files, model, {"file": files[1]}, end=0.06, aero=aero)
    folder, _ = run(comm, tmp_path_factory, half)
    restart_case(folder, comm, ["time.end=0.12"], progress="none")
    a, b = read_rows(whole), read_rows(folder)
    for row in (*a, *b):
        del row["wall_time_[s]"]
    assert len(a) == 7
    assert a == b


def test_blades_that_pitch_take_less(comm, files):
    thrusts = []
    for angle in (0.0, 5.0):
        given = case(files, pitch={"drive": "prescribed", "angle": f"{angle} deg"})
        turbine = build_turbine(given, comm)
        state = turbine.system.initial_state()
        frame = turning_frame(turbine.system, "rotor", 11.0 * RPM, state)
        frame.set_velocities(state)
        for name in ("blade_1", "blade_2", "blade_3"):
            feather(turbine, state, name, np.radians(angle))
        loads = find_loads(turbine.system, "wind", state)
        thrusts.append(loads.force[:, 2].sum())
    assert 0.0 < thrusts[1] < 0.8 * thrusts[0]


def feather(turbine, state, name, angle):
    """Turn a blade about its span, the leading edge upwind."""
    first = turbine.system.first_coordinate[turbine.part(name)]
    blade = int(name[-1])
    Q = rotation_about(turbine.rotor.layout.frame(blade)[0], -angle)
    q = state.q[first : first + 12].reshape(4, 3)
    q[1:] = q[1:] @ Q.T


def test_turning_blades_begin_with_the_loads_that_bend_them(comm, files):
    wind, time = {"speed": 9.0, "shear": 0.4}, {"step": 0.02, "end": 0.2, "start": "turning"}
    given = case(files, "hybrid", wind, stations=6, time=time, generator={"keeps": "speed"})
    system = build_turbine(given, comm).system
    start = make_start(given, system)
    (model,) = system.flexible_models
    (loads,) = model.section_loads
    u, v = start.u[0].array_r, start.v[0].array_r

    def forces(times, v):
        loads.start_step_at(times, u)
        found = np.zeros_like(u)
        loads.add_forces(u, v, 0.0, 1.0, found)
        return found

    bending = forces(StepTimes.at_rest(0.0), np.zeros_like(u))
    jump = forces(StepTimes.from_start(0.0, 0.02), v) - bending
    jump, size = np.sqrt(comm.allreduce(np.array([jump @ jump, bending @ bending])))
    # 2e-3 with the velocities of the quasi-static change of shape
    assert jump < 5e-4 * size


def test_turning_blades_begin_without_a_kick_to_thin_walls(comm, files, monkeypatch):
    time = {"step": 0.02, "end": 0.2, "start": "turning"}
    soft = {"young": [4.5e9, 1.5e9, 1.5e9], "shear": [5.4e8, 5.4e8, 5.4e8]}
    more = {"time": time, "material": soft, "generator": {"keeps": "speed"}}
    given = case(files, "hybrid", {"speed": 15.0}, stations=6, **more)
    system, starts = build_turbine(given, comm).system, []
    for tolerance in (start_module.IN_WIND["tolerance"], 1e-12):
        monkeypatch.setitem(start_module.IN_WIND, "tolerance", tolerance)
        starts.append(make_start(given, system).u[0].array_r.copy())
    error, size = (np.max(np.abs(u), initial=0.0) for u in (starts[0] - starts[1], starts[1]))
    # 1e-9 with a tolerance of 1e-6, with which hollow blades of 12 x 12 cells fail in ten steps
    assert comm.allreduce(error, op=MPI.MAX) < 1e-10 * comm.allreduce(size, op=MPI.MAX)


def test_wind_too_strong_for_one_load_step_is_reached_in_several(comm, files, monkeypatch):
    time = {"step": 0.02, "end": 0.2, "start": "turning"}
    soft = {"young": [4.5e8, 1.5e8, 1.5e8], "shear": [5.4e7, 5.4e7, 5.4e7]}
    more = {"time": time, "material": soft, "generator": {"keeps": "speed"}}
    given = case(files, "hybrid", {"speed": 25.0}, stations=6, **more)
    system = build_turbine(given, comm).system
    at_once = make_start(given, system)
    monkeypatch.setitem(start_module.IN_WIND, "max_iterations", 25)
    in_steps = make_start(given, system)
    assert (at_once.u[0] - in_steps.u[0]).norm() <= 1e-9 * at_once.u[0].norm()
    monkeypatch.setattr(turning, "LOAD_STEPS", (1,))
    with pytest.raises(StepFailure):
        make_start(given, system)


@pytest.mark.parametrize(("degree", "most"), [(1, 11), (2, 16)])
def test_check_and_run_say_how_many_stations_a_mesh_takes(comm, files, degree, most):
    mesh = {"elements": [1, 1, 8], "degree": degree}
    too_many = case(files, "hybrid", stations=most + 1, mesh=mesh)
    (found,) = inspect_mesh(too_many, comm).mistakes
    assert found.startswith(f"aero.stations = {most + 1}: station ")
    assert found.endswith(f"; take at most {most}, or a mesh that is finer along the span")
    with pytest.raises(ModelError) as refused:
        build_turbine(too_many, comm)
    assert str(refused.value) == found
    enough = case(files, "hybrid", stations=most, mesh=mesh)
    assert not inspect_mesh(enough, comm).mistakes
    build_turbine(enough, comm)


def test_stall_skew_and_tower_change_loads_and_leave_the_energy_exact(
    files, comm, tmp_path_factory
):
    wind = {"speed": 14.0, "shear": 0.2, "direction": "20 deg"}
    tower = {"flexible": True, "elements": [4, 1, 2], "degree": 1, "height": 90.0}
    every = {"dynamic_stall": "oeye", "skewed_wake": True, "tower_shadow": "powles"}
    thrusts = []
    for models in ({}, every):
        aero = {"file": files[0], "stations": 20, **models}
        given = case(files, wind=wind, aero=aero, tower=tower, end=0.06)
        folder, summary = run(comm, tmp_path_factory, given)
        thrusts.append(read_rows(folder)[-1]["aero_thrust_[N]"])
        assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]
    assert abs(thrusts[1] / thrusts[0] - 1.0) > 1e-3

"""The paper's three cases, shortened: the files they promise and what stands in them."""

import importlib.util
import json
import subprocess
import sys
from math import cos, pi

import numpy as np
import pytest
from histories import read_columns
from patience import patience

DEMOS = ("rigid", "hybrid_stiff", "hybrid_soft")
HYBRID = ("hybrid_stiff", "hybrid_soft")
END, STEP, EVERY = 0.1, 0.02, 0.04
FIELD_TIMES = [0.0, 0.04, 0.08, 0.1]  # every 0.04 s, and the end

FIRST_COLUMNS = [
    "time_[s]",
    "kinetic_energy_[J]",
    "strain_energy_[J]",
    "potential_energy_[J]",
    "total_energy_[J]",
    "external_work_[J]",
    "energy_error_[J]",
    "linear_momentum_1_[kgm/s]",
    "linear_momentum_2_[kgm/s]",
    "linear_momentum_3_[kgm/s]",
    "angular_momentum_1_[Nms]",
    "angular_momentum_2_[Nms]",
    "angular_momentum_3_[Nms]",
    "angle_yaw_[rad]",
    "angle_rotor_[rad]",
]
LAST_COLUMNS = [
    "work_of_torque_on_rotor_[J]",
    "work_of_torque_on_yaw_[J]",
    "constraint_error_[-]",
    "newton_iterations",
    "krylov_iterations",
    "wall_time_[s]",
]
ROOT_COLUMNS = [
    f"root_{load}_{k}_{axis}_[{unit}]"
    for k in (1, 2, 3)
    for load, unit in (("force", "N"), ("moment", "Nm"))
    for axis in "xyz"
]
INTERFACE_COLUMNS = [
    f"{place}_{load}_{axis}_[{unit}]"
    for place in ("yaw_bearing", "shaft")
    for load, unit in (("force", "N"), ("moment", "Nm"))
    for axis in "xyz"
]
PITCH_COLUMNS = [f"angle_pitch_{k}_[rad]" for k in (1, 2, 3)]
RIGID_COLUMNS = [*PITCH_COLUMNS, *INTERFACE_COLUMNS, *ROOT_COLUMNS]
TIP_COLUMNS = ["tip_deflection_1_[m]", "tip_deflection_2_[m]", "tip_deflection_3_[m]"]
PART_COLUMNS = [f"tip_{way}_{k}_[m]" for k in (1, 2, 3) for way in ("flap", "edge")]
CLEARANCE_COLUMNS = [f"tip_clearance_{k}_[m]" for k in (1, 2, 3)]
BLADE_COLUMNS = [*TIP_COLUMNS, *PART_COLUMNS, *CLEARANCE_COLUMNS, *ROOT_COLUMNS]
HYBRID_COLUMNS = [*INTERFACE_COLUMNS, *BLADE_COLUMNS]


@pytest.fixture(scope="module")
def shortened(command_line, demo, tmp_path_factory):
    """Runs each demo once; returns its output folder and the finished process."""
    done = {}

    def run(name):
        if name not in done:
            out = tmp_path_factory.mktemp(name) / "new" / "folder"  # made by the program
            changes = [f"time.end={END}", f"output.fields_every={EVERY}"]
            result = command_line(
                "run", demo(f"{name}.toml"), "-o", out, "--set", *changes, "--progress", "none"
            )
            assert result.returncode == 0, result.stderr
            done[name] = out, result
        return done[name]

    return run


@pytest.mark.parametrize("name", DEMOS)
def test_demo_creates_exactly_the_promised_files(shortened, name):
    out, result = shortened(name)
    promised = {"history.csv", "history.out", "statistics.csv", "summary.json"}
    promised |= {"fields.xdmf", "fields.bin"}
    beside = {"case.json", "checkpoints", "run.log", ".lock"}
    if importlib.util.find_spec("matplotlib"):
        promised.add("history.png")
    assert {path.name for path in out.iterdir()} == promised | beside
    assert all((out / name).stat().st_size > 0 for name in (promised | beside) - {".lock"})
    assert result.stderr == ""
    # the table says where they are
    for file in promised - {"fields.bin"}:
        assert file in result.stdout.splitlines()[-1]
    assert str(out) in result.stdout


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("rigid", RIGID_COLUMNS),
        ("hybrid_stiff", [*HYBRID_COLUMNS, "max_stress_[Pa]"]),
        ("hybrid_soft", [*HYBRID_COLUMNS, "max_stress_[Pa]"]),
    ],
)
def test_history_has_exactly_the_promised_columns(shortened, name, columns):
    header = list(read_columns(shortened(name)[0]))
    assert header == [*FIRST_COLUMNS, *columns, *LAST_COLUMNS]


@pytest.mark.parametrize("name", DEMOS)
def test_history_is_consistent(shortened, name):
    h = read_columns(shortened(name)[0])
    assert h["time_[s]"] == pytest.approx(np.arange(6) * STEP, abs=1e-15)
    total = h["kinetic_energy_[J]"] + h["strain_energy_[J]"] + h["potential_energy_[J]"]
    scale = np.max(np.abs(h["kinetic_energy_[J]"]))
    # sums of numbers written without loss, in another order
    assert np.max(np.abs(h["total_energy_[J]"] - total)) < 1e-14 * max(scale, abs(total[0]))
    error = h["total_energy_[J]"] - h["total_energy_[J]"][0] - h["external_work_[J]"]
    assert np.max(np.abs(h["energy_error_[J]"] - error)) < 1e-14 * max(scale, abs(total[0]))
    assert np.max(np.abs(h["energy_error_[J]"])) < 1e-10 * scale
    assert h["external_work_[J]"][0] == 0.0
    assert h["external_work_[J]"][-1] > 0.0
    assert np.max(h["constraint_error_[-]"]) < 1e-12
    assert h["newton_iterations"][0] == 0
    assert np.min(h["newton_iterations"][1:]) >= 1
    assert np.all(np.diff(h["wall_time_[s]"]) > 0.0)
    # a negative torque turns the rotor the negative way, and it is the axial momentum's source
    assert h["angle_rotor_[rad]"][-1] < 0.0
    impulse = -0.5 * (36e6 / 1.5) * END**2
    # D^2/12 of it is lost to the curvature of a step; the weight of the rigid blades adds 5e-6
    assert h["angular_momentum_3_[Nms]"][-1] == pytest.approx(impulse, rel=1e-4)


@pytest.mark.parametrize("name", HYBRID)
def test_blades_bend_and_are_stressed(shortened, name):
    h = read_columns(shortened(name)[0])
    for column in (*TIP_COLUMNS, "max_stress_[Pa]", "strain_energy_[J]"):
        assert h[column][0] == pytest.approx(0.0, abs=1e-6)  # undeformed, stress in Pa
        assert h[column][-1] > 0.0
    # from a distance of 56 m, the tips of the three equal blades are pulled back alike
    tips = np.array([h[column][-1] for column in TIP_COLUMNS])
    assert np.max(tips) < 1.0


def test_energy_of_the_rigid_demo_is_that_of_its_inertia(shortened):
    # Kinetic energy L3^2/(2 J) of a rotor with the inertia of the summary, up to the two per mille
    # that gravity makes with the unbalanced blades.
    out, _ = shortened("rigid")
    h = read_columns(out)
    inertia = json.loads((out / "summary.json").read_text())["rotor_inertia_[kgm2]"]
    kinetic = h["angular_momentum_3_[Nms]"][-1] ** 2 / (2.0 * inertia)
    assert h["kinetic_energy_[J]"][-1] == pytest.approx(kinetic, rel=0.005)


@pytest.mark.parametrize("name", DEMOS)
def test_summary_tells_versions_unknowns_and_costs(shortened, name):
    out, _ = shortened(name)
    s = json.loads((out / "summary.json").read_text())
    assert s["versions"].keys() >= {"turbine_fenicsx", "python", "petsc", "mpi", "numpy"}
    assert {"fenics-dolfinx", "dolfinx-solver-real"} & s["versions"].keys()
    assert (s["ranks"], s["steps"], s["halved_steps"]) == (1, 5, 0)
    assert s["end_time_[s]"] == pytest.approx(END, abs=1e-15)
    h = read_columns(out)
    # the extreme over the same numbers
    assert s["worst_energy_error_[J]"] == np.max(np.abs(h["energy_error_[J]"]))
    assert s["worst_constraint_error_[-]"] == np.max(h["constraint_error_[-]"])
    assert s["mean_newton_iterations"] == pytest.approx(np.sum(h["newton_iterations"]) / 5)
    assert s["mean_krylov_iterations"] == pytest.approx(np.sum(h["krylov_iterations"]) / 5)
    assert s["angles_[rad]"]["rotor"] == h["angle_rotor_[rad]"][-1]
    parts = s["time_per_step_by_part_[s]"]
    assert {"residual", "linear set-up", "linear solve", "output"} <= parts.keys()
    # where the time went adds up to the time, except what is timed twice at the edges
    assert sum(parts.values()) == pytest.approx(s["time_per_step_[s]"], rel=0.05)


def test_unknowns_of_the_rigid_turbine(shortened):
    s = json.loads((shortened("rigid")[0] / "summary.json").read_text())
    assert s["unknowns"] == {
        "displacements": 0,
        "coupling_multipliers": 0,
        "rigid_coordinates": 60,
        "joint_angles": 5,
        "rigid_and_joint_multipliers": 60,
    }
    assert s["mesh"] is None


@pytest.mark.parametrize("name", HYBRID)
def test_unknowns_of_the_hybrid_turbine(shortened, name):
    s = json.loads((shortened(name)[0] / "summary.json").read_text())
    # per blade 3 x 3 nodes in each of 13 sections; those of the root section are coupled
    assert s["unknowns"] == {
        "displacements": 3 * 3 * 9 * 13,
        "coupling_multipliers": 3 * 3 * 9,
        "rigid_coordinates": 24,
        "joint_angles": 2,
        "rigid_and_joint_multipliers": 12 + 10 + 2,
    }
    assert (s["mesh"]["cells"], s["mesh"]["nodes"]) == (144, 351)
    assert 0.3 < s["mesh"]["worst_quality"] <= 1.0


def test_masses_and_rotor_inertia_of_the_rigid_turbine_are_the_hand_values(shortened):
    s = json.loads((shortened("rigid")[0] / "summary.json").read_text())
    assert s["masses_[kg]"] == {
        "nacelle": 2e5,
        "hub": 6.1e4,
        **dict.fromkeys(("blade_1", "blade_2", "blade_3"), 1.65e4),
    }
    # Parallel axes. The inertia about e3 is E1 + E2, the same in every azimuth; the centres of
    # the blades are at c, r4 and c from the shaft.
    c, r4 = 27.0 + 4.5 / (2.0 * cos(pi / 6.0)), (4.5 + 54.0) / 2.0
    hub, blade = 2.0 * 102940.0, 183500.0 + 1449500.0
    by_hand = hub + 3.0 * blade + 1.65e4 * (2.0 * c**2 + r4**2)
    assert s["rotor_inertia_[kgm2]"] == pytest.approx(by_hand, rel=1e-12)


@pytest.mark.parametrize("name", HYBRID)
def test_masses_and_rotor_inertia_of_the_hybrid_turbine_belong_to_its_mesh(
    shortened, command_line, demo, name
):
    s = json.loads((shortened(name)[0] / "summary.json").read_text())
    check = command_line("check", demo(f"{name}.toml"))
    volumes = [
        float(line.split()[-2])
        for line in check.stdout.splitlines()
        if line.startswith("volume of blade_")
    ]
    assert len(volumes) == 3
    # the report has six digits
    assert s["masses_[kg]"]["blades"] == pytest.approx(1500.0 * sum(volumes), rel=1e-5)
    # Slender blades between radius 2.25 and 56.25 m: pi/4 chord thickness, linear between 1.8 x 1.8
    # at the root, 3 x 1.5 at 20 % and 0.6 x 0.2 at the tip, integrated with r^2. The mesh has
    # polygons in the place of ellipses, with the same ratio everywhere.
    t = (np.arange(100000) + 0.5) / 100000
    section = np.interp(t, [0, 0.2, 1], [1.8, 3, 0.6]) * np.interp(t, [0, 0.2, 1], [1.8, 1.5, 0.2])
    r = 2.25 + 54.0 * t
    radius_of_gyration_squared = np.sum(section * r**2) / np.sum(section)
    by_hand = s["masses_[kg]"]["blades"] * radius_of_gyration_squared + 2.0 * 102940.0
    # the width of the blades adds 0.1 per cent, twelve linear elements change the mass's place
    assert s["rotor_inertia_[kgm2]"] == pytest.approx(by_hand, rel=0.02)


READER = """
import json, sys
import numpy as np
import pyvista
reader = pyvista.get_reader(sys.argv[1])
found = []
for time in reader.time_values:
    reader.set_active_time_value(time)
    grid = reader.read()
    found.append({
        "time": float(time),
        "kinds": sorted({int(kind) for kind in grid.celltypes}),
        "parts": sorted({int(part) for part in grid.cell_data["part"]}),
        "point": {n: list(grid.point_data[n].shape) for n in grid.point_data},
        "cell": {n: list(grid.cell_data[n].shape) for n in grid.cell_data},
        "finite": all(bool(np.all(np.isfinite(grid[n]))) for n in grid.array_names),
        "displacement": float(np.abs(grid.point_data["displacement"]).max()),
        "velocity": float(np.abs(grid.point_data["velocity"]).max()),
        "stress": float(grid.cell_data["cauchy_stress_norm"].max()),
        "points": grid.n_points,
        "cells": grid.n_cells,
        "bounds": [float(x) for x in grid.bounds],
    })
json.dump(found, sys.stdout)
"""


@pytest.mark.skipif(
    importlib.util.find_spec("pyvista") is None, reason="PyVista, which reads back, is missing"
)
@pytest.mark.parametrize("name", DEMOS)
def test_fields_hold_all_times_arrays_and_parts(shortened, name):
    out, _ = shortened(name)
    # in a process of its own: VTK and MPI never meet
    command = [sys.executable, "-c", READER, str(out / "fields.xdmf")]
    child = subprocess.run(command, capture_output=True, text=True, timeout=patience(120))
    assert child.returncode == 0, child.stderr
    found = json.loads(child.stdout)
    assert [f["time"] for f in found] == pytest.approx(FIELD_TIMES, abs=1e-6)
    hexahedra = 144 if name in HYBRID else 0
    for f in found:
        assert f["finite"]
        assert f["kinds"] == ([9, 12] if hexahedra else [9])  # quadrilaterals, hexahedra of VTK
        assert f["parts"] == [0, 1, 2, 3, 4]  # nacelle, hub and three blades
        vectors = {n: [f["points"], 3] for n in ("displacement", "velocity")}
        assert f["point"] == vectors | {"coupling": [f["points"]]}
        assert f["cell"].keys() == {"cauchy_stress_norm", "von_mises_stress", "fibre", "part"}
        assert f["cell"]["fibre"] == [f["cells"], 3]
        assert f["cells"] > hexahedra
    h = read_columns(out)
    first, last = found[0], found[-1]
    # the turbine of the first picture: tips at 2.25 + 54 m, the upper one straight up
    assert first["bounds"][3] == pytest.approx(56.25, abs=1e-4)
    assert first["displacement"] == first["velocity"] == first["stress"] == 0.0
    assert last["displacement"] > 0.0
    assert last["velocity"] > 0.0
    if hexahedra:
        # single precision in the fields, all digits in the history
        assert last["stress"] == pytest.approx(h["max_stress_[Pa]"][-1], rel=1e-6)


def test_fields_can_be_left_out(command_line, demo, tmp_path):
    result = command_line(
        "run",
        demo("hybrid_stiff.toml"),
        *("-o", tmp_path, "--set", "time.end=0.04", "output.fields_every=0"),
    )
    assert result.returncode == 0, result.stderr
    assert not [path for path in tmp_path.iterdir() if path.name.startswith("fields")]
    assert "fields.xdmf" not in result.stdout
    header = list(read_columns(tmp_path))
    # stress is written with the fields only
    assert header == [*FIRST_COLUMNS, *HYBRID_COLUMNS, *LAST_COLUMNS]


def test_python_demo_is_short_and_gives_the_same_turbine(shortened, demo, tmp_path):
    script = demo("hybrid_stiff.py")
    assert len(script.read_text(encoding="utf-8").splitlines()) < 60
    path = tmp_path / "history.csv"
    code = "import sys; sys.path.insert(0, sys.argv[1]); import hybrid_stiff as d; d.main(*ARGS)"
    code = code.replace("ARGS", f"({str(path)!r}, {END})")
    command = [sys.executable, "-c", code, str(script.parent)]
    child = subprocess.run(command, capture_output=True, text=True, timeout=patience(120))
    assert child.returncode == 0, child.stderr
    script_history = read_columns(tmp_path)
    case_history = read_columns(shortened("hybrid_stiff")[0])
    for column in ("kinetic_energy_[J]", "total_energy_[J]", "angle_rotor_[rad]"):
        a, b = script_history[column], case_history[column]
        # the same computation in another process
        assert np.max(np.abs(a - b)) < 1e-10 * np.max(np.abs(b))

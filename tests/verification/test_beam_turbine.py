"""Claims about turbines of a windIO file without a layup: their blades are beams."""

import csv
import json

import numpy as np
import pytest
from beam_turbines import INERTIA, bare_turbine, section_matrices, write_beam_case
from beamdyn_files import write_beamdyn
from elastodyn_files import write_tower
from hawc2_files import write_hawc2
from reduced_turbines import COMM, read, run
from scipy.spatial import cKDTree
from windio_files import find_turbine, small_turbine, write_turbine

from turbine_fenicsx import (
    Case,
    Coupling,
    MultibodySystem,
    ReducedBody,
    VtkHdfFile,
    box_carrier,
    build_turbine,
    equilibrium,
    modes,
    restart_case,
)
from turbine_fenicsx.analysis.mode import Motion
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.records import names
from turbine_fenicsx.records.conventions import BLADES
from turbine_fenicsx.turbine.blades.rotor_plan import plan_rotor
from turbine_fenicsx.turbine.modes.slender_parts import find_slender_parts
from turbine_fenicsx.turbine.run.inspection import list_damping_mistakes
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
from turbine_fenicsx.turbine.run.run_recovery import RunRecovery
from turbine_fenicsx.turbine.run.section_history import find_section_history

MASS = 0.5 * 1.1 * INERTIA["mass"] * 20.0
"""Of a blade that is straight, about [kg]."""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The case."""
    return write_beam_case(on_rank0(COMM, lambda: tmp_path_factory.mktemp("beams")))


@pytest.fixture(scope="module")
def out(path):
    """Its run."""
    return run(path, "run", "output.checkpoint_wall_time=0", "output.motion_every=0.05")


def test_the_balance_of_energy_closes_with_wind_pitch_and_viscosity(out):
    seen = read(out)
    size = np.max(np.abs(seen["total_energy_[J]"]))
    assert np.max(np.abs(seen["energy_error_[J]"])) < 1e-9 * size
    assert np.max(np.abs(seen["work_of_wind_[J]"])) > 1e-3 * size
    lost = seen["dissipated_by_viscosity_of_blades_[J]"]
    assert np.all(np.diff(lost) >= 0.0) and lost[-1] > 0.0


def test_masses_are_those_of_the_matrices(path, out):
    summary = on_rank0(COMM, lambda: json.loads((out / "summary.json").read_text()))
    blades = summary["masses_[kg]"]["blades"]
    plan = plan_rotor(Case.load(path))
    inertia = plan.blades.find_inertia()
    assert blades == pytest.approx(3.0 * inertia.mass, rel=1e-6)
    assert inertia.mass == pytest.approx(MASS, rel=2e-3)  # the prebent axis is a little longer
    # the trapezium of the masses along the span has its centre at 7.27 m
    assert inertia.centre[0] - 1.0 == pytest.approx(20.0 * (1.0 + 0.2) / 3.0 / 1.1, rel=2e-3)


def test_rigid_blades_have_the_inertia_of_the_matrices(path):
    changes = ["turbine.model=rigid", "pitch.bearings=true"]
    rigid, flexible = (build_turbine(Case.load(path, more), COMM) for more in (changes, []))
    (model,) = (m for m in flexible.system.flexible_models if m.is_small)
    blade = next(b for b in rigid.system.rigid_bodies if b.name == "blade_1")
    assert 3.0 * blade.mass == pytest.approx(
        on_rank0(COMM, lambda: model.nodal_mass @ model.is_point), rel=1e-6
    )


def test_modes_of_the_blades_are_named_and_damped_as_mu_says(path, tmp_path, capfd):
    from turbine_fenicsx.cli.main import main

    text = path.read_text()
    case = tmp_path / "modes.toml"
    case.write_text(text[: text.index("[wind]")] + text[text.index("[turbine]") :])
    (tmp_path / "small.yaml").write_text((path.parent / "small.yaml").read_text())
    more = [
        "--set",
        "turbine.rotor_speed=0",
        "--set",
        "tower.flexible=false",
        "--set",
        "loads.gravity=0",
    ]
    assert main(["modes", str(case), "-o", str(tmp_path / "out"), "--count", "8", *more]) == 0
    with (tmp_path / "out" / "modes.csv").open() as file:
        table = list(csv.DictReader(file))
    flap = [row for row in table if "first flap" in row["name"]]
    assert len(flap) == 3
    for row in flap:  # mu omega/2
        frequency = float(row["frequency_[Hz]"])
        wanted = 0.5 * 0.002 * 2.0 * np.pi * frequency
        assert float(row["damping_ratio_[-]"]) == pytest.approx(wanted, rel=1e-3)


def test_a_restart_continues_bit_for_bit(path, out):
    half = run(path, "half", "time.end=0.3", "output.checkpoint_wall_time=0")
    restart_case(half, COMM, ["time.end=0.5"], progress="none")
    mine, theirs = read(half), read(out)
    del mine["wall_time_[s]"], theirs["wall_time_[s]"]
    for name in theirs:
        assert np.array_equal(mine[name], theirs[name]), name


def test_recovered_fields_show_the_motion_of_beams(out):
    pytest.importorskip("h5py")
    run = RecordedRun.open(out, COMM)
    recovery = RunRecovery(run)
    recovery.find_fields(None).write(out / "fields.vtkhdf", [0, 5])
    state = recovery.motion.find_state(5)
    (model,) = (m for m in recovery.motion.turbine.system.flexible_models if m.is_small)
    x = (model.body.points + model.expand(state.u[0])).reshape(-1, 3)
    with VtkHdfFile(out / "fields.vtkhdf") as file:
        step = file.read(1)
        assert set(step.point_data) >= {"displacement", "velocity"}
        blades = np.unique(step.cell_data["part"])
        assert {2, 3, 4} <= set(blades.tolist())
        near = cKDTree(step.points).query(x)[0]
    corners = 3 * 2 * 7 * 8  # of 6 x 8 quadratic cells, of which the file has the corners alone
    assert np.count_nonzero(near < 1e-9) == corners
    with pytest.raises(InputError, match="there is no field 'tsai_wu', but displacement, velocity"):
        recovery.find_fields(["tsai_wu"])
    with pytest.raises(InputError, match="have no plies"):
        _ = recovery.plies


def test_loads_in_sections_are_recovered_as_the_run_has_seen_them(out):
    """Histories have means of two steps, and each of these the mean of its ends."""
    seen, run = read(out), RecordedRun.open(out, COMM)
    assert run.motion.times == pytest.approx(seen["time_[s]"])
    found = find_section_history(run, [0.0, 0.4])
    assert len(found) == 1 + 3 * 2 * 6
    del found[names.TIME]
    for name, values in found.items():
        wanted, means = seen[name], 0.25 * (values[:-2] + 2.0 * values[1:-1] + values[2:])
        assert wanted[2:] == pytest.approx(means, rel=1e-9, abs=1e-9 * np.abs(wanted).max()), name
    # at the ends they are those that are known, but for viscosity
    pairs = [(f"section_{{}}_{k}_at_0", f"root_{{}}_{k}") for k in (1, 2, 3)]
    for own, known in (*pairs, ("tower_{}_at_0", "tower_base_{}")):
        for what, unit in (("force", "N"), ("moment", "Nm")):
            one, other = (
                np.array([seen[f"{name.format(what)}_{axis}_[{unit}]"] for axis in "xyz"])
                for name in (own, known)
            )
            assert np.allclose(one, other, rtol=0.0, atol=0.03 * np.abs(other).max())
    with pytest.raises(InputError, match=r"--sections 1.5: expected fractions of the span"):
        find_section_history(run, [1.5])


def test_a_file_of_beamdyn_or_hawc2_takes_the_place_of_the_matrices(path, tmp_path):
    z = np.linspace(0.0, 1.0, 11)
    axis = np.column_stack([-0.5 * z**2, 0.0 * z, 20.0 * z, 10.0 - 11.0 * z])
    C, M = np.diag([1e8, 1e8, 1e9, 2e8, 1e8, 5e7]), np.diag([150.0] * 3 + [20.0, 8.0, 28.0])
    file = write_beamdyn(tmp_path, axis, [(0.0, C, M), (1.0, 0.2 * C, 0.2 * M)])
    case = Case.load(path, [f"blade.beam.file={file}"])
    assert case.blade.damping.mu == (1e-3, 1.1e-3, 1.2e-3, 1.4e-3, 2.2e-3, 2.2e-3)
    turbine = build_turbine(case, COMM)
    (model,) = (m for m in turbine.system.flexible_models if m.is_small)
    assert mass_of(model) == pytest.approx(3.0 * 0.6 * 150.0 * 20.0, rel=2e-3)
    of_hawc2 = Case.load(path, [f"blade.beam.file={write_hawc2(tmp_path)}"])
    assert of_hawc2.blade.damping.mu == (0.0, 0.0, 0.0, 2e-3, 1e-3, 3e-3)
    turbine = build_turbine(of_hawc2, COMM)
    (model,) = (m for m in turbine.system.flexible_models if m.is_small)
    assert mass_of(model) == pytest.approx(3.0 * 200.0 * 20.0, rel=2e-3)
    short = write_beamdyn(tmp_path, 0.9 * axis, [(0.0, C, M), (1.0, C, M)])
    with pytest.raises(InputError, match=r"bar\.dat has a blade of 18\.\d+ m, expected one of 20"):
        Case.load(path, [f"blade.beam.file={short}"])
    with pytest.raises(InputError, match=r"blade\.beam\.file.*nowhere\.dat"):
        Case.load(path, ["blade.beam.file=nowhere.dat"])


def test_damping_ratios_are_those_of_the_beam(path):
    ratios = ["blade.damping.flap_1=1 %", "blade.damping.edge_1=0.8 %"]
    with pytest.raises(InputError, match=r"blade\.damping\.mu: expected none beside flap_1"):
        Case.load(path, ["blade.damping.mu=[0.1, 0.1, 0.1, 0.1, 0.1, 0.1]", *ratios])
    case = Case.load(path, ["blade.damping = {flap_1 = 0.01, edge_1 = 0.008}"])
    assert case.blade.damping.mu is None
    turbine = build_turbine(case, COMM)
    (model,) = (m for m in turbine.system.flexible_models if m.is_small)
    assert model.body.basis.viscosity.size == 0
    assert turbine.part("damping_of_blades").stiffness > 0.0


def test_ratios_that_stiffness_and_mass_cannot_give_together_are_refused(path):
    case = Case.load(path, ["blade.damping = {flap_1 = 0.01, edge_1 = 0.25}"])
    (sentence,) = list_damping_mistakes(case, COMM)
    assert sentence.startswith("blade.damping.edge_1 = 0.25: expected ")
    fitting = Case.load(path, ["blade.damping = {flap_1 = 0.01, edge_1 = 0.008}"])
    assert list_damping_mistakes(fitting, COMM) == []


def test_files_with_a_layup_have_beams_too(tmp_path):
    tables = bare_turbine()
    whole = small_turbine()["components"]["blade"]["structure"]
    tables["components"]["blade"]["structure"] = whole | {"elastic_properties": section_matrices()}
    tables["materials"] = small_turbine()["materials"]
    case = write_beam_case(tmp_path, lambda t: t.update(tables))
    turbine = build_turbine(Case.load(case), COMM)
    (model,) = (m for m in turbine.system.flexible_models if m.is_small)
    assert on_rank0(COMM, lambda: model.nodal_mass @ model.is_point) == pytest.approx(
        3.0 * MASS, rel=2e-3
    )


def mass_of(model):
    """Mass of all blades [kg]."""
    return on_rank0(COMM, lambda: float(model.nodal_mass @ model.is_point))


def test_the_blade_of_iea15_has_the_frequencies_of_400_linear_elements():
    """Of BeamDyn's kind, with the matrices of the same file."""
    wanted = [0.5065, 0.6929, 1.4800, 2.1388, 2.9314, 4.0856, 4.3747, 4.8400, 6.787, 7.519]
    file = str(find_turbine("IEA-15-240-RWT.yaml"))
    blades = plan_rotor(
        Case.parse({"turbine": {"file": file}, "blade": {"model": "beam", "damping": 0.0}})
    ).blades
    box = box_carrier("blade", blades.line, (1.0, 1.0), 50, COMM)
    body = ReducedBody("blade", box.carrier, blades.make_basis(box.carrier, box.start))
    system = MultibodySystem(COMM, [body, Coupling("root", body, box.start, None)])
    found = [mode.frequency for mode in modes(system, count=10).modes]
    assert found == pytest.approx(wanted, rel=2e-3)


def drop_matrices(tables):
    """Leave neither layup nor matrices."""
    del tables["components"]["blade"]["structure"]["elastic_properties"]


def spoil_stiffness(tables):
    """Make the bending stiffness at the tip negative."""
    matrix = tables["components"]["blade"]["structure"]["elastic_properties"]["stiffness_matrix"]
    matrix["K44"][1] = -1.0


@pytest.mark.parametrize(
    ("change", "override", "sentence"),
    [
        (
            lambda tables: None,
            "blade.model=full",
            "which has no layup: components.blade.structure.layers",
        ),
        (
            lambda tables: None,
            "blade.model=reduced",
            "components.blade.structure.layers is missing",
        ),
        (drop_matrices, "time.end=1", "expected a file with the 6 x 6 matrices of the blade"),
        (
            lambda tables: None,
            "time.scheme=generalised_alpha",
            'blade.model = "beam": expected time.scheme = "energy_momentum"',
        ),
    ],
)
def test_cases_that_cannot_be_are_refused(tmp_path, change, override, sentence):
    path = write_beam_case(tmp_path, change)
    with pytest.raises(InputError) as caught:
        Case.load(path, [override])
    assert sentence in str(caught.value)


def test_rigid_blades_need_a_layup_or_matrices(tmp_path):
    tables = bare_turbine()
    del tables["components"]["blade"]["structure"]["elastic_properties"]
    path = write_turbine(tables, tmp_path)
    with pytest.raises(InputError, match=r"'small\.yaml' has neither"):
        Case.parse({"turbine": {"file": str(path), "model": "rigid"}})


def test_a_stiffness_that_is_not_positive_is_refused_with_its_station(tmp_path):
    path = write_beam_case(tmp_path, spoil_stiffness)
    with pytest.raises(ValueError, match=r"stiffness of the beam at 20\.\d+ m is not positive"):
        build_turbine(Case.load(path), COMM)


def test_a_file_without_blades_materials_needs_none(tmp_path):
    tables = bare_turbine()
    del tables["materials"], tables["components"]["tower"]
    write_turbine(tables, tmp_path)
    case = Case.parse(
        {
            "turbine": {"file": "small.yaml"},
            "blade": {"model": "beam"},
            "tower": {"flexible": False},
        },
        tmp_path,
    )
    system = build_turbine(case, COMM).system
    assert len(modes(system, count=3).modes) == 3


def test_a_tower_that_is_a_beam_has_the_frequencies_and_the_motion_of_a_tube(path):
    """Its frequencies are those of a mesh that is fine around and along."""
    found = []
    for model, elements in (("beam", "[4, 1, 4]"), ("full", "[16, 1, 10]")):
        changes = [f"tower.model={model}", f"tower.elements={elements}", "loads.gravity=0"]
        changes += ["blade.damping=0", "tower.damping=0", "turbine.rotor_speed=0"]
        case = Case.load(path, changes)
        calm = case.model_copy(update={"wind": type(case.wind)()})
        system = build_turbine(calm, COMM).system
        found.append([mode.frequency for mode in modes(system, count=6).modes])
    assert found[0] == pytest.approx(found[1], rel=5e-3, abs=1e-4)
    out = run(path, "beam tower", "tower.model=beam")
    seen = read(out)
    size = np.max(np.abs(seen["total_energy_[J]"]))
    # ten times solver.tolerance
    assert np.max(np.abs(seen["energy_error_[J]"])) < 1e-8 * size
    file = write_tower(path.parent)
    of_file = build_turbine(Case.load(path, ["tower.model=beam", f"tower.beam.file={file}"]), COMM)
    (tower,) = (m for m in of_file.system.flexible_models if m.body.name == "tower")
    height = of_file.case.tower.height
    mean = 1.1 * (0.25 * 5590.87 + 0.5 * 4500.0 + 0.25 * 3400.0)
    assert mass_of(tower) == pytest.approx(mean * height, rel=1e-9)
    with pytest.raises(InputError, match=r"tower\.beam\.file.*nowhere\.dat"):
        Case.load(path, ["tower.model=beam", "tower.beam.file=nowhere.dat"])
    run_again = RecordedRun.open(out, COMM)
    assert set(run_again.reduced) == {"blades", "tower"}
    assert RunRecovery(run_again).motion.find_state(3).time == pytest.approx(0.3)


def test_blades_that_turn_with_the_rotor_as_they_are_bent_have_no_shape_of_their_own(path):
    """Modes are named by the motion of blades relative to the rotor, also where weight bends."""
    calm = ["turbine.rotor_speed=0", "wind.speed=0", "time.start=equilibrium"]
    case = Case.load(path, [*calm, "loads.gravity=300", "tower.flexible=false"])
    turbine = build_turbine(case, COMM)
    system = turbine.system
    state = equilibrium(system, held=system.joint_coordinate_names)
    axis, centre = np.array(turbine.rotor.layout.axis), np.array(turbine.rotor.layout.centre)
    motion = state.copy()
    for model, u, du in zip(system.flexible_models, state.u, motion.u, strict=True):
        at = model.positions + u.array.reshape(-1, 3) - np.outer(model.is_point, centre)
        du.array[:] = np.cross(axis, at).ravel()
    for k in range(0, len(state.q), 12):
        at = state.q[k : k + 12].reshape(4, 3) - np.outer([1.0, 0.0, 0.0, 0.0], centre)
        motion.q[k : k + 12] = np.cross(axis, at).ravel()
    whole = Motion(motion.q, motion.joint_coordinates, motion.u)
    parts = find_slender_parts(turbine, state)
    for name in BLADES:
        moved = parts[name].sections.motion(parts[name].sections.positions)
        assert np.abs(parts[name].shape(whole)).max() < 1e-9 * np.abs(moved).max()

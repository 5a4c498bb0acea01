"""Claims about turbines with reduced blades: they run as those with full blades do."""

import json
import shutil
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from reduced_turbines import COMM, read, run, write_case

from turbine_fenicsx.analysis import turning
from turbine_fenicsx.analysis.damped_modes import damped_modes
from turbine_fenicsx.foundation.errors import InputError, ModelWarning, StepFailure
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.materials.laminate_theory import reduced_stiffness
from turbine_fenicsx.materials.ply_failure import CRITERIA
from turbine_fenicsx.records.motion_file import read_motion
from turbine_fenicsx.reduction.basis_file import read_sizes
from turbine_fenicsx.system.system import MultibodySystem
from turbine_fenicsx.turbine.blades.blade_plan import ROOTS
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.flexible_blades import find_plies
from turbine_fenicsx.turbine.components.gauges import make_gauges
from turbine_fenicsx.turbine.components.model import build_turbine
from turbine_fenicsx.turbine.run.full_motion import FullMotion
from turbine_fenicsx.turbine.run.gauge_history import find_gauge_history
from turbine_fenicsx.turbine.run.ply_history import PlyRecovery
from turbine_fenicsx.turbine.run.recorded_run import RecordedRun
from turbine_fenicsx.turbine.run.run import restart_case
from turbine_fenicsx.turbine.run.start import make_start
from turbine_fenicsx.turbine.run.wall_history import WallPlace, find_wall_history
from turbine_fenicsx.turbine.run.worst_moment import find_worst_moment

FULL = "blade.model=full"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The case, with its basis beside it after the first run."""
    folder = on_rank0(COMM, lambda: tmp_path_factory.mktemp("reduced"))
    return write_case(folder)


@pytest.fixture(scope="module")
def runs(path):
    """Columns of the reduced and of the full turbine."""
    return [read(run(path, name, *more)) for name, more in (("reduced", ()), ("full", (FULL,)))]


def error(runs, name):
    """Largest difference of a column, relative to its largest value in the full turbine."""
    reduced, full = (columns[name] for columns in runs)
    return np.max(np.abs(reduced - full)) / np.max(np.abs(full))


@pytest.mark.parallel
def test_loads_and_power_are_those_of_full_blades(runs):
    for name in ("aero_power_[W]", "aero_thrust_[N]", "root_moment_1_y_[Nm]", "root_force_2_z_[N]"):
        assert error(runs, name) < 2e-3, name
    assert error(runs, "root_moment_3_x_[Nm]") < 2e-3
    assert error(runs, "root_moment_2_z_[Nm]") < 5e-3


def test_tips_and_strains_are_those_of_full_blades(runs):
    for name in ("tip_flap_1_[m]", "tip_flap_3_[m]", "tip_edge_2_[m]", "strain_root_[-]"):
        assert error(runs, name) < 0.02, name
    assert error(runs, "tip_clearance_1_[m]") < 1e-3
    for k in (1, 2, 3):  # they twist by half a tenth of a degree
        reduced, full = (columns[f"twist_{k}_at_0.7_[rad]"] for columns in runs)
        assert 1e-4 < np.max(np.abs(full)) < 2e-3
        assert np.max(np.abs(reduced - full)) < 1e-4


def test_a_reduced_tower_is_the_full_one(path, runs):
    found = read(run(path, "tower", "tower.model=reduced")), runs[1]
    for name in ("tower_top_displacement_x_[m]", "tower_base_moment_y_[Nm]"):
        assert error(found, name) < 0.01, name
    assert error(found, "root_moment_1_y_[Nm]") < 2e-3
    energy = found[0]["energy_error_[J]"]
    assert np.max(np.abs(energy)) < 1e-9 * np.max(np.abs(found[0]["total_energy_[J]"]))
    assert list(found[0]) == list(runs[0])


def test_histories_have_the_columns_of_full_blades_but_for_failure(runs):
    reduced, full = map(list, runs)
    assert reduced == [name for name in full if "tsai_wu" not in name]


@pytest.fixture(scope="module")
def recorded(path, runs):
    """Folder of the run with reduced blades."""
    return path.parent / "reduced"


@pytest.mark.parallel
def test_recovered_plies_fail_as_those_of_full_blades(recorded, runs):
    found, full = PlyRecovery(RecordedRun.open(recorded, COMM)).find_history().columns(), runs[1]
    rows = np.searchsorted(full["time_[s]"], found["time_[s]"] - 1e-9)
    assert len(rows) == 6
    indices = [name for name in full if name.endswith("tsai_wu_[-]")]
    assert len(indices) > 5
    largest = max(np.max(full[name]) for name in indices)
    assert largest > 1e-3
    for name in indices:
        assert np.max(np.abs(found[name] - full[name][rows])) < 0.05 * largest, name
    assert set(found) - set(full) == {
        name.replace("tsai_wu_[-]", f"tsai_wu_{what}_[-]")
        for name in indices
        for what in ("ply", "blade")
    }


@pytest.mark.parallel
def test_the_history_of_a_place_is_that_of_a_cell_in_the_middle_of_its_panel(recorded):
    recovery = PlyRecovery(RecordedRun.open(recorded, COMM))
    panel = "spar_cap_suction_side"
    length = recovery.run.turbine.rotor.blades.length
    history = find_wall_history(recovery, WallPlace(0.4, panel))
    count = len(history.plies)
    found = np.array(
        [
            [history.columns[f"ply_{k + 1}_blade_{b}_tsai_wu_[-]"] for k in range(count)]
            for b in (1, 2, 3)
        ]
    )
    of_cells = np.array(
        [
            recovery.recovered.find_largest(CRITERIA["tsai_wu"], recovery.vectors[:, copy], copy)[0]
            for copy in range(3)
        ]
    )
    cells = recovery.plies.panels[panel]
    places = recovery.plies.place[cells]
    mine = cells[np.isclose(places, history.distance)]
    same = [np.allclose(found.max(axis=1), of_cells[:, k], rtol=1e-9, atol=0.0) for k in mine]
    assert sum(COMM.allgather(sum(same))) == 1
    nearest = min(COMM.allgather(float(np.min(np.abs(places - 0.4 * length), initial=np.inf))))
    assert abs(history.distance - 0.4 * length) == pytest.approx(nearest)
    ply = history.plies[-1]
    of_ply = [
        np.array([history.columns[f"ply_{count}_blade_3_{name}"] for name in names])
        for names in (
            [f"strain_{c}_[-]" for c in ("11", "22", "12")],
            [f"stress_{c}_[Pa]" for c in ("11", "22", "12")],
        )
    ]
    assert reduced_stiffness(ply.material) @ of_ply[0] == pytest.approx(of_ply[1], rel=1e-9)
    assert np.max(np.abs(of_ply[0])) > 1e-5
    alone = find_wall_history(recovery, WallPlace(0.4, panel, count)).columns
    assert len(alone) == 1 + 3 * 7
    assert all(np.array_equal(values, history.columns[name]) for name, values in alone.items())


def test_recovered_gauges_are_those_that_the_run_has_read(recorded):
    seen = read(recorded)
    more = ["output.gauges.new.station=0.6", 'output.gauges.new.around="leading edge"']
    found = find_gauge_history(RecordedRun.open(recorded, COMM, more))
    rows = np.searchsorted(seen["time_[s]"], found["time_[s]"] - 1e-9)
    assert found["strain_root_[-]"] == pytest.approx(seen["strain_root_[-]"][rows], rel=1e-9)
    assert np.max(np.abs(found["strain_new_[-]"])) > 1e-6


@pytest.mark.parallel
def test_the_motion_on_full_meshes_is_that_of_the_run(recorded):
    run, seen = RecordedRun.open(recorded, COMM), read(recorded)
    with pytest.warns(ModelWarning, match="motion of a tower") if COMM.rank == 0 else nullcontext():
        motion = FullMotion(run)
    turbine = motion.turbine
    (full,) = turbine.system.flexible_models
    (reduced,) = (m for m in run.turbine.system.flexible_models if m.is_small)
    plies, gauges = find_plies(turbine), make_gauges(turbine, full.body)
    history = PlyRecovery(run).find_history()
    u, v = reduced.new_vector(), reduced.new_vector()
    rows = range(0, len(run.motion.times), 2)
    for row, time in zip(rows, run.motion.times[::2], strict=True):
        state = motion.find_state(row)
        assert state.time == time
        plies.stresses.update(state)
        index = plies.stresses.largest(CRITERIA["tsai_wu"])[0]
        for k, cells in enumerate(plies.panels.values()):
            worst = cells[np.argsort(index[cells])][-1:]
            of_ranks = COMM.allgather((*index[worst], *plies.place[worst]) or (-1.0, 0.0))
            found = history.index[row, k], history.place[row, k]
            assert max(of_ranks) == pytest.approx(found, rel=1e-9, abs=1e-11)
        near = int(np.argmin(np.abs(seen["time_[s]"] - time)))
        (strain,) = gauges.strains(state)
        assert strain == pytest.approx(seen["strain_root_[-]"][near], rel=1e-8, abs=1e-12)
        z, z_dot = run.motion.vectors["blades"][row], run.motion.velocities["blades"][row]
        u.array[:] = (z.reshape(-1, 3)[: reduced.n_owned] - reduced.positions).ravel()
        v.array[:] = z_dot.reshape(-1, 3)[: reduced.n_owned].ravel()
        mine, theirs = (
            COMM.allreduce(model.integrals(*motions))[:-1]  # the strain energy has fewer terms
            for model, motions in ((full, (state.u[0], state.v[0])), (reduced, (u, v)))
        )
        assert mine == pytest.approx(theirs, rel=1e-9, abs=1e-9 * np.max(np.abs(theirs)))


@pytest.mark.parametrize("criterion", CRITERIA)
def test_the_worst_moment_is_the_largest_of_all(recorded, criterion):
    recovery = PlyRecovery(RecordedRun.open(recorded, COMM))
    history = recovery.find_history(criterion)
    worst = find_worst_moment(recovery, history)
    assert worst.index == np.max(history.index)
    assert 1 <= worst.ply <= worst.plies and worst.blade in (1, 2, 3)
    shares = [abs(s) / r for s, r in zip(worst.stresses, worst.strengths, strict=True)]
    if criterion == "maximum_stress":
        assert max(shares) == pytest.approx(worst.index, rel=1e-9)
    seen = read(recorded)
    row = max(1, int(np.argmin(np.abs(seen["time_[s]"] - worst.time))))  # history.out has no first
    speed = worst.channels["RotSpeed_[rpm]"]
    assert speed == pytest.approx(seen["rotor_speed_[rpm]"][row], rel=1e-5)
    assert f"{worst.material} at" in str(worst) and worst.panel in str(worst)


def test_the_balance_of_energy_closes(runs):
    reduced = runs[0]
    size = np.max(np.abs(reduced["total_energy_[J]"]))
    assert np.max(np.abs(reduced["energy_error_[J]"])) < 1e-9 * size
    assert np.max(np.abs(reduced["work_of_wind_[J]"])) > 1e-3 * size
    works = sum(reduced[f"aero_work_{k}_[J]"] for k in (1, 2, 3))
    assert works == pytest.approx(reduced["work_of_wind_[J]"], abs=1e-9 * size)


@pytest.mark.parametrize("start", ["equilibrium", "turning"])
def test_runs_start_as_those_of_full_blades(path, start):
    speed = "0 rpm" if start == "equilibrium" else "25 rpm"
    changes = [f"time.start={start}", f"turbine.rotor_speed={speed}", "time.end=0.1"]
    changes += ["pitch.initial=5 deg", "pitch.drive=spring", "pitch.stiffness=1e8"]
    changes += ["pitch.damping=1e6"]
    first = [
        read(run(path, f"{start} {model}", *changes, f"blade.model={model}"))
        for model in ("reduced", "full")
    ]
    for name in ("tip_flap_1_[m]", "tip_flap_2_[m]", "aero_power_[W]"):
        reduced, full = (columns[name][0] for columns in first)
        assert reduced == pytest.approx(full, rel=0.02, abs=1e-9), name


def test_a_restart_takes_the_basis_of_its_run_and_continues_bit_for_bit(path):
    changes = ["tower.model=reduced", "output.checkpoint_wall_time=0"]
    whole = run(path, "whole", "time.end=0.3", *changes)
    half = run(path, "half", "time.end=0.2", *changes)
    bases = path.parent / "bases"
    elsewhere = path.parent / "moved"
    on_rank0(COMM, lambda: shutil.move(bases, elsewhere))
    try:
        restart_case(half, COMM, ["time.end=0.3"], progress="none")
    finally:
        on_rank0(COMM, lambda: shutil.move(elsewhere, bases))
    mine, theirs = read(half), read(whole)
    del mine["wall_time_[s]"], theirs["wall_time_[s]"]
    for name in theirs:
        assert np.array_equal(mine[name], theirs[name]), name
    files = [
        on_rank0(COMM, lambda f=folder: (f / "motion.bin").read_bytes()) for folder in (half, whole)
    ]
    assert files[0] == files[1]


@pytest.mark.parallel
def test_the_motion_that_is_stored_is_that_of_the_run(path, runs):
    out = path.parent / "reduced"
    motion = on_rank0(COMM, lambda: read_motion(out / "motion.bin"))
    assert motion.times == pytest.approx(np.linspace(0.0, 0.5, 6))
    (blades,) = motion.bodies
    assert (blades.name, blades.copies, blades.vectors) == ("blades", 3, 34)
    turbine = build_turbine(Case.load(path), COMM)
    (model,) = (m for m in turbine.system.flexible_models if m.is_small)
    assert blades.meaning == model.meaning
    # tips as the history has them, in the frames of the rings
    F, points = model.body.basis.functions, model.body.points
    x = F @ motion.vectors["blades"][-1]
    for k, tip in enumerate(turbine.rotor.tips):
        row = np.argmin(np.linalg.norm(points[k] - tip, axis=1))
        ring = turbine.part(f"ring_{k + 1}")
        q = motion.q[-1].reshape(-1, 4, 3)[motion.rigid.index(ring.name)]
        arm = ring.body_coordinates(points[k, row])
        deflection = np.linalg.norm(q[1:] @ (x[k, row] - q[0]) - arm)
        assert deflection == pytest.approx(runs[0][f"tip_deflection_{k + 1}_[m]"][-1], rel=1e-6)
    step = motion.vectors["blades"][1] - motion.vectors["blades"][0]
    mean = 0.5 * (motion.velocities["blades"][1] + motion.velocities["blades"][0])
    assert np.abs(step - 0.1 * mean).max() < 0.1 * np.abs(step).max()


def test_the_basis_is_made_once_and_known_by_what_it_depends_on(path, runs):
    bases = path.parent / "bases"
    before = on_rank0(COMM, lambda: sorted(bases.iterdir()))
    assert {file.suffix for file in before} == {".npz"}
    run(path, "again", "time.end=0.05", "blade.damping=0.02", "wind.speed=11 m/s")
    assert on_rank0(COMM, lambda: sorted(bases.iterdir())) == before
    (blade,) = (file for file in before if file.name.startswith("blade-"))
    sizes = on_rank0(COMM, lambda: read_sizes(blade))
    assert (sizes.functions, sizes.strains) == (30, 3 * 30 + 6 + 25)


def test_a_basis_of_other_blades_is_refused(path, runs):
    bases = path.parent / "bases"
    (file,) = on_rank0(COMM, lambda: list(bases.glob("blade-*.npz")))
    named = f"blade.reduction.file={file}"
    for change in ("blade.hub_radius=1.2 m", "blade.layup=laminate", "mesh.around=10"):
        case = Case.load(path, [named, change])
        with pytest.raises(InputError, match=r"is not a basis of 'blade', (the|its)"):
            build_turbine(case, COMM)
    build_turbine(Case.load(path, [named]), COMM)


def test_modes_of_clamped_reduced_blades_have_the_ratios(path, runs):
    ratios = ["blade.damping.flap_1=0.005", "blade.damping.edge_1=0.006"]
    turbine = build_turbine(Case.load(path, ratios), COMM)
    blades, damping = turbine.part("blades"), turbine.part("damping_of_blades")
    roots = [replace(turbine.part(name), rigid=None) for name in ROOTS]
    found = damped_modes(MultibodySystem(COMM, [blades, damping, *roots]), count=6)
    asked = np.repeat([0.005, 0.006], 3)
    assert [mode.damping_ratio for mode in found.modes] == pytest.approx(asked, rel=1e-3)


def test_summaries_have_the_masses_and_the_inertia_of_full_blades(path, runs):
    summaries = [
        on_rank0(COMM, lambda n=name: json.loads((path.parent / n / "summary.json").read_text()))
        for name in ("reduced", "full")
    ]
    a, b = summaries
    assert a["masses_[kg]"]["blades"] == pytest.approx(b["masses_[kg]"]["blades"], rel=1e-9)
    assert a["rotor_inertia_[kgm2]"] == pytest.approx(b["rotor_inertia_[kgm2]"], rel=1e-9)


def test_a_start_of_reduced_walls_that_snap_is_near_an_equilibrium(path, monkeypatch, caplog):
    reduced, beside_full = (
        (case, build_turbine(case, COMM).system)
        for case in (Case.load(path, changes) for changes in (["tower.model=reduced"], []))
    )
    exact, solve = make_start(*reduced), turning.solve_load_step

    def refuse(blocks, solver, time, tolerance, *more, **options):
        if blocks.part == 1.0 and tolerance < turning.LOOSE:
            raise StepFailure("walls snap")
        return solve(blocks, solver, time, tolerance, *more, **options)

    monkeypatch.setattr(turning, "solve_load_step", refuse)
    near = make_start(*reduced)
    for a, b in zip(near.u, exact.u, strict=True):
        assert 0.0 < (a - b).norm() < turning.LOOSE * b.norm()
    if COMM.rank == 0:
        assert turning.NEAR.format(turning.LOOSE) in caplog.text
    with pytest.raises(StepFailure, match="walls snap"):
        make_start(*beside_full)

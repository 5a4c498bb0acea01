"""The command ``modes``: what it prints, writes and refuses."""

import csv
import importlib.util
import os
import re
import shutil
import signal

import numpy as np
import pytest
from aero_files import write_aerodyn
from outputs import read_fields

from turbine_fenicsx.analysis.bordered_solver import BorderedSolver
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.records import names
from turbine_fenicsx.records.mode_tables import read_table

pytest.importorskip("slepc4py")
SMALL = ("--set", "mesh.elements=[1,1,6]")
# with a rotor that is about to turn over, see below, the zeros of yaw and rotor are so close that
# round-off mixes them
LOCKED = ("--lock", "rotor", "--quiet")
TOWER = (*SMALL, "tower.flexible=true", "tower.elements=[4,1,3]", "tower.degree=1")


@pytest.fixture(scope="module")
def case(request):
    """Path of a case of the hybrid turbine."""
    return str(request.config.rootpath / "demos" / "paper" / "hybrid_stiff.toml")


@pytest.fixture(scope="module")
def out(case, tmp_path_factory):
    """Folder with eight modes of a turbine on a flexible tower."""
    folder = tmp_path_factory.mktemp("modes") / "out"
    assert main(["modes", case, "--count", "8", "-o", str(folder), *LOCKED, *TOWER]) == 0
    return folder


def is_refused(command, capfd, pattern):
    """Exit code 2 and one sentence."""
    capfd.readouterr()
    assert main(command) == 2
    printed = capfd.readouterr()
    assert printed.out == ""
    (sentence,) = [line for line in printed.err.splitlines() if not line.startswith("warning")]
    assert re.match(rf"error: .*{pattern}", sentence), sentence


def test_table_on_the_screen_names_the_modes(case, capfd):
    assert main(["modes", case, "--count", "4", "--lock", "rotor", "yaw", *SMALL]) == 0
    head, columns, *lines = capfd.readouterr().out.splitlines()
    assert head == "modes at rest"
    assert columns.split() == "f [Hz] blade 1 blade 2 blade 3 nacelle and hub moves name".split()
    assert [line.split("  ")[-1] for line in lines] == [
        "first flap, blade 2 alone",
        "first flap, blade 1 alone",
        "first flap, blade 3 alone",
        "first edge, blade 2 alone",
    ]
    assert all("100 %" in line for line in lines)


def test_what_is_not_locked_is_free(case, capfd):
    assert main(["modes", case, "--count", "3", *SMALL, "loads.gravity=0"]) == 0
    lines = capfd.readouterr().out.splitlines()[2:]
    assert [line.split("  ")[-1] for line in lines[:2]] == ["free yaw", "free rotor"]
    assert all(float(line.split()[1]) == 0.0 for line in lines[:2]) and "flap" in lines[2]


def test_what_grows_is_told(case, tmp_path, capfd):
    """Bent by their weight, three blades with one upright are about to turn over, very slowly."""
    command = ["modes", case, "--count", "2", "-o", str(tmp_path), *SMALL]
    assert main(command) == 0
    line = capfd.readouterr().out.splitlines()[2]
    assert line.split()[:2] == ["1", "grows"] and line.endswith("  swinging rotor")
    row, _ = read_table(tmp_path / "modes.csv")
    assert 1e-3 < row[names.GROWTH_RATE] < 3e-3 and row[names.FREQUENCY] == 0.0
    assert "swinging rotor\\ngrows by a factor of e in " in (tmp_path / "modes.xdmf").read_text()


def test_a_rigid_turbine_has_as_many_modes_as_joints(case, capfd):
    command = ["modes", case, "--set", "turbine.model=rigid", "pitch.stiffness=5e6"]
    assert main([*command, "pitch.drive=spring"]) == 0
    names_of_modes = [line.split("  ")[-1] for line in capfd.readouterr().out.splitlines()[2:]]
    assert len(names_of_modes) == 5
    assert sum("on springs" in name for name in names_of_modes) == 3, names_of_modes


def test_all_numbers_are_in_the_table_of_the_folder(out):
    rows = read_table(out / "modes.csv")
    assert [row[names.MODE] for row in rows] == list(range(1, 9))
    frequencies = [row[names.FREQUENCY] for row in rows]
    assert frequencies == sorted(frequencies) and frequencies[0] == 0.0 < frequencies[1]
    masses = names.MODAL_MASS.find(rows[0])
    assert list(masses) == ["blade_1", "blade_2", "blade_3", "tower", "nacelle_and_hub"]
    for row in rows:
        assert sum(row[c] for c in masses.values()) == pytest.approx(1.0, abs=1e-9)
        moves = sum(row[c] for c in names.MOTION_SHARE.find(row).values())
        assert moves == pytest.approx(0.0 if row[names.FREQUENCY] == 0.0 else 1.0, abs=1e-9)
    assert [row["name"] for row in rows[:3]] == [
        "free yaw",
        "first fore-aft of the tower",
        "first side-side of the tower",
    ]
    assert rows[1]["share_of_fore_aft_[-]"] > 0.8 and rows[2]["share_of_side_side_[-]"] > 0.8


def test_shapes_have_one_time_for_each_mode(out):
    fields = read_fields(out / "modes.xdmf")
    assert list(fields) == [float(n) for n in range(1, 9)]
    moved = np.linalg.norm(fields[3.0]["mode_real"], axis=1)
    parts = fields[3.0]["part"]
    assert set(parts) == {0, 1, 2, 3, 4, 5}
    assert moved.max() > 5.0 and np.isfinite(moved).all()


def test_ranks_agree_on_modes_of_equal_frequencies(command_line, case, tmp_path):
    found = []
    for ranks in (1, 2):
        target = tmp_path / str(ranks)
        options = ["--count", "8", "--lock", "rotor", "yaw", "--quiet", *SMALL, "loads.gravity=0"]
        result = command_line("modes", case, "-o", target, *options, ranks=ranks)
        assert result.returncode == 0, result.stderr
        with open(target / "modes.csv", newline="") as file:
            found.append(list(csv.reader(file)))
    first, *others = found
    assert [row[-1] for row in first[1:4]] == [f"first flap, blade {k} alone" for k in (2, 1, 3)]
    for other in others:
        assert [row[-1] for row in other] == [row[-1] for row in first]
        one, two = (np.array([r[:-1] for r in rows[1:]], dtype=float) for rows in (first, other))
        assert np.allclose(one, two, rtol=0.0, atol=1e-8)


def test_modes_are_not_overwritten_unasked(case, out, capfd, monkeypatch):
    before = (out / "modes.csv").read_bytes()

    def build(*_):
        raise AssertionError("heavy work before the refusal")

    command = ["modes", case, "--count", "2", "-o", str(out), *SMALL]
    with monkeypatch.context() as patch:
        patch.setattr("turbine_fenicsx.turbine.modes.find_modes.build_turbine", build)
        is_refused(command, capfd, "holds modes; --overwrite replaces them")
    assert (out / "modes.csv").read_bytes() == before


def test_overwriting_leaves_nothing_of_before(case, out, tmp_path):
    target = tmp_path / "again"
    shutil.copytree(out, target)
    (target / "mode_7.png").touch()
    (target / "campbell.csv").touch()
    (target / "notes.txt").touch()
    command = ["modes", case, "--count", "2", "-o", str(target), "--quiet", "--overwrite", *SMALL]
    assert main(command) == 0
    kept = {path.name for path in target.iterdir()}
    assert kept == {".lock", "case.json", "modes.bin", "modes.csv", "modes.xdmf", "notes.txt"}
    assert len(read_table(target / "modes.csv")) == 2


def test_a_run_and_modes_do_not_share_a_folder(case, out, tmp_path, capfd):
    run, folder = ["run", case, "--quiet", *SMALL, "time.end=0.04"], str(tmp_path / "run")
    is_refused([*run, "-o", str(out)], capfd, "holds modes; --overwrite replaces them")
    is_refused(["restart", str(out)], capfd, "there is no run in .* to resume")
    assert main([*run, "-o", folder]) == 0
    modes = ["modes", case, "--count", "2", "-o", folder, "--overwrite", *SMALL]
    is_refused(modes, capfd, "holds the results of a run; modes need another folder")
    assert (tmp_path / "run" / "summary.json").exists()
    target = tmp_path / "both"
    shutil.copytree(out, target)
    assert main([*run, "-o", str(target), "--overwrite"]) == 0
    assert not list(target.glob("mode*"))


MISTAKES = {
    "no modes": (["--count", "0"], "--count 0: must be at least 1"),
    "more than there are": (["--count", "900"], "900 modes, but the system has .* degrees"),
    "speed without unit": (["--speed", "12"], '--speed 12: give a number and rpm, .* "12 rpm"'),
    "speed of another kind": (["--speed", "12 m/s"], "--speed 12 m/s: give a number and rpm"),
    "speeds without unit": (["--speeds", "0:14:2"], "--speeds 0:14:2: give START:END:STEP and rpm"),
    "no range": (["--speeds", "0:14", "rpm"], "--speeds 0:14 rpm: give START:END:STEP"),
    "backwards": (["--speeds", "14:0:2", "rpm"], "--speeds 14:0:2 rpm: the end must be above"),
    "no step": (["--speeds", "0:14:0", "rpm"], "--speeds 0:14:0 rpm: the end must be above"),
    "many speeds": (["--speeds", "0:14:0.01", "rpm"], "these are 1401 speeds, from 2 to 200"),
    "one speed": (["--speeds", "0:14:20", "rpm"], "these are 1 speeds, from 2 to 200"),
    "hardly a speed": (["--speed", "1e-300 rpm"], "a rotor speed of .*: expected 0, or 1e-06"),
    "a speed of no rotor": (["--speed", "1e300 rpm"], "a rotor speed of .*: expected 0, or 1e-06"),
    "a rotor that cannot turn": (["--speed", "9 rpm", "--lock", "rotor"], "a brake on 'rotor'"),
    "unknown joint": (["--lock", "nose"], "'nose'; there are .*rotor.*yaw"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence(case, capfd, mistake):
    options, pattern = MISTAKES[mistake]
    is_refused(["modes", case, *options, *SMALL], capfd, pattern)


def test_without_slepc_one_sentence_says_what_brings_it(case, capfd, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "slepc4py", None)
    is_refused(["modes", case, *SMALL], capfd, "modes need slepc4py, which .* does not have")


def test_memory_is_looked_at_unless_forced(case, capfd, monkeypatch):
    memory = "turbine_fenicsx.linear_solvers.memory.machine_memory"
    monkeypatch.setattr(memory, lambda comm: 1e5)
    command = ["modes", case, "--count", "2", *SMALL]
    is_refused(command, capfd, "displacements need .* of memory .*; --force continues anyway")
    assert main([*command, "--force", "--quiet"]) == 0


def test_pictures_and_page_are_drawn_from_the_folder(out, tmp_path, capfd):
    pytest.importorskip("pyvista")
    options = ["--modes", "3,4", "--size", "200x240", "-o", str(tmp_path)]
    if main(["render", str(out), *options]) != 0:
        pytest.skip(capfd.readouterr().err)
    paths = [f"{tmp_path}/{name}.png" for name in ("mode_3", "mode_4", "modes")]
    assert capfd.readouterr().out.splitlines() == paths
    page = tmp_path / "page.html"
    assert main(["report", str(out), "-o", str(page)]) == 0
    text = page.read_text()
    assert "first fore-aft of the tower" in text and text.count("<img") == 1
    assert "flexible" in text  # the case


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        (["--modes", "9"], "--modes 9: they are numbered from 1 to 8"),
        (["--modes", "1.5"], "--modes 1.5: they are numbered"),
        (["--times", "0,1"], "--times 0,1: modes have none"),
        (["--movie", "a.mp4"], "--movie shows one mode"),
        (["--movie", "a.gif", "--modes", "1"], "ends in .mp4"),
    ],
)
def test_render_says_what_modes_do_not_have(out, capfd, options, pattern):
    is_refused(["render", str(out), *options], capfd, pattern)


@pytest.mark.slow
def test_a_mode_moves_in_a_movie(out, tmp_path, capfd):
    pytest.importorskip("imageio_ffmpeg")
    pytest.importorskip("pyvista")
    movie = str(tmp_path / "mode.mp4")
    if main(["render", str(out), "--modes", "3", "--movie", movie, "--size", "100x120"]) != 0:
        pytest.skip(capfd.readouterr().err)
    assert capfd.readouterr().out == f"{movie}\n"
    assert os.path.getsize(movie) > 3000


def test_speeds_give_a_campbell_diagram(case, tmp_path, capfd):
    folder = tmp_path / "speeds"
    options = ["--count", "7", "-o", str(folder)]  # nothing holds the yaw
    assert main(["modes", case, "--speeds", "0:12:12", "rpm", *options, *TOWER]) == 0
    printed = capfd.readouterr()
    assert "speed 1 of 2: 0 rpm\nspeed 2 of 2: 12 rpm\n" in printed.err
    assert printed.out.startswith("modes at 12 rpm\n")
    rows = read_table(folder / "modes.csv")
    assert [row[names.SPEED] for row in rows] == pytest.approx([0.0] * 7 + [12.0] * 7)
    assert [row[names.FREQUENCY] for row in read_table(folder / "campbell.csv")] == [
        row[names.FREQUENCY] for row in rows
    ]
    found = {row["name"]: row[names.FREQUENCY] for row in rows[7:]}
    assert {"free rotor", "free yaw", "first fore-aft of the tower"} < found.keys()
    assert all(row[names.GROWTH_RATE] == 0.0 for row in rows)
    assert len(read_fields(folder / "modes.xdmf")) == 7
    if importlib.util.find_spec("matplotlib"):
        assert (folder / "campbell.png").stat().st_size > 20_000


def test_without_any_force_everything_is_free(request, capfd):
    rigid = str(request.config.rootpath / "demos" / "paper" / "rigid.toml")
    assert main(["modes", rigid, "--set", "loads.gravity=0"]) == 0
    printed = capfd.readouterr().out
    assert "free" in printed and "swinging" not in printed and "grows" not in printed


def test_dampers_show_in_the_table(case, capfd):
    command = ["modes", case, "--count", "2", "--lock", "rotor", "yaw", *SMALL]
    assert main([*command, "material.shear_viscosity=1e6"]) == 0
    _, columns, line, _ = capfd.readouterr().out.splitlines()
    assert "damping" in columns and float(line.split()[2]) > 0.0


def test_ctrl_c_leaves_the_speeds_so_far_and_code_130(case, tmp_path, capfd, monkeypatch):
    from turbine_fenicsx.cli.commands import modes

    def interrupted(table, *_):
        signal.raise_signal(signal.SIGINT)
        return False

    monkeypatch.setattr(modes, "_show", interrupted)
    options = ["--count", "2", "--lock", "yaw", "-o", str(tmp_path), *SMALL]
    assert main(["modes", case, "--speeds", "0:12:4", "rpm", *options]) == 130
    assert "interrupted; what was written so far is complete" in capfd.readouterr().err
    assert len(read_table(tmp_path / "modes.csv")) == 2


@pytest.mark.parametrize("speeds", [0, 1])
def test_a_signal_ends_an_iteration_at_once(case, tmp_path, capfd, monkeypatch, speeds):
    """Inside of SLEPc, after one more solve at most; earlier speeds are written."""
    from turbine_fenicsx.cli.commands import modes

    solve, shown, made = BorderedSolver.solve, [], []

    def count(self, b, y):
        made.append(len(shown) == speeds)
        if sum(made) == 5:
            signal.raise_signal(signal.SIGTERM)
        solve(self, b, y)

    monkeypatch.setattr(BorderedSolver, "solve", count)
    monkeypatch.setattr(modes, "_show", lambda table, *_: shown.append(table))
    options = ["--count", "2", "--lock", "yaw", "-o", str(tmp_path / "out"), *SMALL]
    assert main(["modes", case, "--speeds", "0:12:4", "rpm", *options]) == 130
    assert "interrupted; what was written so far is complete" in capfd.readouterr().err
    assert sum(made) == 5 and len(shown) == speeds
    written = tmp_path / "out" / "modes.csv"
    assert written.exists() == bool(speeds)
    assert not speeds or len(read_table(written)) == 2


def test_the_case_says_how_fast_the_rotor_turns_and_where_it_stands(case, capfd):
    lock = ["--count", "2", "--lock", "yaw"]
    command = ["modes", case, *lock, *SMALL, "turbine.rotor_speed=12 rpm"]
    assert main(command) == 0
    turning = capfd.readouterr().out
    assert turning.startswith("modes at 12 rpm\n") and "free rotor" in turning
    assert main([*command, "--at-rest", "--set", "turbine.azimuth=60 deg"]) == 0
    printed = capfd.readouterr().out
    assert printed.startswith("modes at rest\n")
    # blade 2 no longer stands upright, blade 1 hangs straight down: nothing wants to turn over
    assert "grows" not in printed
    is_refused(
        [*command[:2], "--lock", "rotor", *SMALL, "turbine.azimuth=60 deg"],
        capfd,
        "a brake on 'rotor' holds it at turbine.azimuth = 0 only",
    )


@pytest.mark.parametrize(
    ("more", "tables"),
    [
        ('[event.stop]\nkind = "grid_loss"\n', "[control] and [event]"),
        ("[wind]\nspeed = 8.0\n", "[wind] and [control]"),
    ],
)
def test_wind_and_control_are_left_out(tmp_path, capfd, more, tables):
    write_aerodyn(tmp_path)
    (tmp_path / "own.py").write_text("class Own: pass\n")
    path = tmp_path / "case.toml"
    path.write_text(
        'control.kind = "python:own.py:Own"\naero.file = "rotor.dat"\n'
        f'[turbine]\nmodel = "rigid"\n[pitch]\ndrive = "actuator"\n{more}'
    )
    assert main(["modes", str(path), "--count", "2"]) == 0
    words = f"warning: modes are those without wind and controller: {tables} left out"
    assert words in capfd.readouterr().err

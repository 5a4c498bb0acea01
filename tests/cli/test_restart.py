"""``restart`` goes on as if the run had never ended."""

import json
import re
import shutil

import numpy as np
import pytest
from histories import read_columns, read_lines
from outputs import read_fields
from restarted_runs import SOFT, assert_same, restart, run, summary

from turbine_fenicsx.linear_solvers import quasi_newton
from turbine_fenicsx.linear_solvers.quasi_newton import QuasiNewton
from turbine_fenicsx.records import vtkhdf
from turbine_fenicsx.records.vtkhdf_file import VtkHdfFile
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run.run import restart_case, run_case

TWO_RANKS = ("mesh.elements=[1,1,6]", "output.fields_every=0.04")
KINDS = ("energy_[", "work_[", "linear_momentum", "angular_momentum", "angle_", "tip_", "stress")
ROUND_OFF = ("energy_error_[J]", "constraint_error_[-]")
pytestmark = pytest.mark.usefixtures("no_pictures")


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("hybrid_soft", SOFT),
        ("hybrid_stiff", ("mesh.elements=[1,1,2]", "mesh.degree=2", "output.fields_every=0.1")),
        ("hybrid_soft", (*SOFT, "solver.linear_solver=lu")),
        ("hybrid_soft", (*SOFT, "time.start=turning", "turbine.rotor_speed=1", "time.ramp=0.2")),
        ("rigid", ("output.fields_every=0",)),
        ("rigid", ("output.fields_every=0.05",)),  # which is no multiple of the step
    ],
)
def test_a_run_that_is_extended_is_as_long_from_the_start(demo, tmp_path, name, changes, capfd):
    run(demo, name, tmp_path / "whole", "time.end=0.24", *changes)
    run(demo, name, tmp_path / "part", "time.end=0.06", *changes)
    restart(tmp_path / "part", "time.end=0.14")
    restart(tmp_path / "part", "time.end=0.24")
    assert_same(tmp_path / "part", tmp_path / "whole")
    assert len(read_lines(tmp_path / "part")) == 14
    log = [
        s.split(" ", 3)[3]
        for s in (tmp_path / "part" / "run.log").read_text().splitlines()[:-1]
        if re.match(r"\d{4}-", s)
    ]
    assert [s.split()[1] for s in log if s.startswith("step ")] == [str(k) for k in range(1, 13)]
    assert sum(s.startswith("checkpoint of step ") for s in log) >= 4
    assert [s.split()[0] for s in log if re.match("(run|restart) ", s)] == ["run"] + ["restart"] * 2
    output = capfd.readouterr()
    said = re.sub(r"(?m)^.*waiting for another process to compile .*\n", "", output.err)
    assert output.out + said == ""  # --quiet


def test_a_run_may_go_on_from_its_very_beginning(demo, tmp_path):
    """As after the loss of a run that has no later checkpoint."""
    run(demo, "rigid", tmp_path / "whole", "time.end=0.1", "output.fields_every=0.02")
    run(demo, "rigid", tmp_path / "part", "time.end=0", "output.fields_every=0.02")
    restart(tmp_path / "part", "time.end=0.1")
    assert_same(tmp_path / "part", tmp_path / "whole")


def test_a_run_may_end_anywhere_and_go_on(demo, tmp_path, comm, monkeypatch):
    """After each single step, with a factor that is refreshed every few steps."""
    monkeypatch.setattr(quasi_newton, "BASELINE_STEPS", 0)
    monkeypatch.setattr(quasi_newton, "RENEWAL", 12)
    refreshed = []
    real = QuasiNewton.start_iteration

    def start_iteration(self):
        refreshed.append(self._excess >= quasi_newton.RENEWAL)
        real(self)

    monkeypatch.setattr(QuasiNewton, "start_iteration", start_iteration)
    run(demo, "hybrid_soft", tmp_path / "whole", "time.end=0.2", *SOFT)
    assert 0 < sum(refreshed) < len(refreshed)
    case = Case.load(demo("hybrid_soft.toml"), ["time.end=0.2", *SOFT])
    stop = lambda: True  # noqa: E731
    result = run_case(case, tmp_path / "part", comm, "none", stop=stop)
    n = 1
    while result["interrupted"] and result["end_time_[s]"] < 0.2:
        _, result = restart_case(tmp_path / "part", comm, progress="none", stop=stop)
        n += 1
    assert n == 10
    assert_same(tmp_path / "part", tmp_path / "whole")


@pytest.mark.parametrize("every", ["0", "0.05"])
def test_a_run_with_an_error_tolerance_goes_on(demo, tmp_path, comm, every):
    changes = ["time.end=0.4", "time.step=0.1", f"output.fields_every={every}"]
    changes += ["time.angle_tolerance=1e-9", "turbine.model=rigid"]
    run(demo, "rigid", tmp_path / "whole", *changes)
    times = read_columns(tmp_path / "whole")["time_[s]"]
    assert len(np.unique(np.diff(times).round(9))) > 1
    case = Case.load(demo("rigid.toml"), changes)
    counter = iter(range(10_000))
    stop = lambda: next(counter) % 7 == 6  # noqa: E731
    result = run_case(case, tmp_path / "part", comm, "none", stop=stop)
    n = 0
    while result["interrupted"]:
        _, result = restart_case(tmp_path / "part", comm, progress="none", stop=stop)
        n += 1
    assert n >= 2
    assert_same(tmp_path / "part", tmp_path / "whole")


def test_an_end_between_two_steps_can_be_extended(demo, tmp_path):
    run(demo, "rigid", tmp_path, "time.end=0.05", "output.fields_every=0.02")
    assert list(read_fields(tmp_path / "fields.xdmf")) == [0.0, 0.02, 0.04, 0.05]
    restart(tmp_path, "time.end=0.1")
    found = read_columns(tmp_path)
    assert found["time_[s]"] == pytest.approx([0.0, 0.02, 0.04, 0.05, 0.07, 0.09, 0.1], rel=1e-14)
    assert np.max(np.abs(found["energy_error_[J]"])) <= 1e-6
    times = list(read_fields(tmp_path / "fields.xdmf"))
    assert times == sorted(set(times))
    assert times[-1] == pytest.approx(0.1)


def test_step_tolerance_and_output_may_change(demo, tmp_path):
    run(demo, "hybrid_soft", tmp_path, "time.end=0.06", *SOFT)
    changes = ["time.end=0.1", "time.step=0.01", "solver.linear_solver=lu", "title=other"]
    restart(tmp_path, *changes)
    found = read_columns(tmp_path)
    expected = [0.0, 0.02, 0.04, 0.06, 0.07, 0.08, 0.09, 0.1]
    assert found["time_[s]"] == pytest.approx(expected, rel=1e-14)
    assert np.max(np.abs(found["energy_error_[J]"])) <= 1e-3
    case = json.loads((tmp_path / "case.json").read_text())
    assert case["time"]["step"] == 0.01 and case["title"] == "other"


def test_fields_of_either_format_are_the_same_and_go_on(demo, tmp_path, monkeypatch):
    pytest.importorskip("h5py")
    changes = [*SOFT, "output.fields_every=0.03"]
    run(demo, "hybrid_soft", tmp_path / "xdmf", "time.end=0.14", *changes)
    out = tmp_path / "vtkhdf"
    with monkeypatch.context() as patch:  # there is room for all times, so nothing is copied
        patch.setattr(vtkhdf, "copy_steps", None)
        run(demo, "hybrid_soft", out, "time.end=0.06", *changes, "output.format=vtkhdf")
    restart(out, "time.end=0.14")
    assert not list(out.glob("fields.[!v]*")) and not list(out.glob("*.part"))
    expected = read_fields(tmp_path / "xdmf" / "fields.xdmf")
    with VtkHdfFile(out / "fields.vtkhdf") as file:
        assert file.times.tolist() == list(expected)
        for k, values in enumerate(expected.values()):
            step = file.read(k)
            found = {"points": step.points, **step.point_data, **step.cell_data}
            assert set(found) >= {"displacement", "velocity", "von_mises_stress", "fibre", "part"}
            for name in set(found) - {"points"}:
                assert np.array_equal(found[name], values[name]), name


@pytest.mark.parametrize(("first", "then"), [("0.04", "0"), ("0", "0.04")])
def test_fields_may_begin_or_end_when_a_run_goes_on(demo, tmp_path, first, then):
    """And every row of the history still has as many fields as its head."""
    changes = ["mesh.elements=[1,1,2]", f"output.fields_every={first}"]
    run(demo, "hybrid_soft", tmp_path, "time.end=0.06", *changes)
    restart(tmp_path, "time.end=0.12", f"output.fields_every={then}")
    assert len({line.count(",") for line in read_lines(tmp_path)}) == 1
    restart(tmp_path, "time.end=0.14")  # which reads the history
    assert len(read_lines(tmp_path)) == 9
    assert (tmp_path / "fields.xdmf").exists()


@pytest.mark.parametrize("every", ["0", "0.04"])
def test_a_run_keeps_its_columns(demo, tmp_path, every):
    """A column of stress neither comes nor goes where fields are off afterwards."""
    changes = ["mesh.elements=[1,1,2]", f"output.fields_every={every}"]
    run(demo, "hybrid_soft", tmp_path, "time.end=0.04", *changes)
    names = list(read_columns(tmp_path))
    assert ("max_stress_[Pa]" in names) == (every != "0")
    restart(tmp_path, "time.end=0.08", "output.fields_every=0")
    assert list(read_columns(tmp_path)) == names
    assert "keeps its columns, without" not in (tmp_path / "run.log").read_text()


def test_a_finished_run_stays_as_it_is(demo, tmp_path):
    run(demo, "hybrid_soft", tmp_path, "time.end=0.06", *SOFT)
    history, found, result = (
        read_lines(tmp_path),
        read_fields(tmp_path / "fields.xdmf"),
        summary(tmp_path),
    )
    out = (tmp_path / "history.out").read_text()
    restart(tmp_path)
    assert read_lines(tmp_path) == history
    assert (tmp_path / "history.out").read_text() == out
    assert list(read_fields(tmp_path / "fields.xdmf")) == list(found)
    assert summary(tmp_path) == result


@pytest.mark.parametrize("damage", ["empty", "half", "zeros"])
def test_an_incomplete_newest_checkpoint_falls_back_to_the_one_before(demo, tmp_path, damage):
    changes = ("output.checkpoint_every=0.04", "output.fields_every=0.02")
    run(demo, "rigid", tmp_path / "whole", "time.end=0.2", *changes)
    run(demo, "rigid", tmp_path / "part", "time.end=0.1", *changes)
    folder = tmp_path / "part" / "checkpoints"
    before, newest = sorted(folder.iterdir())
    assert before.name == "checkpoint_00000004.npz" and newest.name == "checkpoint_00000005.npz"
    data = newest.read_bytes()
    n = len(data)
    newest.write_bytes({"empty": b"", "half": data[: n // 2], "zeros": bytes(n)}[damage])
    restart(tmp_path / "part", "time.end=0.2")
    assert_same(tmp_path / "part", tmp_path / "whole")
    assert "resumed at t = 0.08 s" in (tmp_path / "part" / "run.log").read_text()


def test_the_last_two_checkpoints_are_kept(demo, tmp_path):
    run(demo, "rigid", tmp_path, "time.end=0.2", "output.checkpoint_every=0.06")
    names = sorted(p.name for p in (tmp_path / "checkpoints").iterdir())
    assert names == ["checkpoint_00000009.npz", "checkpoint_00000010.npz"]
    run(
        demo, "rigid", tmp_path, "time.end=0.04", flags=["--overwrite"]
    )  # a new run, of fewer steps
    names = sorted(p.name for p in (tmp_path / "checkpoints").iterdir())
    assert names == ["checkpoint_00000000.npz", "checkpoint_00000002.npz"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("ranks")


@pytest.fixture(scope="module")
def runs(folder, demo, command_line):
    """The first half and the whole of a run, on one and on two ranks."""
    for ranks in (1, 2):
        for name, end in (("part", "0.1"), ("whole", "0.2")):
            result = command_line(
                *("run", demo("hybrid_soft.toml"), "-o", folder / f"{name}{ranks}", "--quiet"),
                *("--set", f"time.end={end}", *TWO_RANKS),
                ranks=ranks if ranks > 1 else None,
            )
            assert result.returncode == 0, result.stderr
            # mpirun itself may have something to say about the machine
            assert ranks > 1 or result.stdout + result.stderr == ""
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(("first", "then"), [(1, 1), (2, 2), (1, 2), (2, 1)])
def test_a_run_goes_on_with_any_number_of_ranks(runs, command_line, first, then):
    out = runs / f"{first}then{then}"
    shutil.copytree(runs / f"part{first}", out)
    result = command_line(
        *("restart", out, "--quiet", "--set", "time.end=0.2"),
        ranks=then if then > 1 else None,
    )
    assert result.returncode == 0, result.stderr
    whole = runs / f"whole{first}"
    assert list(read_fields(out / "fields.xdmf")) == list(read_fields(whole / "fields.xdmf"))
    if first == then:
        assert_same(out, whole)
        return
    found, expected = read_columns(out), read_columns(whole)
    assert found.keys() == expected.keys()
    assert np.array_equal(found["time_[s]"], expected["time_[s]"])
    compared = 0
    for kind in KINDS:
        names = [c for c in expected if kind in c and c not in ROUND_OFF]
        scale = max(np.max(np.abs(expected[c])) for c in names)
        for c in names:
            # measured below 1e-11
            assert np.max(np.abs(found[c] - expected[c])) <= 1e-9 * scale, c
            compared += 1
    assert compared > 15
    assert np.max(np.abs(found["energy_error_[J]"])) <= 1e-4
    assert json.loads((out / "summary.json").read_text())["ranks"] == then

"""``restart`` goes on as if the run had never ended, and refuses what does not belong together."""

import csv
import json
import math
import re
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest

from turbine_fenicsx.cli.main import main
from turbine_fenicsx.linear_solvers import QuasiNewton, quasi_newton
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.run import restart_case, run_case

SOFT = ("mesh.elements=[1,1,4]", "output.fields_every=0.04")
"""The hybrid turbine with soft blades, small; it takes some six iterations a step."""
TWO_RANKS = ("mesh.elements=[1,1,6]", "output.fields_every=0.04")
RESULTS = (
    "steps",
    "halved_steps",
    "end_time_[s]",
    "worst_energy_error_[J]",
    "largest_energy_[J]",
    "worst_constraint_error_[-]",
    "angular_momentum_[Nms]",
    "angles_[rad]",
    "mean_newton_iterations",
    "mean_krylov_iterations",
)
KINDS = ("energy_[", "work_[", "linear_momentum", "angular_momentum", "angle_", "tip_", "stress")
ROUND_OFF = ("energy_error_[J]", "constraint_error_[-]")


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    """They take longer than the runs."""
    monkeypatch.setattr("turbine_fenicsx.cli.commands._running._picture", lambda out: [])


def rows(folder):
    """Lines of ``history.csv`` without the wall time."""
    text = (folder / "history.csv").read_text()
    assert text.endswith("\n")
    return [line.rsplit(",", 1)[0] for line in text.splitlines()]


def columns(folder):
    """Columns of ``history.csv`` by name."""
    with (folder / "history.csv").open(newline="") as file:
        header, *values = csv.reader(file)
    return dict(zip(header, np.array(values, dtype=float).T, strict=True))


def fields(folder):
    """Everything in ``fields.xdmf``: time to arrays by name."""
    found = {}
    for grid in ElementTree.parse(folder / "fields.xdmf").getroot().iter("Grid"):
        if grid.get("Name") != "mesh":
            continue
        arrays = {}
        for part in grid:
            item = part.find("DataItem")
            if item is None:
                continue
            shape = tuple(int(n) for n in item.get("Dimensions").split())
            kind = {"Float": "f", "Int": "i"}[item.get("NumberType")] + item.get("Precision")
            name = "".join(item.itertext()).strip()
            numbers = np.fromfile(
                folder / name, kind, math.prod(shape), offset=int(item.get("Seek"))
            )
            arrays[part.get("Name") or part.tag] = numbers.reshape(shape)
        found[float(grid.find("Time").get("Value"))] = arrays
    return found


def summary(folder):
    """What ``summary.json`` says about the result."""
    tables = json.loads((folder / "summary.json").read_text())
    return {name: tables[name] for name in RESULTS}


def assert_same(folder, whole):
    """All results are the same bit for bit, but for wall times."""
    assert rows(folder) == rows(whole)
    assert (folder / "history.out").read_text() == (whole / "history.out").read_text()
    assert summary(folder) == summary(whole)
    assert (folder / "fields.xdmf").exists() == (whole / "fields.xdmf").exists()
    if (whole / "fields.xdmf").exists():
        mine, theirs = fields(folder), fields(whole)
        assert list(mine) == list(theirs)
        for time, arrays in theirs.items():
            assert mine[time].keys() == arrays.keys()
            assert "Geometry" in arrays and "velocity" in arrays
            for name, values in arrays.items():
                assert np.array_equal(mine[time][name], values), (time, name)


def run(demo, name, out, *changes, flags=()):
    """Run a demo; it must succeed and print nothing."""
    command = ["run", str(demo(f"{name}.toml")), "-o", str(out), "--quiet", *flags]
    assert main([*command, "--set", *changes]) == 0


def restart(out, *changes, code=0):
    """Go on with a run."""
    settings = ["--set", *changes] if changes else []
    assert main(["restart", str(out), "--quiet", *settings]) == code


def content(folder):
    """All files of a folder but the log, by name."""
    paths = (p for p in sorted(folder.rglob("*")) if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in paths if p.name != "run.log"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("hybrid_soft", SOFT),
        ("hybrid_stiff", ("mesh.elements=[1,1,2]", "mesh.degree=2", "output.fields_every=0.1")),
        ("hybrid_soft", (*SOFT, "solver.linear_solver=lu")),
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
    assert len(rows(tmp_path / "part")) == 14
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
    monkeypatch.setattr(quasi_newton, "ORDINARY", 4)
    monkeypatch.setattr(quasi_newton, "RENEWAL", 2)
    refreshed = []
    real = QuasiNewton.begin

    def begin(self):
        refreshed.append(self._excess >= quasi_newton.RENEWAL)
        real(self)

    monkeypatch.setattr(QuasiNewton, "begin", begin)
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
    times = columns(tmp_path / "whole")["time_[s]"]
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
    assert list(fields(tmp_path)) == [0.0, 0.02, 0.04, 0.05]
    restart(tmp_path, "time.end=0.1")
    found = columns(tmp_path)
    assert found["time_[s]"] == pytest.approx([0.0, 0.02, 0.04, 0.05, 0.07, 0.09, 0.1], rel=1e-14)
    assert np.max(np.abs(found["energy_error_[J]"])) <= 1e-6
    times = list(fields(tmp_path))
    assert times == sorted(set(times))
    assert times[-1] == pytest.approx(0.1)


def test_step_tolerance_and_output_may_change(demo, tmp_path):
    run(demo, "hybrid_soft", tmp_path, "time.end=0.06", *SOFT)
    changes = ["time.end=0.1", "time.step=0.01", "solver.linear_solver=lu", "title=other"]
    restart(tmp_path, *changes)
    found = columns(tmp_path)
    expected = [0.0, 0.02, 0.04, 0.06, 0.07, 0.08, 0.09, 0.1]
    assert found["time_[s]"] == pytest.approx(expected, rel=1e-14)
    assert np.max(np.abs(found["energy_error_[J]"])) <= 1e-3
    case = json.loads((tmp_path / "case.json").read_text())
    assert case["time"]["step"] == 0.01 and case["title"] == "other"


@pytest.mark.parametrize(("first", "then"), [("0.04", "0"), ("0", "0.04")])
def test_fields_may_begin_or_end_when_a_run_goes_on(demo, tmp_path, first, then):
    """And every row of the history still has as many fields as its head."""
    changes = ["mesh.elements=[1,1,2]", f"output.fields_every={first}"]
    run(demo, "hybrid_soft", tmp_path, "time.end=0.06", *changes)
    restart(tmp_path, "time.end=0.12", f"output.fields_every={then}")
    assert len({line.count(",") for line in rows(tmp_path)}) == 1
    restart(tmp_path, "time.end=0.14")  # which reads the history
    assert len(rows(tmp_path)) == 9
    assert (tmp_path / "fields.xdmf").exists()


def test_a_finished_run_stays_as_it_is(demo, tmp_path):
    run(demo, "hybrid_soft", tmp_path, "time.end=0.06", *SOFT)
    history, found, result = rows(tmp_path), fields(tmp_path), summary(tmp_path)
    out = (tmp_path / "history.out").read_text()
    restart(tmp_path)
    assert rows(tmp_path) == history
    assert (tmp_path / "history.out").read_text() == out
    assert list(fields(tmp_path)) == list(found)
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


def refused(tmp_path, capfd, *changes, words):
    """The restart is refused in one sentence, and no file has changed."""
    before = content(tmp_path)
    capfd.readouterr()
    restart(tmp_path, *changes, code=2)
    (sentence,) = capfd.readouterr().err.splitlines()
    assert sentence.startswith("error: ")
    assert re.search(words, sentence), sentence
    assert content(tmp_path) == before


def test_another_version_is_refused(demo, tmp_path, capfd, monkeypatch):
    run(demo, "rigid", tmp_path, "time.end=0.04")
    monkeypatch.setattr("turbine_fenicsx.simulation.checkpoint.__version__", "9.9.9")
    refused(tmp_path, capfd, words=r"version of turbine_fenicsx has changed, it was .* is 9\.9\.9")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("loads.gravity=1.0", "loads.gravity cannot change"),
        ("turbine.hub.mass=1e5", "turbine.hub cannot change"),
        ("mesh.elements=[1,1,2]", "mesh.elements cannot change"),
        ("time.stop=3", "time.stop"),
        ("time.end=-1", "time.end"),
    ],
)
def test_what_may_not_change_is_refused(demo, tmp_path, capfd, change, words):
    run(demo, "rigid", tmp_path, "time.end=0.04")
    refused(tmp_path, capfd, change, words=words)


def test_a_case_that_was_edited_is_refused(demo, tmp_path, capfd):
    run(demo, "rigid", tmp_path, "time.end=0.04")
    path = tmp_path / "case.json"
    case = json.loads(path.read_text())
    case["loads"]["gravity"] = 1.0
    path.write_text(json.dumps(case))
    refused(tmp_path, capfd, words="the case has changed")


def test_a_mesh_file_that_has_changed_is_refused(demo, tmp_path, capfd):
    mesh, out = tmp_path / "blade.msh", tmp_path / "out"
    case = str(demo("hybrid_soft.toml"))

    def write_mesh(elements):
        command = ["mesh", case, "-o", str(mesh), "--overwrite"]
        assert main([*command, "--set", f"mesh.elements={elements}"]) == 0

    write_mesh([1, 1, 2])
    run(demo, "hybrid_soft", out, "time.end=0.04", f"mesh.file={mesh}")
    write_mesh([1, 1, 3])
    refused(out, capfd, words="the mesh has changed")
    mesh.unlink()
    refused(out, capfd, words="blade.msh")


def test_a_mesh_file_is_found_from_anywhere(demo, tmp_path, monkeypatch):
    """The case names it relative to itself, and is named relative to where one was."""
    (tmp_path / "cases").mkdir()
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    text = demo("hybrid_soft.toml").read_text().replace("[mesh]", '[mesh]\nfile = "blade.msh"')
    (tmp_path / "cases" / "case.toml").write_text(text)
    case = str(demo("hybrid_soft.toml"))
    assert main(["mesh", case, "-o", "cases/blade.msh", "--set", "mesh.elements=[1,1,2]"]) == 0
    assert main(["run", "cases/case.toml", "-o", "out", "--quiet", "--set", "time.end=0.04"]) == 0
    monkeypatch.chdir(tmp_path / "elsewhere")
    restart(tmp_path / "out", "time.end=0.06")
    assert len(rows(tmp_path / "out")) == 5


@pytest.mark.parametrize("what", ["nothing", "empty", "no checkpoint", "only broken ones"])
def test_a_folder_without_a_run_is_refused(demo, tmp_path, capfd, what):
    out = tmp_path / "out"
    if what == "empty":
        out.mkdir()
    if what in ("no checkpoint", "only broken ones"):
        run(demo, "rigid", out, "time.end=0.04")
        for path in (out / "checkpoints").iterdir():
            path.write_bytes(b"") if what == "only broken ones" else path.unlink()
    words = {
        "no checkpoint": "there is no checkpoint in",
        "only broken ones": "no checkpoint in .* can be used",
    }
    refused(out, capfd, words=words.get(what, "there is no run in '.*/out' to go on with"))
    assert out.exists() == (what != "nothing")


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
    assert list(fields(out)) == list(fields(whole))
    if first == then:
        assert_same(out, whole)
        return
    found, expected = columns(out), columns(whole)
    assert found.keys() == expected.keys()
    assert np.array_equal(found["time_[s]"], expected["time_[s]"])
    compared = 0
    for kind in KINDS:
        names = [c for c in expected if kind in c and c not in ROUND_OFF]
        scale = max(np.max(np.abs(expected[c])) for c in names)
        for c in names:
            # the bound; measured below 1e-11
            assert np.max(np.abs(found[c] - expected[c])) <= 1e-9 * scale, c
            compared += 1
    assert compared > 15
    assert np.max(np.abs(found["energy_error_[J]"])) <= 1e-4
    assert json.loads((out / "summary.json").read_text())["ranks"] == then

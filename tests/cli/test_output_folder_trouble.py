"""A folder that cannot be written to, a full disk, two runs in one folder: a sentence each."""

import errno
import fcntl
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import pytest
from patience import patience

from turbine_fenicsx.cli.main import main

ROOT = Path(__file__).parents[2]
SHORT = ("--quiet", "--set", "time.end=0.1", "output.fields_every=0.02")
FULL = os.strerror(errno.ENOSPC)


def refused(code, err, *words):
    """Exit code 2 and one sentence on stderr."""
    ours = [line for line in err.splitlines() if not line.startswith("mca_")]  # MPI-IO has its say
    assert code == 2, err
    assert len(ours) == 1, err
    assert ours[0].startswith("error: ")
    for word in words:
        assert word in ours[0]


def content(folder):
    """All files of a folder, by name."""
    paths = (p for p in sorted(folder.rglob("*")) if p.is_file() and not p.is_symlink())
    return {str(p.relative_to(folder)): p.read_bytes() for p in paths}


@pytest.mark.parametrize(
    "name",
    [
        "case.json",
        "case.json.tmp",
        "history.tmp",
        "history.csv.tmp",
        "history.out.tmp",
        "fields.bin",
        "fields.xdmf.new",
        "summary.json",
        "history.png",
        "checkpoints/checkpoint_00000000.tmp",
        "checkpoints/checkpoint_00000005.tmp",
    ],
)
def test_a_full_disk_is_one_sentence(demo, tmp_path, capfd, name):
    """Whichever file it is that finds no room; some are not written under that name."""
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.symlink_to("/dev/full")
    code = main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), *SHORT])
    output = capfd.readouterr()
    assert output.out == ""
    if code == 0:  # another name was used, or the file was replaced
        assert output.err == ""
        assert not path.is_symlink() or name.endswith((".tmp", ".new"))
    else:
        refused(code, output.err, "cannot write", str(tmp_path))
        assert FULL in output.err or "disk full?" in output.err


def test_a_full_disk_does_not_keep_a_run_from_going_on_without_a_log(demo, tmp_path, capfd):
    (tmp_path / "run.log").symlink_to("/dev/full")
    assert main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), *SHORT]) == 0
    assert capfd.readouterr().err == ""
    assert len((tmp_path / "history.csv").read_text().splitlines()) == 7


@pytest.fixture
def limit():
    """Sets the largest size of files, as a stand-in for a disk that is full later."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size or soft, hard))
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("size", [500, 4000, 30_000])
def test_a_disk_that_is_full_later_leaves_a_run_that_can_go_on(demo, tmp_path, capfd, limit, size):
    """At the first file, at the first checkpoint, in the middle of the history."""
    settings = ["--set", "time.end=2", "output.fields_every=0", "output.checkpoint_every=0.1"]
    settings += ["--quiet"]
    case = ["run", str(demo("rigid.toml")), *settings]
    out, whole = tmp_path / "out", tmp_path / "whole"
    limit(size)
    code = main([*case, "-o", str(out)])
    limit(None)
    refused(code, capfd.readouterr().err, "cannot write", str(out), os.strerror(errno.EFBIG))
    if size == 30_000:
        assert 20 < len((out / "history.csv").read_text().splitlines()) < 90
        assert main(["restart", str(out), "--quiet"]) == 0
    else:
        assert main([*case, "-o", str(out)]) == 0
    assert main([*case, "-o", str(whole)]) == 0
    mine, theirs = (
        [line.rsplit(",", 1)[0] for line in (folder / "history.csv").open()]
        for folder in (out, whole)
    )
    assert mine == theirs
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("checkpoints", "file"),
        ("checkpoints/checkpoint_00000000.npz", "folder"),
        ("checkpoints/checkpoint_00000000.tmp", "folder"),
        ("case.json", "folder"),
        ("history.csv", "folder"),
        ("history.out", "folder"),
        ("run.log", "folder"),
        ("summary.json", "folder"),
        ("history.png", "folder"),
        (".lock", "folder"),
    ],
)
def test_something_in_the_way_of_a_file_is_one_sentence(demo, tmp_path, capfd, name, kind):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.mkdir() if kind == "folder" else path.write_text("mine")
    code = main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), *SHORT])
    refused(code, capfd.readouterr().err, "cannot write", str(tmp_path))
    assert path.is_dir() if kind == "folder" else path.read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("run.log", None),
        ("checkpoints/checkpoint_00000005.tmp", "/dev/full"),
    ],
)
def test_two_ranks_do_not_wait_for_each_other(demo, tmp_path, command_line, name, target):
    """After a rank has failed to write, whatever it was; the name leads to a full disk or is that
    of a folder."""
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.symlink_to(target) if target else path.mkdir()
    arguments = ("run", demo("rigid.toml"), "-o", tmp_path, *SHORT)
    try:
        result = command_line(*arguments, ranks=2, timeout=45)
    except subprocess.TimeoutExpired:
        pytest.fail("the ranks wait for each other")
    assert "Traceback" not in result.stderr
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    if result.returncode == 0:  # no room for the log is no reason to stop; other links were removed
        assert not errors
        assert name == "run.log" or not path.is_symlink()
    else:
        assert result.returncode == 2, result.stderr
        assert len(errors) == 1 and "cannot write" in errors[0]


def test_old_checkpoints_that_cannot_be_removed_are_one_sentence_on_two_ranks(
    demo, tmp_path, command_line
):
    assert main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), *SHORT]) == 0
    for index in (0, 1):
        path = tmp_path / "checkpoints" / f"checkpoint_0000000{index}.npz"
        path.unlink(missing_ok=True)
        path.mkdir()
    try:
        result = command_line("restart", tmp_path, "--quiet", ranks=2, timeout=45)
    except subprocess.TimeoutExpired:
        pytest.fail("the ranks wait for each other")
    assert result.returncode == 2, result.stderr
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1 and "cannot write" in errors[0]


@pytest.mark.parametrize(("command", "ranks"), [("run", None), ("restart", None), ("restart", 2)])
def test_a_folder_in_use_is_refused_and_nothing_in_it_changes(
    demo, tmp_path, command_line, command, ranks, capfd
):
    assert main(["run", str(demo("rigid.toml")), "-o", str(tmp_path), *SHORT]) == 0
    capfd.readouterr()
    before = content(tmp_path)
    arguments = [tmp_path] if command == "restart" else [demo("rigid.toml"), "-o", tmp_path]
    with (tmp_path / ".lock").open("rb+") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if ranks is None:
            code, err = main([command, *map(str, arguments), "--quiet"]), capfd.readouterr().err
        else:
            result = command_line(command, *arguments, "--quiet", ranks=ranks, timeout=45)
            code = result.returncode
            err = "".join(s for s in result.stderr.splitlines(True) if s.startswith("error: "))
            assert "Traceback" not in result.stderr
    refused(code, err, "in use by another run", repr(str(tmp_path)))
    assert content(tmp_path) == before


def test_a_second_run_leaves_the_first_alone(demo, tmp_path, capfd):
    case = [str(demo("rigid.toml")), "-o", str(tmp_path), "--quiet", "--set", "time.end=1000"]
    command = [sys.executable, "-m", "turbine_fenicsx", "run", *case]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as first:
        try:
            start = time.monotonic()
            history = tmp_path / "history.csv"
            while not history.exists() or len(history.read_text().splitlines()) < 5:
                assert first.poll() is None and time.monotonic() - start < patience(60.0)
                time.sleep(0.02)
            code = main(["run", *case])
            refused(code, capfd.readouterr().err, "in use by another run")
            code = main(["restart", str(tmp_path), "--quiet"])
            refused(code, capfd.readouterr().err, "in use by another run")
            first.send_signal(signal.SIGTERM)
            _, err = first.communicate(timeout=patience(30))
        finally:
            first.kill()
    assert first.returncode == 130
    assert err.startswith("error: interrupted at t = ")
    times = [float(line.split(",")[0]) for line in history.read_text().splitlines()[1:]]
    assert times == pytest.approx([0.02 * k for k in range(len(times))])


@pytest.fixture(scope="module")
def nobody(demo):
    """Runs the command line as a user who may write to one folder only, which has a run in it."""
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        home.chmod(0o777)
        user = {"env": os.environ | {"HOME": name, "XDG_CACHE_HOME": name}, "cwd": ROOT}
        if os.geteuid() == 0:
            user |= {"user": 65534, "group": 65534, "extra_groups": []}

        def run(*arguments):
            command = [sys.executable, "-m", "turbine_fenicsx", *map(str, arguments)]
            return subprocess.run(command, capture_output=True, text=True, timeout=120, **user)

        try:
            version = run("--help")
        except PermissionError:
            pytest.skip(f"{sys.executable} is for its owner only")
        if version.returncode and "Permission denied" in version.stderr:
            pytest.skip("the checkout is readable to its owner only")
        first = run("run", demo("rigid.toml"), "-o", home / "out", *SHORT)
        assert first.returncode == 0, first.stderr
        yield run, home


@pytest.mark.parametrize("command", ["run", "restart"])
@pytest.mark.parametrize("folder", ["out", "out/checkpoints"])
def test_no_permission_is_one_sentence(demo, nobody, command, folder):
    """Also where root runs the tests, who may write everywhere: they drop its rights."""
    run, home = nobody
    out = home / "out"
    case = ["run", demo("rigid.toml"), "-o", out, "--overwrite"]
    assert out.stat().st_uid == (os.geteuid() or 65534)
    before = content(out)
    (home / folder).chmod(0o555)
    try:
        arguments = case if command == "run" else ["restart", out]
        result = run(*arguments, "--quiet", "--set", "time.end=0.2")
    finally:
        (home / folder).chmod(0o755)
    refused(result.returncode, result.stderr, "cannot write", "Permission denied", str(out))
    assert content(out).keys() == before.keys()
    if folder == "out":
        assert {n: d for n, d in content(out).items() if n != "run.log"} == {
            n: d for n, d in before.items() if n != "run.log"
        }


@pytest.mark.parametrize(
    "name",
    [
        *("run.log", ".lock", "case.json", "history.csv", "history.out", "fields.bin"),
        *("fields.xdmf", "summary.json", "case.json.tmp", "history.csv.tmp", "history.out.tmp"),
        *("fields.xdmf.tmp", "summary.json.tmp", "checkpoints/checkpoint_00000000.npz"),
        "checkpoints/checkpoint_00000000.npz.tmp",
    ],
)
@pytest.mark.parametrize("exists", [True, False])
def test_nothing_is_written_through_a_link_that_somebody_has_left(
    demo, tmp_path, capfd, monkeypatch, name, exists
):
    """The file of somebody else that it leads to stays as it is, or is not made."""
    monkeypatch.setattr("turbine_fenicsx.cli.commands._running._draw_history", lambda *_: [])
    other, path = tmp_path / "precious", tmp_path / "out" / name
    path.parent.mkdir(parents=True)
    if exists:
        other.write_text("mine")
    path.symlink_to(other)
    command = ["run", str(demo("rigid.toml")), "-o", str(tmp_path / "out"), *SHORT]
    code = main([*command[:4], "--overwrite", *command[4:]])
    assert other.exists() == exists
    assert not exists or other.read_text() == "mine"
    err = capfd.readouterr().err
    if name in ("run.log", ".lock"):
        refused(code, err, "symbolic link", str(tmp_path / "out"))
    else:
        assert code == 0, err


def test_a_step_at_the_floor_leaves_a_checkpoint_and_one_sentence(demo, tmp_path, capfd):
    """Half a step has an error that is too large, and so has any: the tolerance is absurd."""
    settings = ["time.end=0.4", "time.angle_tolerance=1e-17", "output.fields_every=0"]
    case = ["run", str(demo("rigid.toml")), "-o", str(tmp_path), "--quiet"]
    assert main([*case, "--set", *settings]) == 3
    (sentence,) = capfd.readouterr().err.splitlines()
    assert sentence.startswith("error: the step from t = ")
    assert "Steps are not halved below " in sentence
    assert "look at time.angle_tolerance" in sentence
    assert str(tmp_path) in sentence
    lines = (tmp_path / "history.csv").read_text().splitlines()
    newest = max((tmp_path / "checkpoints").iterdir())
    assert newest.name == f"checkpoint_{len(lines) - 2:08d}.npz"
    restart = ["restart", str(tmp_path), "--quiet", "--set", "time.angle_tolerance=1.0"]
    assert main(restart) == 0
    rows = [line.split(",") for line in (tmp_path / "history.csv").read_text().splitlines()]
    assert float(rows[-1][0]) == pytest.approx(0.4)
    steps = [float(b[0]) - float(a[0]) for a, b in pairwise(rows[1:])]
    assert min(steps) < 0.001 and steps[-1] == pytest.approx(0.02)  # they grew back
    errors = [abs(float(row[rows[0].index("energy_error_[J]")])) for row in rows[1:]]
    assert max(errors) <= 1e-6  # of 5e4 J

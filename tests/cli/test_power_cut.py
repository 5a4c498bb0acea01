"""After a power cut, or whatever damages its files, a run goes on without a gap, or says what is
missing."""

import os
import re
import shutil

import numpy as np
import pytest
from histories import read_lines

from tests.attack.power_cuts import damage
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.records.output_folder import read_field_times
from turbine_fenicsx.records.row_file import RowFile
from turbine_fenicsx.records.xdmf import XdmfSeries
from turbine_fenicsx.turbine.run.run import restart_case

CHANGES = ("output.checkpoint_every=0.04", "output.fields_every=0.02")
SERIES = ("history.csv", "history.out", "fields.bin", "fields.xdmf")
pytestmark = pytest.mark.usefixtures("no_pictures")


def run(demo, out, end):
    """The rigid turbine to some time; checkpoints are of steps 0, 2, 4, ... and the last."""
    command = [
        "run",
        str(demo("rigid.toml")),
        "-o",
        str(out),
        "--quiet",
        "--set",
        f"time.end={end}",
    ]
    assert main([*command, *CHANGES]) == 0


@pytest.fixture(scope="module")
def whole(demo, tmp_path_factory):
    """The run that was never interrupted."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("turbine_fenicsx.cli.commands._running._draw_history", lambda *_: [])
        folder = tmp_path_factory.mktemp("whole") / "out"
        run(demo, folder, 0.2)
    return folder


@pytest.fixture(scope="module")
def half(demo, tmp_path_factory):
    """Its first half, with checkpoints at 0.08 s and 0.1 s, steps 4 and 5."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("turbine_fenicsx.cli.commands._running._draw_history", lambda *_: [])
        folder = tmp_path_factory.mktemp("half") / "out"
        run(demo, folder, 0.1)
    return folder


@pytest.fixture
def out(half, tmp_path):
    """A copy of the half to be damaged."""
    shutil.copytree(half, tmp_path / "out")
    return tmp_path / "out"


def restart(out, capfd):
    """Go on to the end; returns what is said, without the paths."""
    capfd.readouterr()
    assert main(["restart", str(out), "--quiet", "--set", "time.end=0.2"]) == 0
    output = capfd.readouterr()
    assert output.out == ""
    return [line.replace(str(out), "OUT") for line in output.err.splitlines()]


def assert_same(out, whole):
    """As if there had been no damage."""
    assert read_lines(out) == read_lines(whole)
    assert (out / "history.out").read_text() == (whole / "history.out").read_text()
    assert np.array_equal(
        read_field_times(out / "fields.xdmf"), read_field_times(whole / "fields.xdmf")
    )


def cut(path, n_lines, what):
    """Remove the last lines of a file, or put zeros in their place."""
    lines = path.read_bytes().splitlines(keepends=True)
    lost = b"".join(lines[-n_lines:])
    zeros = bytes(len(lost)) if what == "zeros" else lost[: len(lost) // 3]
    path.write_bytes(b"".join(lines[:-n_lines]) + zeros)


def assert_begins_at_the_checkpoint(mine, whole):
    """Rows of a history whose rows up to the sixth were lost: the sixth is that of a start."""
    assert [mine[0], *mine[2:]] == [whole[0], *whole[7:]]
    assert mine[1].split(",")[:5] == whole[6].split(",")[:5]  # time and energies


@pytest.mark.parametrize("name", ["history.csv", "history.out"])
@pytest.mark.parametrize("what", ["cut", "zeros"])
def test_rows_behind_the_newest_checkpoint_take_the_run_to_the_one_before(
    out, whole, capfd, name, what
):
    cut(out / name, 1, what)
    (said,) = restart(out, capfd)
    there, needed = (5, 6) if name == "history.csv" else (4, 5)
    assert said == (
        "warning: resuming from checkpoint_00000004.npz: checkpoint_00000005.npz cannot be "
        f"reached, {name} holds {there} of its {needed} rows up to t = 0.1 s"
    )
    assert_same(out, whole)
    assert restart(out, capfd) == []


def test_fields_behind_the_newest_checkpoint_take_the_run_to_the_one_before(out, whole, capfd):
    heavy = out / "fields.bin"
    os.truncate(heavy, heavy.stat().st_size * 5 // 6)  # six times and a little before them
    (said,) = restart(out, capfd)
    assert "fields.xdmf holds 4 of its 5 times up to t = 0.1 s" in said
    assert "resuming from checkpoint_00000004.npz" in said
    assert_same(out, whole)


def test_the_time_of_the_checkpoint_is_written_again(out, whole, capfd):
    heavy = out / "fields.bin"
    os.truncate(heavy, heavy.stat().st_size - 8)
    assert restart(out, capfd) == []
    assert_same(out, whole)


@pytest.mark.parametrize(
    ("name", "what"),
    [
        (name, what)
        for name in SERIES
        for what in ("missing", "empty", "garbage", "begin")
        if (name, what) != ("fields.bin", "garbage")  # numbers without a checksum
    ],
)
def test_a_series_that_is_lost_does_not_take_the_checkpoints_with_it(out, whole, capfd, name, what):
    """What is kept is kept, and the loss is said."""
    path, random = out / name, np.random.default_rng(4)
    if what == "missing":
        path.unlink()
    elif what == "begin":
        os.truncate(path, path.stat().st_size // 3)
    else:
        path.write_bytes(random.bytes(9000) if what == "garbage" else b"")
    said = restart(out, capfd)
    (sentence,) = said
    series = "fields.xdmf" if name == "fields.bin" else name
    found = re.fullmatch(
        rf"warning: resuming from checkpoint_00000005.npz, but {series} holds (\d) of its (\d) "
        r"(rows|times) up to t = 0.1 s; the others are lost",
        sentence,
    )
    assert found, sentence
    kept, lost = int(found[1]), int(found[2]) - int(found[1])
    assert kept == 0 or what == "begin"
    expected = read_lines(whole)
    if name == "history.csv" and kept == 0:
        assert_begins_at_the_checkpoint(read_lines(out), expected)
    elif name == "history.csv":
        assert read_lines(out) == [*expected[: 1 + kept], *expected[1 + kept + lost :]]
    else:
        assert read_lines(out) == expected
    lines, all_lines = (
        (folder / "history.out").read_text().splitlines() for folder in (out, whole)
    )
    if name == "history.out":
        assert lines == [*all_lines[: 8 + kept], *all_lines[8 + kept + lost :]]
    else:
        assert lines == all_lines
    times = read_field_times(out / "fields.xdmf")
    assert times[-1] == pytest.approx(0.2) and np.all(np.diff(times) > 0.0)
    summary = (out / "summary.json").read_text()
    assert '"steps": 10,' in summary  # counted by the run, not by the rows
    assert restart(out, capfd) == []  # what is lost is not told again


@pytest.mark.parametrize("what", ["missing", "shortened", "a column removed"])
def test_a_finished_run_without_its_history_is_restarted_and_the_loss_is_said(
    whole, tmp_path, capfd, what
):
    """There are no steps left to make, and the page of the run can still be drawn."""
    out = tmp_path / "finished"
    shutil.copytree(whole, out)
    lines = (out / "history.csv").read_text().splitlines(keepends=True)
    (out / "history.csv").unlink()
    if what == "shortened":
        (out / "history.csv").write_text("".join(lines[:4]))
    elif what == "a column removed":
        (out / "history.csv").write_text("".join(line.partition(",")[2] for line in lines))
    (said,) = restart(out, capfd)
    there = 3 if what == "shortened" else 0
    assert f"history.csv holds {there} of its {len(lines) - 1} rows up to t = 0.2 s" in said
    mine = (out / "history.csv").read_text().splitlines()
    if what == "shortened":
        assert mine == [line.rstrip() for line in lines[:4]]
    else:
        assert [row.split(",")[:5] for row in mine] == [
            row.split(",")[:5] for row in (lines[0], lines[-1])
        ]
    assert main(["restart", str(out)]) == 0  # with its table and picture
    assert main(["plot", str(out)]) == 0
    assert main(["report", str(out)]) == 0


@pytest.mark.parametrize("what", ["removed", "swapped", "renamed"])
def test_columns_changed_by_hand_are_noticed_and_the_file_is_kept(out, whole, capfd, what):
    path = out / "history.csv"
    table = [line.split(",") for line in path.read_text().splitlines()]
    if what == "renamed":
        table[0][3] = "energy"
    else:
        for line in table:
            line[2:4] = line[3:1:-1] if what == "swapped" else line[2:3]
    mine = "".join(",".join(line) + "\n" for line in table)
    path.write_text(mine)
    (said,) = restart(out, capfd)
    assert "history.csv holds 0 of its 6 rows up to t = 0.1 s; the others are lost" in said
    assert (out / "history.csv.damaged").read_text() == mine
    assert_begins_at_the_checkpoint(read_lines(out), read_lines(whole))


def test_a_case_of_absurd_depth_is_one_sentence(out, capfd):
    (out / "case.json").write_text('{"time":' + 100_000 * "[" + "1" + 100_000 * "]" + "}")
    assert main(["restart", str(out), "--quiet"]) == 2
    assert capfd.readouterr().err == f"error: {out}/case.json is not valid JSON\n"


def test_series_are_on_the_disk_before_a_checkpoint_is_written(demo, tmp_path, monkeypatch):
    """Each checkpoint comes after all series were brought to the disk; between them nothing is."""
    calls = []

    def spy(owner, name, label):
        real = getattr(owner, name)

        def call(*arguments, **more):
            calls.append(label(*arguments))
            return real(*arguments, **more)

        monkeypatch.setattr(owner, name, call)

    spy(RowFile, "sync", lambda file: file._path.name)
    spy(XdmfSeries, "sync", lambda series: series._path.name)
    spy(XdmfSeries, "write", lambda series, *_: "fields")
    spy(RowFile, "write", lambda *_: "row")
    monkeypatch.setattr(
        "turbine_fenicsx.simulation.checkpoint.write_checkpoint",
        lambda *_: calls.append("checkpoint"),
    )
    run(demo, tmp_path / "out", 0.1)
    text = " ".join(calls)
    synced = r"(history\.csv|history\.out|fields\.xdmf)"
    assert re.fullmatch(rf"((row|fields) )+({synced} {{1}}){{3}}checkpoint( .*)?", text), text
    blocks = text.split("checkpoint")
    assert len(blocks) == 5  # at steps 0, 2, 4, 5
    for block in blocks[:-1]:
        assert sorted(re.findall(synced, block)) == ["fields.xdmf", "history.csv", "history.out"]


def test_lines_and_times_are_really_brought_to_the_disk(demo, tmp_path, monkeypatch):
    """With fsync, of the files and of the folder that holds their names, at every checkpoint."""
    synced, real = [], os.fsync

    def fsync(descriptor):
        synced.append(os.path.basename(os.readlink(f"/proc/self/fd/{descriptor}")))
        real(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    run(demo, tmp_path / "out", 0.1)
    for name in (*SERIES, "out"):
        assert synced.count(name) >= 4, name
    assert len(synced) <= 50  # and not at every step
    monkeypatch.undo()


@pytest.mark.parametrize("how", ["deleted", "renamed", "one file"])
def test_a_folder_that_is_gone_ends_the_run_at_the_next_checkpoint(demo, tmp_path, comm, how):
    """In one sentence; nothing is made anew, and what was renamed can go on."""
    from turbine_fenicsx.foundation.errors import FileError
    from turbine_fenicsx.turbine.case.case import Case
    from turbine_fenicsx.turbine.run.run import run_case

    out, steps = tmp_path / "out", []

    class Somebody:
        def start(self, snapshot, resumed):
            self.observe(snapshot)

        def observe(self, snapshot):
            steps.append(snapshot.index)
            if snapshot.index == 5:
                if how == "deleted":
                    shutil.rmtree(out)
                elif how == "renamed":
                    out.rename(tmp_path / "other")
                else:
                    (out / "history.csv").unlink()

        def finish(self):
            pass

    changes = ["time.end=10", "output.checkpoint_every=0.04", "output.fields_every=0"]
    with pytest.raises(FileError, match=r"cannot write .*out/"):
        run_case(Case.load(demo("rigid.toml"), changes), out, comm, "none", observers=[Somebody()])
    assert steps[-1] == 6
    assert out.exists() == (how == "one file")
    assert not (out / "history.csv").exists()
    if how == "renamed":
        restart_case(tmp_path / "other", comm, ["time.end=0.2"], "none")
        assert len(read_lines(tmp_path / "other")) == 12


def test_any_damage_to_the_series_ends_well(half, whole, tmp_path, capfd):
    """The attack of `tests.attack.power_cuts` at small size."""
    random = np.random.default_rng(12)
    for k in range(12):
        out = tmp_path / str(k)
        shutil.copytree(half, out)
        what = damage(out, random)
        said = restart(out, capfd)
        if not any("lost" in sentence for sentence in said):
            assert read_lines(out) == read_lines(whole), what

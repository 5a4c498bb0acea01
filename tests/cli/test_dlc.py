"""Claims about the command that runs a load set."""

import csv
import subprocess
import sys

import pytest
from controlled_case import write_controlled_case
from patience import patience

from turbine_fenicsx.cli.main import main

SET = """
case = "case.toml"
situations = ["1.1", "1.2", "4.1"]
extremes = {block = "0.2 s"}
launcher = "env"
[situation."1.2"]
winds = ["12 m/s"]
seeds = 2
duration = "1 s"
transient = "0.5 s"
[situation."4.1"]
winds = ["cut_out"]
per_year = [50]
duration = "1 s"
transient = 0
set = {"event.stop.kind" = "shut_down", "event.stop.time" = 0.5, "event.stop.rate" = "4 deg/s"}
"""


TABLES = (
    "runs.csv",
    "set.csv",
    "winds.csv",
    "extrapolated.csv",
    "fatigue.csv",
    "markov.csv",
    "set.nc",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("set")
    write_controlled_case(folder)
    (folder / "set.toml").write_text(SET)
    return folder


def start(folder, *arguments):
    command = [sys.executable, "-P", "-m", "turbine_fenicsx", "dlc", "set.toml", *arguments]
    limit = patience(120)
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=limit)


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def done(folder):
    result = start(folder, "-o", "out", "-j", "2")
    assert result.returncode == 0, result.stderr
    return result


def test_a_set_runs_all_its_situations_and_writes_tables(folder, done):
    assert f"3 of 3 runs finished; results out/: {', '.join(TABLES)}" in done.stdout
    assert done.stderr.count("finished in") == 3
    runs = read(folder / "out" / "runs.csv")
    assert [row["run"] for row in runs] == ["1.2/v12_s1", "1.2/v12_s2", "4.1/v25"]
    assert {row["state"] for row in runs} == {"finished"}
    rows = read(folder / "out" / "set.csv")
    assert {row["situation"] for row in rows} == {"1.1", "1.2", "4.1", "all"}
    by = {(row["situation"], row["column"]): row for row in rows}
    row = by["1.2", "rotor_speed_[rpm]"]
    statistics = read(folder / "out" / row["run_of_largest"] / "statistics.csv")
    (same,) = (x for x in statistics if x["column"] == "rotor_speed_[rpm]")
    assert float(same["largest"]) == float(row["largest"]) and row["runs"] == "2"
    loads = read(folder / "out" / "fatigue.csv")
    assert {row["run"] for row in loads} == {*(row["run"] for row in runs), "lifetime"}
    of_life = [row for row in loads if row["run"] == "lifetime"]
    assert {row["column"] for row in of_life} == {
        row["column"] for row in read(folder / "out" / "markov.csv")
    }
    extreme = by["1.1", "root_moment_1_y_[Nm]"]
    (value,) = (
        row["value"]
        for row in read(folder / "out" / "extrapolated.csv")
        if (row["column"], row["side"]) == (extreme["column"], "largest")
        and row["return_period_[years]"] == "50.0"
    )
    assert (extreme["largest"], extreme["run_of_largest"]) == (value, "extrapolated")
    assert float(extreme["factored_largest"]) == pytest.approx(1.25 * float(value))
    assert len(list((folder / "turbulence").iterdir())) == 2  # shared by all runs with them


def test_called_again_it_runs_what_is_missing_with_the_same_tables(folder, done):
    before = {name: (folder / "out" / name).read_bytes() for name in TABLES}
    listed = start(folder, "-o", "out", "--list").stdout
    assert listed.count("finished ") == 3 and "3 runs of 2 situations; 0 s with" in listed
    (folder / "out" / "1.2" / "v12_s2" / "summary.json").unlink()
    listed = start(folder, "-o", "out", "--list").stdout
    assert "to run        1.5 s  1.2/v12_s2" in listed
    again = start(folder, "-o", "out")
    assert again.stderr.count("was finished before") == 2 and again.returncode == 0
    assert {name: (folder / "out" / name).read_bytes() for name in before} == before


def test_a_launcher_that_is_not_there_is_refused_before_anything_runs(folder, capfd):
    wrong = folder / "wrong.toml"
    wrong.write_text(SET.replace('"env"', '"no-such-program -n 1"'))
    assert main(["dlc", str(wrong), "-o", str(folder / "wrong")]) == 2
    assert "launcher = 'no-such-program -n 1': there is no" in capfd.readouterr().err
    assert not (folder / "wrong").exists()


def test_the_page_of_a_set_is_written_and_times_are_refused(folder, done, capfd):
    out = folder / "out"
    assert main(["report", str(out), "--beside", str(out / "winds.csv")]) == 0
    assert capfd.readouterr().out == f"{out}/report.html\n"
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("<img ") == 3  # return periods, life, spectra; there is one wind speed
    assert main(["report", str(out), "--times", "1"]) == 2
    assert "--times 1: modes and load sets have none" in capfd.readouterr().err
    run = str(out / "4.1" / "v25")
    assert main(["report", run, "--beside", "a.csv"]) == 2
    assert f"--beside: {run!r} is not the folder of a load set" in capfd.readouterr().err


def test_a_case_that_has_changed_and_processes_that_cannot_be_are_refused(folder, done):
    changed = start(folder, "-o", "out", "--set", "aero.stations=9")
    assert changed.returncode == 2
    assert "'out/1.2/v12_s1' and 2 more holds the results of another case" in changed.stderr
    assert start(folder, "-j", "0").stderr == "error: --processes 0: must be at least 1\n"

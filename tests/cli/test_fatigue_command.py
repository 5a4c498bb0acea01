"""The command that counts load cycles."""

import csv
import re
import sys

import numpy as np
import pytest
from outputs import history, write

from turbine_fenicsx.cli.main import main


@pytest.fixture
def out(tmp_path):
    """An output folder."""
    return write(tmp_path / "run" / "history.csv", history(n=601)).parent


def test_table_is_printed_and_written(out, capfd):
    assert main(["fatigue", str(out), "--slope", "4", "10"]) == 0
    head, *lines, path = capfd.readouterr().out.splitlines()
    assert re.split(" {2,}", head) == [
        "column",
        "cycles",
        "largest range",
        "equivalent, m = 4",
        "equivalent, m = 10",
    ]
    assert path == f"{out}/fatigue.csv"
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    assert [line.split()[0] for line in lines] == [row["column"] for row in rows]
    assert len(rows) == 9
    for line, row in zip(lines, rows, strict=True):
        assert [float(x) for x in line.split()[1:]] == pytest.approx(
            [float(x) for x in list(row.values())[1:]], rel=1e-3
        )
    # 2 sin(6 t) MNm over 12 s: 11.46 cycles, most of them whole
    flap = next(row for row in rows if row["column"] == "root_moment_1_y_[Nm]")
    assert float(flap["largest_range"]) == pytest.approx(6e6, rel=1e-3)
    assert float(flap["equivalent_range_slope_10"]) == pytest.approx(6e6, rel=0.02)


def test_columns_frequency_and_start_are_obeyed(out, capfd):
    options = ["--columns", "tip_flap_1_[m]", "--frequency", "2", "--start", "6"]
    assert main(["fatigue", str(out), *options]) == 0
    _, line, _ = capfd.readouterr().out.splitlines()
    name, cycles, largest, equivalent = line.split()
    assert name == "tip_flap_1_[m]"
    assert (float(cycles), float(largest)) == pytest.approx((6.5, 1.6), rel=1e-2)
    assert float(equivalent) == pytest.approx(1.6 * (6.5 / 12.0) ** 0.1, rel=0.02)


def test_ultimate_loads_and_matrices_are_obeyed(out, capfd):
    columns = ["--columns", "root_moment_1_y_[Nm]", "tip_flap_1_[m]"]
    assert main(["fatigue", str(out), *columns, "--slope", "4"]) == 0
    plain = [float(line.split()[3]) for line in capfd.readouterr().out.splitlines()[1:3]]
    options = ["--slope", "4", "--ultimate", "1e30", "10", "--markov"]
    assert main(["fatigue", str(out), *columns, *options]) == 0
    *lines, fatigue, markov = capfd.readouterr().out.splitlines()
    corrected = [float(line.split()[3]) for line in lines[1:3]]
    assert corrected[0] == plain[0] and corrected[1] > plain[1]
    assert (fatigue, markov) == (f"{out}/fatigue.csv", f"{out}/markov.csv")
    with open(markov, newline="") as file:
        rows = list(csv.DictReader(file))
    for line in lines[1:3]:
        counts = [float(row["cycles"]) for row in rows if row["column"] == line.split()[0]]
        assert sum(counts) == float(line.split()[1])


MISTAKES = {
    "no folder": (["{out}/none"], "no output folder"),
    "slope": (["{out}", "--slope", "0.5"], "--slope 0.5: must be between 1 and 100"),
    "slope that is none": (["{out}", "--slope", "nan"], "--slope nan: must be"),
    "frequency": (["{out}", "--frequency", "0"], "--frequency 0: must be greater than 0"),
    "column": (["{out}", "--columns", "root"], "has no column 'root'"),
    "ultimate loads": (["{out}", "--ultimate", "1", "2"], "give one number, or one for each of"),
    "ultimate load": (["{out}", "--ultimate", "-1"], "--ultimate -1: must be greater than 0"),
    "small ultimate load": (["{out}", "--ultimate", "1"], "[Nm]' is 1: expected more than its"),
    "late start": (["{out}", "--start", "12"], "fewer than two numbers from t = 12 s on"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_one_sentence_and_exit_code_2(out, capfd, mistake):
    arguments, words = MISTAKES[mistake]
    assert main(["fatigue", *(a.format(out=out) for a in arguments)]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("error: ") and words in line
    assert not (out / "fatigue.csv").exists()


def test_missing_library_is_one_sentence(out, capfd, monkeypatch):
    monkeypatch.setitem(sys.modules, "rainflow", None)
    assert main(["fatigue", str(out)]) == 2
    assert capfd.readouterr().err == (
        "error: counting cycles needs rainflow: pip install rainflow\n"
    )


def test_run_without_moments_says_what_to_do(tmp_path, capfd):
    columns = {"time_[s]": np.arange(3.0)}
    folder = write(tmp_path / "run" / "history.csv", columns).parent
    assert main(["fatigue", str(folder)]) == 2
    assert "choose other columns" in capfd.readouterr().err


def test_table_that_cannot_be_written_is_one_sentence(out, capfd):
    (out / "fatigue.csv").mkdir()
    assert main(["fatigue", str(out)]) == 2
    printed = capfd.readouterr()
    assert printed.err == f"error: cannot write {out}/fatigue.csv: Is a directory\n"
    assert printed.out == ""


def write_openfast(out, columns):
    """A file such as runs write, with seven digits."""
    names = list(columns)
    rows = zip(*columns.values(), strict=True)
    lines = ["", "by turbine_fenicsx", "", "", "Description: a test", "", "\t".join(names)]
    lines.append("\t".join("(s)" if name == "Time" else "(kN-m)" for name in names))
    lines += ["\t".join(f"{x:.6E}" for x in row) for row in rows]
    (out / "history.out").write_text("\n".join(lines) + "\n")


def test_columns_of_both_files_are_taken(out, capfd):
    h = history(n=601)
    moment = 1e-3 * h["root_moment_1_y_[Nm]"][1:]
    write_openfast(out, {"Time": h["time_[s]"][1:], "RootMyb1": moment, "TwrBsMyt": 2.0 * moment})
    columns = ["root_moment_1_y_[Nm]", "RootMyb1", "RootMyb1_[kN-m]", "TwrBsMyt"]
    assert main(["fatigue", str(out), "--columns", *columns]) == 0
    head, *lines, _ = capfd.readouterr().out.splitlines()
    assert head.split()[-8:] == ["equivalent,", "m", "=", "4", "equivalent,", "m", "=", "10"]
    table = {line.split()[0]: line.split()[1:] for line in lines}
    assert list(table) == columns
    largest = [float(row[1]) for row in table.values()]
    assert largest == pytest.approx([largest[0], *(largest[0] * x for x in (1e-3, 1e-3, 2e-3))])
    assert table["RootMyb1"][2] == "-" and table["TwrBsMyt"][3] == "-"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[:60], "holds no rows"),
        (lambda text: text.replace("E+00", "E+0x"), "has a row that is not of numbers"),
        (lambda text: text.replace("\n1.2", "\n1.3"), "has not the times of history.csv"),
        (lambda text: None, "has no column 'RootMyb1'"),
    ],
)
def test_a_broken_file_is_one_sentence(out, capfd, change, words):
    t = history(n=601)["time_[s]"][1:]
    write_openfast(out, {"Time": t, "RootMyb1": np.sin(t)})
    path = out / "history.out"
    text = change(path.read_text())
    path.unlink() if text is None else path.write_text(text)
    assert main(["fatigue", str(out), "--columns", "RootMyb1"]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("error: ") and words in line

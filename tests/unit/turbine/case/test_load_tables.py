"""Claims about torques and pitch over the time from files."""

import json

import numpy as np
import pytest
from case_mistakes import mistakes
from histories import read_rows

from turbine_fenicsx import restart_case, run_case
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.parallel import on_rank0
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.tables.loads import load_torques
from turbine_fenicsx.turbine.tables.pitch import load_pitch

RIGID = {"turbine": {"model": "rigid"}, "output": {"fields_every": 0}}
TORQUE = "# measured\ntime [s]; rotor_torque [kN m]\n0; 0\n\n0.1; 3000\n2; -1000\n"


@pytest.fixture
def write(comm, tmp_path_factory):
    """Writes a file; its path, equal on all ranks."""

    def write_file(text, name="torque.csv"):
        def make():
            path = tmp_path_factory.mktemp("table") / name
            path.write_text(text)
            return str(path)

        return on_rank0(comm, make)

    return write_file


def test_columns_are_read_with_their_units(write):
    text = "\ufefftime_[min], yaw_torque (MNm),\trotor_torque\n".replace(",\t", "\t")
    table = load_torques(write(text.replace(",", "\t") + "0\t1\t2\n1\t3\t-4\n"))
    assert table.times.tolist() == [0.0, 60.0]
    assert table.columns["yaw_torque"].tolist() == [1e6, 3e6]
    assert table.columns["rotor_torque"].tolist() == [2.0, -4.0]


def test_a_changed_file_is_read_again(tmp_path):
    path = tmp_path / "torque.csv"
    path.write_text("time,rotor_torque\n0,1\n1,2\n")
    assert load_torques(str(path)).columns["rotor_torque"][1] == 2.0
    path.write_text("time,rotor_torque\n0,1\n1,2500\n")
    assert load_torques(str(path)).columns["rotor_torque"][1] == 2500.0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "torque.csv is empty, expected a heading and two or more lines of numbers"),
        ("time,rotr_torque\n0,1\n1,2\n", "torque.csv has an unknown column 'rotr_torque', "),
        ("time,rotor_torque,rotor_torque\n0,1,1\n", "torque.csv has a second column 'rotor_t"),
        ("0,1\n1,2\n", "torque.csv has an unknown column '0', expected time and one or more of "),
        ("rotor_torque\n1\n2\n", "torque.csv has no column time; its first line must name"),
        ("time\n1\n2\n", "torque.csv has no column one of rotor_torque, yaw_torque, pitch_t"),
        ("time,rotor_torque [kN]\n0,1\n1,2\n", "torque.csv, column rotor_torque [kN]: expected a "),
        ("time,rotor_torque\n0,1\n", "torque.csv has 1 lines of numbers, expected two or more"),
        ("time,rotor_torque\n0,1\n1\n", "torque.csv, line 3: expected 2 finite numbers, got '1'"),
        ("time,rotor_torque\n0,1\n1,nan\n", "torque.csv, line 3: expected 2 finite numbers, got"),
        (
            "time;rotor_torque\n0;1\n1; 2,5\n",
            "torque.csv, line 3: expected 2 finite numbers, got '1; 2,5'",
        ),
        ("time,rotor_torque\n0,1\n1,a\n", "torque.csv, line 3: expected 2 finite numbers, got "),
        ("time,rotor_torque\n0,1\n2,1\n2,3\n", "torque.csv, line 4: times must rise, got 2 s aft"),
        ("time,rotor_torque\n0,1\n1,1e31\n", "torque.csv, line 3: rotor_torque = 1e+31 N m must "),
        ("time,rotor_torque\n0,1\n9,1\n", "torque.csv goes from 0 to 9 s, expected times from 0"),
        ("time,rotor_torque\n1,1\n19,1\n", "torque.csv goes from 1 to 19 s, expected times from 0"),
    ],
)
def test_a_wrong_file_is_one_sentence(write, text, sentence):
    (found,) = mistakes({**RIGID, "time": {"end": 12}, "loads": {"file": write(text)}})
    assert found.startswith(f"loads.file: {sentence}")
    assert "\n" not in found


@pytest.mark.parametrize(
    ("column", "tables", "sentence"),
    [
        (
            "rotor_torque",
            {"loads": {"rotor_torque": 5.0}},
            "loads.rotor_torque = 5: expected none beside loads.file = 'torque.csv', which has a "
            "column of it",
        ),
        (
            "yaw_torque",
            {"yaw": {"drive": "lock"}},
            'loads.file has a column yaw_torque: expected yaw.drive = "free", got "lock"',
        ),
        (
            "pitch_torque",
            {"pitch": {"drive": "prescribed"}},
            'loads.file has a column pitch_torque: expected pitch.drive = "free" or "spring", got '
            '"prescribed"',
        ),
        (
            "pitch_torque",
            {"turbine": {"model": "hybrid"}},
            "loads.file has a column pitch_torque: expected pitch.bearings = true",
        ),
    ],
)
def test_torques_act_on_free_bearings_once(write, column, tables, sentence):
    data = {**RIGID, **tables}
    file = write(f"time,{column}\n0,1\n20,2\n")
    assert mistakes({**data, "loads": {**data.get("loads", {}), "file": file}}) == [sentence]


@pytest.mark.parallel
def test_a_missing_file_is_one_sentence():
    (found,) = mistakes({**RIGID, "loads": {"file": "nowhere.csv"}})
    assert found.startswith("loads.file: cannot read the table 'nowhere.csv': No such file")


@pytest.mark.parallel
def test_torques_of_a_file_do_their_work_and_survive_a_restart(comm, write, tmp_path_factory):
    loads = {"file": write(TORQUE), "gravity": 0}
    given = {**RIGID, "loads": loads, "time": {"step": 0.01, "end": 0.2}}
    folders = [on_rank0(comm, lambda: tmp_path_factory.mktemp("run")) for _ in range(2)]
    summary = run_case(Case.parse(given), folders[0], comm, progress="none")
    assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]
    table = read_rows(folders[0])
    angle = np.array([row["angle_rotor_[rad]"] for row in table])
    middle = 0.01 * np.arange(20) + 0.005
    torque = np.interp(middle, [0.0, 0.1, 2.0], [0.0, 3e6, -1e6])
    assert table[-1]["work_of_torque_on_rotor_[J]"] > 1.0
    assert table[-1]["work_of_torque_on_rotor_[J]"] == pytest.approx(np.diff(angle) @ torque)
    run_case(Case.parse({**given, "time": {"step": 0.01, "end": 0.1}}), folders[1], comm, "none")
    restart_case(folders[1], comm, ["time.end=0.2"], progress="none")
    timeless = [
        [{k: v for k, v in row.items() if "wall" not in k} for row in read_rows(folder)]
        for folder in folders
    ]
    assert timeless[0] == timeless[1]
    with pytest.raises(InputError, match=r"goes from 0 to 2 s, expected times from 0 to"):
        restart_case(folders[1], comm, ["time.end=3"], progress="none")
    file = json.loads((folders[1] / "case.json").read_text())["loads"]["file"]
    on_rank0(comm, lambda: open(file, "a").write("3,0\n"))
    with pytest.raises(InputError, match="loads file"):
        restart_case(folders[1], comm, ["time.end=0.3"], progress="none")


def test_torques_of_a_file_set_in_with_the_ramp(comm, write, tmp_path_factory):
    works = []
    for ramp in (0.0, 0.1):
        time = {"step": 0.01, "end": 0.1, "ramp": ramp}
        given = Case.parse({**RIGID, "loads": {"file": write(TORQUE)}, "time": time})
        assert "time.ramp has no effect without a torque" not in given.warnings
        folder = on_rank0(comm, lambda: tmp_path_factory.mktemp("run"))
        run_case(given, folder, comm, progress="none")
        works.append(read_rows(folder)[-1]["work_of_torque_on_rotor_[J]"])
    assert 0.0 < works[1] < works[0]


def test_blades_follow_the_pitch_of_a_file(comm, write, tmp_path_factory):
    file = write("time [s],pitch_1 [deg],pitch_2 [deg],pitch_3 [deg]\n0,5,-5,0\n1,6,-3,3\n")
    pitch = {"drive": "prescribed", "file": file, "initial": ["5 deg", "-5 deg", 0.0]}
    given = {**RIGID, "pitch": pitch, "time": {"step": 0.02, "end": 0.4}}
    folder = on_rank0(comm, lambda: tmp_path_factory.mktemp("run"))
    summary = run_case(Case.parse(given), folder, comm, progress="none")
    assert summary["worst_energy_error_[J]"] <= 1e-11 * summary["largest_energy_[J]"]
    lines = [x.split() for x in (folder / "history.out").read_text().splitlines()]
    names = next(x for x in lines if x[:1] == ["Time"])
    angles = [float(lines[-1][names.index(f"BldPitch{k}")]) for k in (1, 2, 3)]
    assert angles == pytest.approx([5.4, -4.2, 1.2])


def test_pitch_that_does_not_begin_at_rest_is_warned_of(write):
    file = write("time [s],pitch_1 [deg],pitch_2 [deg],pitch_3 [deg]\n0,9,9,9\n2,9,7,9\n20,0,0,0\n")
    pitch = {"drive": "prescribed", "file": file, "initial": "9 deg"}
    (said,) = (x for x in Case.parse({**RIGID, "pitch": pitch}).warnings if "pitch.file" in x)
    assert said.startswith("pitch.file: pitch_2 begins with -1 deg/s, but blades start at rest")


def test_pitch_turns_the_short_way(write):
    (table, name), *_ = load_pitch(write("time,pitch [deg]\n0,350\n1,10\n2,-350\n", "pitch.csv"))
    assert np.degrees(table.columns[name]) == pytest.approx([350.0, 370.0, 370.0])


def test_the_pitch_of_a_file_begins_where_the_blades_do(write):
    file = write("time,pitch [deg]\n0,5\n20,6\n", "pitch.csv")
    assert len(load_pitch(file)) == 3
    wrong = {**RIGID, "pitch": {"drive": "prescribed", "file": file}}
    assert mistakes(wrong) == [
        "pitch.initial = 0 deg: expected 5 deg, the value of pitch at t = 0 in pitch.file"
    ]
    wrong["pitch"]["initial"] = ["5 deg", "5 deg", "4 deg"]
    assert mistakes(wrong)[0].startswith("pitch.initial = 4 deg: expected 5 deg")
    unused = Case.parse({**RIGID, "pitch": {"file": file}})
    assert 'pitch.file has no effect with pitch.drive = "free"' in unused.warnings
    short = write("time,pitch_1,pitch_2\n0,0,0\n20,0,0\n", "pitch.csv")
    (found,) = mistakes({**RIGID, "pitch": {"drive": "prescribed", "file": short}})
    assert found == (
        "pitch.file: pitch.csv has the columns pitch_1, pitch_2, expected pitch, or pitch_1, "
        "pitch_2 and pitch_3"
    )

"""Output folders are read as written, and what is wrong with one is a sentence."""

import numpy as np
import pytest
from outputs import history, turbine, write

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import (
    make_target_folder,
    read_field_times,
    read_histories,
    read_history,
    read_tables,
)


def test_history_is_read_as_written(tmp_path):
    columns = history()
    run = read_history(write(tmp_path / "stiff" / "history.csv", columns))
    assert run.name == "stiff"
    assert list(run.columns) == list(columns)
    for name, values in columns.items():
        assert np.array_equal(run[name], values)
    assert list(run.of(names.ANGLE)) == ["yaw", "rotor"]
    assert list(run.of(names.TIP_DEFLECTION)) == ["1", "2", "3"]


def test_row_that_a_crash_cut_off_is_left_out(tmp_path):
    run = read_history(write(tmp_path / "history.csv", history(n=5), end="12.2,3.0"))
    assert len(run["time_[s]"]) == 5


def test_empty_field_is_not_a_number(tmp_path):
    columns = history(n=3) | {"max_stress_[Pa]": ["1.0", "", "3.0"]}
    values = read_history(write(tmp_path / "history.csv", columns))["max_stress_[Pa]"]
    assert np.array_equal(values, [1.0, np.nan, 3.0], equal_nan=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "holds no rows"),
        (b"time_[s]\n", "holds no rows"),
        (b"time_[s]\nnow\n", "row 1: .*'now'"),
        (b"time_[s],a\n0,1\n2\n3,4\n", "row 2 has 1 fields, the header 2"),
        (b"time_[s],a\n,1\n", "a row has no time"),
        (b"a,b\n1,2\n", r"has no column 'time_\[s\]'"),
        (b"\x89PNG\r\n\x1a\n", "is not a table"),
        (b"time_[s]\n\x00\n", "history.csv"),
    ],
)
def test_broken_history_is_one_sentence(tmp_path, text, message):
    (tmp_path / "history.csv").write_bytes(text)
    with pytest.raises(InputError, match=message) as caught:
        read_history(tmp_path / "history.csv")
    assert "\n" not in str(caught.value)


def test_runs_are_named_so_that_their_names_differ(tmp_path):
    folders = [tmp_path / name for name in ("a/out", "b/out", "b/more")]
    for folder in folders:
        write(folder / "history.csv", history(n=2))
    assert [run.name for run in read_histories(folders[1:])] == ["out", "more"]
    assert [run.name for run in read_histories(folders)] == ["a/out", "b/out", "b/more"]
    deep = [tmp_path / name for name in ("x/a/out", "y/a/out", "y/b/out")]
    for folder in deep:
        write(folder / "history.csv", history(n=2))
    assert [run.name for run in read_histories(deep)] == ["x/a/out", "y/a/out", "y/b/out"]
    with pytest.raises(InputError, match="more' is given twice"):
        read_histories([folders[2], tmp_path / "b" / "." / "more"])
    with pytest.raises(InputError, match=r"there is no output folder .*/c'"):
        read_histories([tmp_path / "c"])


def test_times_of_the_fields_are_those_written(tmp_path):
    assert read_field_times(turbine(tmp_path / "fields.xdmf", (0.0, 0.25, 1.0))).tolist() == [
        0,
        0.25,
        1,
    ]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda folder: (folder / "fields.xdmf").unlink(), "output.fields_every greater than 0"),
        (lambda folder: (folder / "fields.xdmf").write_text("<Xdmf>"), "is not the field output"),
        (lambda folder: (folder / "fields.xdmf").write_text("<Xdmf/>"), "holds no times"),
        (lambda folder: (folder / "fields.bin").unlink(), "fields.bin is missing"),
        (lambda folder: (folder / "fields.bin").write_bytes(b"0" * 99), "fields.bin is incomplete"),
    ],
)
def test_damaged_fields_are_one_sentence(tmp_path, damage, message):
    path = turbine(tmp_path / "fields.xdmf")
    damage(tmp_path)
    with pytest.raises(InputError, match=message) as caught:
        read_field_times(path)
    assert "\n" not in str(caught.value)


def test_tables_may_be_missing_but_not_broken(tmp_path):
    path = tmp_path / "case.json"
    assert read_tables(path) is None
    path.write_text('{"time": {"end": 12.0}}')
    assert read_tables(path) == {"time": {"end": 12.0}}
    for text, message in (("{", "is not valid JSON"), ("[]", "holds no tables")):
        path.write_text(text)
        with pytest.raises(InputError, match=message):
            read_tables(path)


def test_folder_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", "/proc/nothing"):
        with pytest.raises(InputError, match="cannot write to"):
            make_target_folder(folder)
    assert make_target_folder(tmp_path / "new" / "one").is_dir()

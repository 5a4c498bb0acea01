"""What is said of folders that are not those of a run with fields."""

import json

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.names import find_column
from turbine_fenicsx.records.output_folder import read_field_times, read_histories


def test_the_folder_of_a_study_names_a_run_of_it(tmp_path):
    (tmp_path / "study.csv").write_text("run\n")
    (tmp_path / "seed_1").mkdir()
    (tmp_path / "seed_1" / "history.csv").write_text("time_[s]\n0.0\n")
    with pytest.raises(InputError, match=r"is the folder of a study: name one of its runs, such"):
        read_histories([tmp_path])
    assert len(read_histories([tmp_path / "seed_1"])) == 1


@pytest.mark.parametrize(
    ("model", "words"),
    [("reduced", "`turbine-fenicsx recover --fields` makes"), ("full", "fields_every great")],
)
def test_a_run_without_fields_says_why(tmp_path, model, words):
    (tmp_path / "case.json").write_text(json.dumps({"blade": {"model": model}}))
    with pytest.raises(InputError, match=words):
        read_field_times(tmp_path / "fields.xdmf")


def test_columns_are_found_without_their_unit():
    columns = ["a_[m]", "b_[m]", "b_[s]", "c"]
    assert [find_column(columns, x) for x in ("a", "a_[m]", "b", "c", "d")] == (
        ["a_[m]", "a_[m]", "b", "c", "d"]
    )

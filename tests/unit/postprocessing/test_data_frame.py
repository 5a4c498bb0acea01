"""An output folder as a table of pandas."""

import json
import sys

import numpy as np
import pytest

from turbine_fenicsx import read_run
from turbine_fenicsx.foundation.errors import InputError


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "history.csv").write_text("time_[s],angle_rotor_[rad]\n0,0\n0.1,0.25\n0.2,0.5\n")
    (tmp_path / "summary.json").write_text(json.dumps({"steps": 2}))
    return tmp_path


def test_a_run_is_a_table_over_time_with_its_summary(folder):
    pytest.importorskip("pandas")
    frame = read_run(folder)
    assert frame.index.name == "time_[s]" and list(frame.columns) == ["angle_rotor_[rad]"]
    np.testing.assert_array_equal(frame.loc[0.1:, "angle_rotor_[rad]"], [0.25, 0.5])
    assert frame.attrs == {"summary": {"steps": 2}}


def test_without_pandas_a_sentence_says_what_to_install(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="needs pandas: pip install pandas"):
        read_run(folder)


def test_a_missing_folder_is_named(tmp_path):
    pytest.importorskip("pandas")
    with pytest.raises(InputError, match="nowhere"):
        read_run(tmp_path / "nowhere")

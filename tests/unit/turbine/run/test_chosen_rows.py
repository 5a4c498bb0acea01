"""Rows of a motion that users name by times and by extremes of columns."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.turbine.run.chosen_rows import find_moments, find_rows, find_rows_every

TIMES = np.array([0.0, 0.1, 0.2, 0.35, 0.5])


def test_rows_are_the_nearest_ones_and_each_comes_once():
    assert find_rows(TIMES, [0.5, 0.09, 0.11, 0.3, 0.0]) == [0, 1, 3, 4]


@pytest.mark.parametrize(
    ("given", "rows"),
    [
        ((0.2,), [0, 2, 4]),
        ((0.1,), [0, 1, 2, 3, 4]),
        ((1e-12,), [0, 1, 2, 3, 4]),
        ((1e12,), [0]),
        ((0.2, 0.1), [1, 3, 4]),
        ((0.1, None, 0.2), [0, 1, 2]),
        ((0.1, 0.3, 0.4), [3]),
    ],
)
def test_rows_at_equal_distances_are_the_first_of_each_interval(given, rows):
    assert find_rows_every(TIMES, *given) == rows


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "history.csv").write_text(
        "time_[s],tip_clearance_1_[m],steps\n0,3,\n0.1,1,\n0.2,2,\n", encoding="utf-8"
    )
    head = "\n".join(["#"] * 6)
    (tmp_path / "history.out").write_text(f"{head}\nTime RotSpeed\n(s) (rpm)\n0.1 5\n0.2 7\n")
    return tmp_path


def test_moments_are_numbers_and_extremes_of_what_is_known(folder):
    recovered = {"tsai_wu": (TIMES, np.array([0.0, 1.0, 3.0, 9.0, 2.0]))}
    texts = [" 12.5", "7s", "max(tsai_wu)", "min(tip_clearance_1)", "max( tip_clearance_1_[m] )"]
    found = find_moments([*texts, "max(RotSpeed)"], folder, recovered)
    assert found == [12.5, 7.0, 0.35, 0.1, 0.0, 0.2]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("soon", r"time 'soon': expected a number, max\(NAME\) or min\(NAME\)"),
        ("nan", "time 'nan': expected a number"),
        ("mean(tsai_wu)", "expected a number"),
        ("min(tip_clearence_1)", "neither .* of the run; did you mean 'tip_clearance_1'"),
        ("max(steps)", "'max.steps.': the column has no numbers"),
    ],
)
def test_other_texts_are_refused(folder, text, words):
    with pytest.raises(InputError, match=words):
        find_moments([text], folder, {})


def test_times_outside_are_refused():
    with pytest.raises(InputError, match=r"t = 0.6 s is outside of the motion, which is from 0 s"):
        find_rows(TIMES, [0.1, 0.6])
    with pytest.raises(InputError, match=r"no row from 0.4 s to 0.2 s; it is from 0 s to 0.5 s"):
        find_rows_every(TIMES, 0.1, 0.4, 0.2)

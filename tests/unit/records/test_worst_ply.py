"""The largest failure index of plies in a history."""

import numpy as np
import pytest

from turbine_fenicsx.records.output_folder import TimeSeries
from turbine_fenicsx.records.worst_ply import WorstPly, find_worst_ply


def history(scale):
    index = scale * np.array([0.2, np.nan, 0.9, 0.4])
    return TimeSeries(
        "run",
        {
            "time_[s]": np.array([0.0, 1.0, 2.0, 3.0]),
            "constraint_error_[-]": np.full(4, 9.0),
            "nose_tsai_wu_[-]": 0.5 * index,
            "nose_tsai_wu_at_[m]": np.full(4, 3.0),
            "web1_tsai_wu_[-]": index,
            "web1_tsai_wu_at_[m]": np.array([1.0, 2.0, 104.75, 4.0]),
        },
    )


@pytest.mark.parametrize("scale", [1.0, 1.5])
def test_the_worst_ply_has_panel_place_and_time(scale):
    worst = find_worst_ply(history(scale))
    assert worst == WorstPly(pytest.approx(0.9 * scale), "tsai_wu", "web1", 104.75, 2.0)
    assert worst.warning == (
        "plies fail: the largest index of tsai_wu is 1.35, in web1 104.8 m from the root at t = 2 "
        "s; 1 is failure"
        if scale > 1.0
        else ""
    )


def test_a_history_without_plies_has_none():
    columns = {k: v for k, v in history(1.0).columns.items() if "tsai" not in k}
    assert find_worst_ply(TimeSeries("run", columns)) is None

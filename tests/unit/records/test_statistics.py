"""Claims about ``statistics.csv``: means over time, extremes with their times."""

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.output_folder import TimeSeries
from turbine_fenicsx.records.statistics import (
    STATISTICS,
    find_statistics,
    read_statistics,
    write_statistics,
)

TIME = [0.0, 1.0, 3.0, 4.0]
"""Of rows; the second step is twice as long."""


def write_run(folder, load=(0.0, 5.0, 2.0, -1.0)):
    rows = [f"{t},{x},{10.0 * t}" for t, x in zip(TIME, load, strict=True)]
    (folder / "history.csv").write_text(
        "\n".join(["time_[s],load_[N],wall_time_[s]", *rows]) + "\n"
    )
    lines = [*[""] * 6, "Time\tRotThrust", "(s)\t(kN)"]
    lines += [f"{t}\t{1e-3 * x}" for t, x in zip(TIME[1:], load[1:], strict=True)]
    (folder / "history.out").write_text("\n".join(lines) + "\n")


def test_rows_count_as_long_as_their_steps_are(tmp_path):
    write_run(tmp_path)
    write_statistics(tmp_path)
    thrust, load = read_statistics(tmp_path)
    assert (thrust.column, load.column) == ("RotThrust_[kN]", "load_[N]")
    x, h = np.array([5.0, 2.0, -1.0]), np.array([1.0, 2.0, 1.0]) / 4.0
    assert load.mean == pytest.approx(h @ x)
    assert load.deviation == pytest.approx(np.sqrt(h @ (x - h @ x) ** 2))
    assert (load.least, load.time_of_least) == (-1.0, 4.0)
    assert (load.largest, load.time_of_largest) == (5.0, 1.0)  # the first row belongs to no step
    assert thrust.mean == pytest.approx(1e-3 * load.mean)
    head = (tmp_path / STATISTICS).read_text().splitlines()[0]
    assert head == "column,mean,deviation,least,time_of_least_[s],largest,time_of_largest_[s]"


def test_a_transient_is_left_out(tmp_path):
    write_run(tmp_path)
    write_statistics(tmp_path, begin=1.0)
    _, load = read_statistics(tmp_path)
    assert load.mean == pytest.approx((2.0 * 2.0 - 1.0) / 3.0) and load.largest == 2.0
    write_statistics(tmp_path, begin=4.0)
    assert read_statistics(tmp_path) == []
    series = TimeSeries("run", {"time_[s]": np.array(TIME), "load_[N]": np.arange(4.0)})
    with pytest.raises(InputError, match="'run' has no row after 4 s"):
        find_statistics(series, 4.0)


def test_other_tables_are_refused(tmp_path):
    (tmp_path / STATISTICS).write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="is not a table of statistics"):
        read_statistics(tmp_path)

"""Claims about loads of return periods of a set, and about what is kept of its runs."""

import csv
import os
from unittest import mock

import numpy as np
import pytest
from outputs import history, write

from turbine_fenicsx.load_sets import run_loads
from turbine_fenicsx.load_sets.extrapolation import extrapolate
from turbine_fenicsx.load_sets.lifetime import YEAR, make_bins
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.load_sets.return_loads import find_return_loads, format_return_loads
from turbine_fenicsx.load_sets.run_loads import RunLoads, find_loads
from turbine_fenicsx.records.output_folder import LOADS
from turbine_fenicsx.study.plan import Run

NAMES = ("1.2/v5_s1", "1.2/v5_s2", "1.2/v15_s3", "1.3/v15_s4")
COLUMNS = ("a_[N]", "b_[N]", "rest_[N]")


@pytest.fixture
def given():
    tables = {"case": "a.toml", "situations": ["1.1", "1.2"], "extremes": {"years": 20}}
    runs = [
        SetRun(Run(x, {}, None, ""), x[:3], float(x[5:].split("_")[0]), 0.0, "", None)
        for x in NAMES
    ]
    random, loads = np.random.default_rng(0), {}
    for each in runs:
        least, largest = random.gumbel(size=(2, 10, 3))
        least[:, 2] = largest[:, 2] = 4.0
        loads[each.run.name] = RunLoads({}, COLUMNS, -least, each.wind + largest)
    return LoadSet.parse(tables), runs, loads


def test_all_runs_of_a_speed_count_by_its_winds(given):
    load_set, runs, loads = given
    found = find_return_loads(load_set, runs, loads, "1.2")
    assert {each.column for each in found} == {"a_[N]", "b_[N]"}  # no distribution of what rests
    assert {round(each.period) for each in found} == {0, 1, 10, 20, 50}
    bins = make_bins(load_set, ["1.2"], runs)
    shares = [bins.share(speed) for speed in (5.0, 15.0)]
    for side, sign in ("largest", 1.0), ("least", -1.0):
        parts = [sign * getattr(loads[name], side) for name in NAMES[:3]]
        slow, fast = np.concatenate(parts[:2])[:, 1:2], parts[2][:, 1:2]
        (direct,) = extrapolate([slow, fast], shares, 60.0, [20 * YEAR])
        (own,) = (x for x in found if (x.column, x.side, x.period) == ("b_[N]", side, 20))
        assert own.value == pytest.approx(sign * direct.loads[0], rel=1e-9)
        assert own.low < own.value < own.high
        assert own.seen == sign * max(slow.max(), fast.max())
    rows = list(csv.DictReader(format_return_loads({"1.1": found}).splitlines()))
    assert len(rows) == len(found) == 2 * 2 * 6
    assert rows[0]["return_period_[years]"] == repr(1.0 / 365.25)


def test_nothing_is_extrapolated_before_each_speed_has_enough_blocks(given):
    load_set, runs, loads = given
    del loads["1.2/v15_s3"]
    assert find_return_loads(load_set, runs, loads, "1.2") == []
    assert format_return_loads({"1.1": []}) == ""


@pytest.fixture
def folder(tmp_path):
    """A run of 12 s with rows at each 0.02 s, and loads of OpenFAST of the same times."""
    columns = history(n=601)
    columns["tower_base_moment_y_[Nm]"] = 2.0 * columns["root_moment_1_y_[Nm]"]
    out = write(tmp_path / "run" / "history.csv", columns).parent
    time, moment = columns["time_[s]"][1:], columns["root_moment_1_y_[Nm]"][1:]
    rows = [f"{t:.6E}\t{1e-3 * x:.6E}" for t, x in zip(time, moment, strict=True)]
    head = ["", "by turbine_fenicsx", "", "", "", "", "Time\tRootMyb1", "(s)\t(kN-m)"]
    (out / "history.out").write_text("\n".join([*head, *rows]) + "\n")
    return out


def test_blocks_begin_after_the_transient_and_are_whole(folder):
    found = find_loads(folder, 3.0, 2.0)
    assert found.least.shape == (4, len(found.columns))  # 9 s
    columns = history(n=601)
    time, values = columns["time_[s]"], columns["root_moment_1_y_[Nm]"]
    k = found.columns.index("root_moment_1_y_[Nm]")
    for j, begin in enumerate((3.0, 5.0, 7.0, 9.0)):
        own = values[(time > begin + 1e-9) & (time <= begin + 2.0 + 1e-9)]
        assert (found.least[j, k], found.largest[j, k]) == (own.min(), own.max())
    assert "RootMyb1_[kN-m]" in found.columns and "time_[s]" not in found.columns
    assert "tower_base_moment_y_[Nm]" in found.cycles


def test_what_is_kept_is_read_again_unless_it_is_older_damaged_or_of_other_times(
    folder, monkeypatch
):
    first = find_loads(folder, 3.0, 2.0)
    kept = folder / LOADS
    count = mock.Mock(side_effect=run_loads.read_both_histories)
    monkeypatch.setattr(run_loads, "read_both_histories", count)

    def is_read():
        before = count.call_count
        again = find_loads(folder, 3.0, 2.0)
        assert again.columns == first.columns and again.cycles.keys() == first.cycles.keys()
        assert np.array_equal(again.largest, first.largest)
        for name, cycles in first.cycles.items():
            assert np.array_equal(again.cycles[name].means, cycles.means)
        return count.call_count == before

    assert is_read()
    kept.write_bytes(kept.read_bytes()[:-100])
    assert not is_read() and is_read()
    assert find_loads(folder, 3.0, 1.0).least.shape[0] == 9
    assert not is_read()
    later = kept.stat().st_mtime + 1.0
    os.utime(folder / "history.csv", (later, later))
    assert not is_read()

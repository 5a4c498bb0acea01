"""Equivalent loads are those of closed forms."""

import csv
import io
import re
import sys

import numpy as np
import pytest
from outputs import history

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing.fatigue import (
    find_fatigue,
    format_fatigue,
)
from turbine_fenicsx.records.output_folder import TimeSeries

MOMENT = "root_moment_1_y_[Nm]"


def sine(amplitude=3.0, cycles=50, duration=100.0, points=5001):
    """A run with a moment that swings; the points meet its crests."""
    t = np.linspace(0.0, duration, points)
    moment = amplitude * np.sin(2.0 * np.pi * cycles * t / duration)
    return TimeSeries("run", {"time_[s]": t, MOMENT: moment})


@pytest.mark.parametrize("swing", [0.0, 1e-8])
def test_a_constant_and_round_off_about_it_have_no_cycles(swing):
    run = sine(swing)
    run = TimeSeries("run", dict(run.columns) | {MOMENT: 3e6 + run[MOMENT]})
    (found,) = find_fatigue(run, [MOMENT], [4.0])
    assert (found.cycles, found.largest, found.equivalent) == (0.0, 0.0, {4.0: 0.0})


@pytest.mark.parametrize("slope", [1.0, 4.0, 10.0])
def test_a_sine_has_its_own_range_at_its_own_frequency(slope):
    (found,) = find_fatigue(sine(), [MOMENT], [slope], frequency=0.5)
    assert found.largest == pytest.approx(6.0, rel=1e-12)
    assert found.cycles == pytest.approx(50.0, abs=0.5)  # the ends are quarters of cycles
    # 49 whole cycles, two halves, a half of half the range at each end; without the first row
    exact = 6.0 * ((49.5 + 2 * 0.5 * 0.5**slope) / 50.0) ** (1.0 / slope)
    assert found.equivalent[slope] == pytest.approx(exact, rel=3e-4)


def test_more_equivalent_cycles_have_a_smaller_range():
    one, ten = (find_fatigue(sine(), frequency=f)[0].equivalent[10.0] for f in (1.0, 10.0))
    assert one / ten == pytest.approx(10.0 ** (1.0 / 10.0))


def test_loads_whose_powers_overflow_are_none_the_worse():
    (found,) = find_fatigue(sine(amplitude=1e9), slopes=[40.0], frequency=0.5)
    assert found.equivalent[40.0] == pytest.approx(2e9, rel=1e-3)


def test_a_load_that_rests_does_no_damage():
    run = sine(amplitude=0.0)
    (found,) = find_fatigue(run)
    assert (found.largest, found.equivalent) == (0.0, {10.0: 0.0})


def test_what_is_before_the_start_does_not_count():
    run = sine()
    run[MOMENT][:300] = 1e3
    run[MOMENT][200] = np.nan
    (found,) = find_fatigue(run, start=6.0)
    assert found.largest == pytest.approx(6.0, rel=1e-9)
    assert found.cycles == pytest.approx(47.0, abs=1.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_told(value):
    run = sine()
    run[MOMENT][1000:1003] = value  # 50 points a second
    with pytest.raises(InputError, match=rf"has 3 entries .* first {value:g} at t = 20 s"):
        find_fatigue(run)
    find_fatigue(run, start=21.0)


def test_times_out_of_order_are_told():
    run = sine()
    run["time_[s]"][1000] = 3.0
    with pytest.raises(InputError, match=r"'run' do not rise: 3 s comes after 19.98 s"):
        find_fatigue(run)


def test_steel_and_glass_fibre_have_slopes_of_their_own():
    run = sine()
    run.columns["tower_base_moment_x_[Nm]"] = run[MOMENT]
    run.columns["TwrBsMxt"] = run[MOMENT]
    found = find_fatigue(run, [MOMENT, "tower_base_moment_x_[Nm]", "TwrBsMxt"])
    assert [list(each.equivalent) for each in found] == [[10.0], [4.0], [4.0]]
    rows = list(csv.DictReader(io.StringIO(format_fatigue(found))))
    assert rows[0]["equivalent_range_slope_4"] == "" == rows[1]["equivalent_range_slope_10"]
    assert float(rows[1]["equivalent_range_slope_4"]) == found[1].equivalent[4.0]


def test_moments_of_roots_and_tower_and_gauges_are_chosen():
    columns = history()
    columns["strain_flap_[-]"] = columns["tower_base_moment_y_[Nm]"] = columns["tip_flap_1_[m]"]
    found = find_fatigue(TimeSeries("run", columns))
    roots = [f"root_moment_{k}_{axis}_[Nm]" for k in (1, 2, 3) for axis in "xyz"]
    assert [each.column for each in found] == [
        *roots,
        "strain_flap_[-]",
        "tower_base_moment_y_[Nm]",
    ]


def test_the_row_before_the_first_step_does_not_count():
    """Loads are means over steps, zero before the first: no cycle from there to their mean."""
    run = sine()
    run[MOMENT][1:] += 100.0
    (found,) = find_fatigue(run)
    assert found.largest == pytest.approx(6.0, rel=3e-4)


def test_table_reads_back_exactly():
    found = find_fatigue(sine(), slopes=[4.0, 10.0])
    (row,) = csv.DictReader(io.StringIO(format_fatigue(found)))
    assert row["column"] == MOMENT
    assert float(row["equivalent_range_slope_4"]) == found[0].equivalent[4.0]
    assert float(row["equivalent_range_slope_10"]) == found[0].equivalent[10.0]


def test_wrong_columns_are_told():
    run = sine()
    with pytest.raises(InputError, match=r"no column 'nothing'"):
        find_fatigue(run, ["nothing"])
    with pytest.raises(InputError, match="neither root moments nor strain gauges"):
        find_fatigue(TimeSeries("run", {"time_[s]": run["time_[s]"]}))
    with pytest.raises(InputError, match="fewer than two numbers from t = 100 s on"):
        find_fatigue(run, start=100.0)


def test_means_count_where_an_ultimate_load_is_given():
    run = sine()
    run.columns["TwrBsMxt"] = run[MOMENT]
    run[MOMENT][:] += 7.0
    found = find_fatigue(run, [MOMENT, "TwrBsMxt"], ultimate={MOMENT: 21.0})
    plain = find_fatigue(run, [MOMENT, "TwrBsMxt"])
    assert found[0].largest == pytest.approx(1.5 * plain[0].largest, rel=1e-3)  # 21/(21 - 7)
    assert found[1] == plain[1]
    with pytest.raises(InputError, match=rf"ultimate load of '{re.escape(MOMENT)}' is 10: .* 10"):
        find_fatigue(run, [MOMENT], ultimate={MOMENT: 10.0})


def test_missing_library_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "rainflow", None)
    with pytest.raises(ImportError, match="needs rainflow: pip install rainflow"):
        find_fatigue(sine())

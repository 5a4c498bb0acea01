"""Claims about the fatigue of a load set: how often runs happen, equivalent loads of the life."""

import csv
from math import exp, pi

import pytest

from turbine_fenicsx.load_sets.lifetime import (
    YEAR,
    WindBins,
    format_fatigue_of_set,
    weigh_runs,
)
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.postprocessing.fatigue import Fatigue
from turbine_fenicsx.study.plan import Run

SET = {
    "case": "a.toml",
    "situations": ["1.2", "1.3", "4.1", "6.4"],
    "situation": {
        "1.2": {"winds": [5, 15]},
        "1.3": {"winds": [15]},
        "4.1": {"winds": [5, 15], "per_year": [100, 7]},
        "6.4": {"winds": [30]},
    },
}
RUNS = ("1.2/v5_s1", "1.2/v5_s2", "1.2/v15_s3", "1.3/v15_s4", "4.1/v5", "4.1/v15", "6.4/v30_s5")


def make_runs():
    found = []
    for name in RUNS:
        situation, _, rest = name.partition("/")
        wind = float(rest.partition("_")[0].removeprefix("v"))
        found.append(SetRun(Run(name, {}, None, ""), situation, wind, 0.0, "", None))
    return found


def exceed(speed, mean=10.0):
    """Of Rayleigh's distribution."""
    return exp(-pi / 4.0 * (speed / mean) ** 2)


def test_speeds_divide_all_winds_among_them():
    bins = WindBins([5.0, 15.0, 30.0], 2.0, 10.0)
    shares = [bins.share(speed) for speed in bins.speeds]
    assert shares == pytest.approx(
        [1.0 - exceed(10.0), exceed(10.0) - exceed(22.5), exceed(22.5)], rel=1e-12
    )
    exponential = WindBins([5.0, 15.0], 1.0, 10.0)
    assert exponential.share(15.0) == pytest.approx(exp(-1.0))


def test_runs_happen_as_long_as_their_wind_blows_and_events_as_often_as_they_say():
    weights = weigh_runs(LoadSet.parse(SET), make_runs(), RUNS)
    assert list(weights) == [name for name in RUNS if not name.startswith("1.3")]
    slow = (1.0 - exceed(10.0)) * 20.0 * YEAR / 600.0
    assert weights["1.2/v5_s1"] == weights["1.2/v5_s2"] == pytest.approx(0.5 * slow)
    fast = (exceed(10.0) - exceed(22.5)) * 20.0 * YEAR / 600.0
    assert weights["1.2/v15_s3"] == pytest.approx(fast)
    assert (weights["4.1/v5"], weights["4.1/v15"]) == (2000.0, 140.0)
    seconds = sum(600.0 * x for name, x in weights.items() if not name.startswith("4.1"))
    assert seconds == pytest.approx(20.0 * YEAR)


def test_runs_share_what_unfinished_ones_of_their_speed_leave():
    given, runs = LoadSet.parse(SET), make_runs()
    whole = weigh_runs(given, runs, RUNS)
    part = weigh_runs(given, runs, [name for name in RUNS if name not in (RUNS[0], RUNS[4])])
    assert part["1.2/v5_s2"] == pytest.approx(2.0 * whole["1.2/v5_s2"])
    assert {x: part[x] for x in ("1.2/v15_s3", "4.1/v15")} == {
        x: whole[x] for x in ("1.2/v15_s3", "4.1/v15")
    }


def test_the_load_of_the_life_does_the_damage_of_all_runs():
    tables = {**SET, "lifetime": {"years": 10, "mean_wind": "8 m/s", "cycles": 1e8}}
    given, runs = LoadSet.parse(tables), make_runs()
    sizes = {name: 1.0 + k for k, name in enumerate(RUNS)}
    begins = {}

    def find(run, begin):
        begins[run] = begin
        return [Fatigue("x", 7.0, sizes[run], {4.0: sizes[run], 10.0: 2.0 * sizes[run]})]

    rows = list(csv.DictReader(format_fatigue_of_set(given, runs, RUNS, find).splitlines()))
    weights = weigh_runs(given, runs, RUNS)
    assert len(rows) == 2 * len(weights) + 2 and begins["1.2/v5_s1"] == 60.0
    durations = {name: 60.0 if name.startswith("4.1") else 600.0 for name in weights}
    for row in rows[-2:]:
        m, factor = float(row["slope"]), {"4.0": 1.0, "10.0": 2.0}[row["slope"]]
        damage = sum(w * durations[x] * (factor * sizes[x]) ** m for x, w in weights.items())
        assert row["run"] == "lifetime"
        assert float(row["equivalent_range"]) == pytest.approx((damage / 1e8) ** (1.0 / m))
    assert rows[0]["equivalent_range"] == "1.0"
    assert float(rows[0]["times_in_life"]) == weights["1.2/v5_s1"]
    assert format_fatigue_of_set(given, runs, (), find) == ""

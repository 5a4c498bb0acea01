"""Claims about the fatigue of a load set: how often runs happen, equivalent loads of the life."""

import csv
from math import exp, pi

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.load_sets.lifetime import (
    YEAR,
    WindBins,
    find_fatigue_of_set,
    format_fatigue_of_set,
    weigh_runs,
)
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import SetRun
from turbine_fenicsx.postprocessing.cycles import Cycles
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


STEEL, GLASS = "tower_base_moment_y_[Nm]", "root_moment_1_y_[Nm]"


def make_cycles():
    """One range for each run, seven times, about a mean; of the root twice the range."""
    found = {}
    for k, name in enumerate(RUNS):
        sizes, means, counts = ([x] for x in (1.0 + k, 2.0, 7.0))
        steel = Cycles(*map(np.array, (sizes, means, counts)))
        found[name] = {STEEL: steel, GLASS: Cycles(2.0 * steel.ranges, steel.means, steel.counts)}
    return found


def test_the_load_of_the_life_does_the_damage_of_all_runs():
    life = {"years": 10, "mean_wind": "8 m/s", "cycles": 1e8, "ultimate": {GLASS: 22.0}}
    given, runs = LoadSet.parse({**SET, "lifetime": life}), make_runs()
    found = find_fatigue_of_set(given, runs, make_cycles())
    weights = weigh_runs(given, runs, RUNS)
    goodman = 22.0 / 20.0
    for load, m, factor in (STEEL, 4.0, 1.0), (GLASS, 10.0, 2.0 * goodman):
        ranges = {name: factor * (1.0 + RUNS.index(name)) for name in weights}
        damage = sum(7.0 * w * ranges[name] ** m for name, w in weights.items())
        assert found.of_life[load] == pytest.approx((damage / 1e8) ** (1.0 / m))
        for name, duration in ("1.2/v5_s1", 600.0), ("4.1/v15", 60.0):
            own = ranges[name] * (7.0 / duration) ** (1.0 / m)
            assert found.of_runs[name][load] == pytest.approx(own)
        assert found.cycles[load].counts.sum() == pytest.approx(7.0 * sum(weights.values()))
    rows = list(csv.DictReader(format_fatigue_of_set(found).splitlines()))
    assert len(rows) == 2 * len(weights) + 2
    assert [(row["run"], row["slope"]) for row in rows[-2:]] == [
        ("lifetime", "4.0"),
        ("lifetime", "10.0"),
    ]
    assert float(rows[0]["equivalent_range"]) == found.of_runs["1.2/v5_s1"][STEEL]
    assert float(rows[0]["times_in_life"]) == weights["1.2/v5_s1"]


def test_ultimate_loads_that_no_run_has_are_told():
    tables = {**SET, "lifetime": {"ultimate": {"root_moment_1_x_[Nm]": 1.0}}}
    with pytest.raises(InputError, match=r"lifetime.ultimate: 'root_moment_1_x_.Nm.' is no load"):
        find_fatigue_of_set(LoadSet.parse(tables), make_runs(), make_cycles())


def test_a_set_without_loads_has_no_table():
    assert format_fatigue_of_set(find_fatigue_of_set(LoadSet.parse(SET), make_runs(), {})) == ""

"""Claims about runs of a load set: which there are, how they begin, and what their tables say."""

import csv
from math import radians

import pytest
from controlled_case import write_controlled_case

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.plan import plan_set
from turbine_fenicsx.load_sets.results import format_extremes, format_runs
from turbine_fenicsx.load_sets.return_loads import ReturnLoad
from turbine_fenicsx.records.statistics import ColumnStatistics
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.steady.operating_states import find_schedule

SHORT = {"duration": 20, "transient": 10, "winds": [8, 18], "seeds": 2}


@pytest.fixture
def case(tmp_path):
    return write_controlled_case(tmp_path)


def make_set(case, *situations, **tables):
    return LoadSet.parse(
        {"case": str(case), "situations": situations, "extremes": {"block": 2}, **tables}
    )


def test_each_situation_has_its_winds_angles_variants_and_seeds(case):
    given = make_set(
        case,
        *("1.1", "1.2", "1.4", "6.1"),
        rated="11 m/s",
        situation={"1.2": {**SHORT, "yaw_errors": ["-8 deg", 0]}, "6.1": {"seeds": 1}},
    )
    runs = plan_set(given)
    names = [each.run.name for each in runs]
    assert names[:5] == [f"1.2/v8_{x}" for x in ("y-8_s1", "y-8_s2", "s3", "s4")] + [
        "1.2/v18_y-8_s5"
    ]
    assert names[8:] == [
        *(f"1.4/v{v}_{x}" for v in (9, 11, 13) for x in ("left", "right")),
        *("6.1/v50_y-8_s1", "6.1/v50_y8_s2"),
    ]
    assert {each.run.case.output.fields_every for each in runs} == {0.0}
    one = runs[1]
    assert (one.situation, one.wind, one.variant, one.seed) == ("1.2", 8.0, "", 2)
    found = one.run.case
    assert found.wind.direction == pytest.approx(radians(-8.0))
    assert found.wind.turbulence.model == "kaimal" and found.wind.turbulence.seed == 2
    assert (found.time.end, found.output.transient) == (30.0, 10.0)
    gust = runs[9].run.case
    assert gust.wind.gust == "ECD" and not gust.wind.has_box and gust.wind.gust_sign == -1
    storm = runs[-1].run.case
    assert storm.wind.turbulence.intensity == 0.11 and storm.wind.shear == 0.11
    assert storm.turbine.rotor_speed == 0.0 and storm.control.kind == "none"


def test_runs_begin_at_the_speed_and_the_pitch_of_their_wind(case):
    runs = plan_set(make_set(case, "1.2", situation={"1.2": SHORT}))
    schedule = find_schedule(Case.load(case))
    for each in runs:
        state, found = schedule.at(each.wind), each.run.case
        assert found.time.start == "turning"
        assert found.turbine.rotor_speed == pytest.approx(state.rotor_speed, abs=1e-6)
        assert found.pitch.initial == pytest.approx([state.pitch] * 3, abs=1e-6)


def test_the_rated_wind_is_where_the_blades_begin_to_pitch(case):
    schedule = find_schedule(Case.load(case))
    winds = [each.wind for each in plan_set(make_set(case, "4.1"))]
    low, high = (schedule.at(winds[1] + x) for x in (-0.2, 0.2))
    assert low.pitch == low.least_pitch and high.pitch > high.least_pitch
    assert [winds[0], winds[2]] == [3.0, 25.0]


def test_changes_of_the_set_give_way_to_those_of_a_situation(case):
    table = {"1.2": {**SHORT, "seeds": 1}, "6.1": {"seeds": 1}}
    given = make_set(case, "1.2", "6.1", situation=table, set={"wind.shear": 0.3})
    runs = plan_set(given, ["wind.shear=0.14", "time.step=0.2"])
    assert [each.run.case.wind.shear for each in runs] == [0.14, 0.14, 0.11, 0.11]
    assert {each.run.case.time.step for each in runs} == {0.2}
    case.write_text(case.read_text().replace('kind = "pi"', 'kind = "none"'))
    on = make_set(case, "1.2", situation=table, set={"control.kind": "pi"})
    assert len(plan_set(on)) == 2


def test_given_seeds_are_those_of_all_winds(case):
    runs = plan_set(
        make_set(case, "1.2", situation={"1.2": {**SHORT, "seeds": None}}, seeds=[7, 5])
    )
    assert [each.seed for each in runs] == [7, 5, 7, 5]


def test_a_set_without_a_controller_or_with_equal_runs_is_refused(case):
    given = make_set(case, "1.2", situation={"1.2": SHORT})
    with pytest.raises(InputError, match=r'situation "1.2" needs a controller, but the case has'):
        plan_set(given, ["control.kind=none"])
    own = {"own": {"winds": ["rated"], "start": "given", "duration": 1, "transient": 0}}
    with pytest.raises(InputError, match=r'situation "own" needs a controller, but the case has'):
        plan_set(make_set(case, "own", situation=own), ["control.kind=none"])
    known = make_set(case, "own", situation=own, rated="11 m/s")
    assert [each.wind for each in plan_set(known, ["control.kind=none"])] == [11.0]
    twice = make_set(case, "1.2", situation={"1.2": {**SHORT, "winds": [8, "8 m/s"], "seeds": 1}})
    assert len(plan_set(twice)) == 2  # other seeds
    steady = {**SHORT, "winds": [8, "8 m/s"], "turbulence": "none"}
    with pytest.raises(InputError, match=r"situation '1.2' has the run '1.2/v8' twice"):
        plan_set(make_set(case, "1.2", situation={"1.2": steady}))
    given = make_set(case, "1.2", situation={"1.2": SHORT}, set={"time.end": 5})
    with pytest.raises(InputError, match=r"'time.end' has no effect: each situation has its own"):
        plan_set(given)
    with pytest.raises(InputError, match=r"'wind.speed' has no effect: each situation has its"):
        plan_set(make_set(case, "1.2", situation={"1.2": SHORT}), ["wind.speed = 5"])
    with pytest.raises(InputError, match=r"unknown key 'wind.gusts'"):
        plan_set(make_set(case, "1.2", situation={"1.2": SHORT}, set={"wind.gusts": "EOG"}))


def test_tables_name_the_run_of_each_extreme_and_count_safety_factors(case, tmp_path):
    table = {"1.2": {**SHORT, "seeds": 1}, "1.3": {**SHORT, "seeds": 1}}
    given = make_set(case, "1.1", "1.2", "1.3", situation=table)
    runs = plan_set(given)
    values = {
        "1.2/v8_s1": (2.0, 1.0, -1.0, 3.0, 6.0, 4.0),
        "1.2/v18_s2": (4.0, 7.0, -2.0, 5.0, 5.0, 6.0),
        "1.3/v8_s1": (3.0, 1.0, -2.4, 7.0, 5.9, 8.0),
    }
    results = {name: [ColumnStatistics("x_[N]", *row)] for name, row in values.items()}
    returns = [
        ReturnLoad("x_[N]", side, 50.0, value, 0.0, 0.0, 0.0)
        for side, value in (("least", -2.2), ("largest", 6.2))
    ]
    extremes = format_extremes(runs, given.chosen, results, {"1.1": returns})
    rows = list(csv.DictReader(extremes.splitlines()))
    assert [row["situation"] for row in rows] == ["1.1", "1.2", "1.3", "all"]
    extrapolated, fatigue, extreme, worst = rows
    assert float(fatigue["mean"]) == 3.0 and float(fatigue["deviation"]) == 5.0
    assert (fatigue["largest"], fatigue["run_of_largest"]) == ("6.0", "1.2/v8_s1")
    assert (fatigue["least"], fatigue["run_of_least"]) == ("-2.0", "1.2/v18_s2")
    assert fatigue["time_of_least_[s]"] == "5.0" and fatigue["runs"] == "2"
    assert float(extrapolated["factored_largest"]) == 1.25 * 6.2
    assert (extrapolated["largest"], extrapolated["run_of_largest"]) == ("6.2", "extrapolated")
    # 1.35 times 5.9 is more than 1.25 times 6.2
    assert float(worst["factored_largest"]) == pytest.approx(1.35 * 5.9)
    assert worst["run_of_largest"] == extreme["run_of_largest"] == "1.3/v8_s1"
    assert float(worst["factored_least"]) == pytest.approx(-1.35 * 2.4)
    failed = {"1.3/v18_s2": "a step did not converge"}
    for name in values:
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "case.json").write_text('{"time": {"step": 0.05}}')
    times = {"1.2/v8_s1": 100.0}
    table = format_runs(given, runs, results, failed, times, tmp_path)
    lines = list(csv.DictReader(table.splitlines()))
    of_life = [(x["begin_[s]"], x["times_in_life"], x["life_[years]"]) for x in lines]
    assert of_life[0] == ("10.0", "100.0", "20.0")
    assert of_life[-1][1] == "0.0"
    assert [row["state"] for row in lines] == [*["finished"] * 3, "failed"]
    assert [row["step_[s]"] for row in lines] == [*["0.05"] * 3, ""]
    assert lines[-1]["reason"] == failed["1.3/v18_s2"]
    assert format_extremes(runs, given.chosen, {}, {}) == ""
    some = format_extremes(runs, given.chosen, results, {})
    assert "1.1" not in {row["situation"] for row in csv.DictReader(some.splitlines())}

"""Claims about files of load sets: which runs they stand for, and what they refuse."""

import tomllib

import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.load_sets.load_set import LoadSet
from turbine_fenicsx.load_sets.situation import Situation, read_standard


def test_the_situations_of_the_standard_are_valid_and_have_its_factors():
    found = LoadSet.parse({"case": "a.toml"}).chosen
    assert list(found) == list(read_standard())
    factors = {name: situation.factor for name, situation in found.items()}
    assert {name for name, x in factors.items() if x == 1.0} == {"1.2", "3.1", "4.1", "6.4"}
    assert {name for name, x in factors.items() if x == 1.1} == {"2.2", "2.3", "6.2", "7.1"}
    assert factors["1.1"] == 1.25 and factors["1.3"] == 1.35
    assert found["1.1"].uses == "1.2"


def test_winds_are_speeds_or_words_with_factors_and_differences():
    given = LoadSet.parse({"case": "a.toml", "turbine_class": "IIB", "cut_in": "4 m/s"})
    winds = ("rated - 2 m/s", "rated+0.5 m/s", "0.8 reference", "cut_out", 7, "36 km/h")
    found = given.find_winds(Situation(winds=winds), rated=10.6)
    assert found == pytest.approx([8.6, 11.1, 34.0, 25.0, 7.0, 10.0])
    assert given.find_winds(Situation(), 10.6) == [4.0 + 2.0 * k for k in range(11)]
    coarse = LoadSet.parse({"case": "a.toml", "cut_in": 4, "cut_out": 24, "wind_step": 10})
    assert coarse.operating == [4.0, 14.0, 24.0]


def test_a_set_changes_situations_and_adds_some():
    text = """
    case = "a.toml"
    situations = ["1.3", "9.1"]
    [situation."1.3"]
    seeds = 2
    [situation."9.1"]
    title = "of one's own"
    winds = [12]
    set = {wind.gust = "EOG"}
    """
    found = LoadSet.parse(tomllib.loads(text)).chosen
    assert found["1.3"].seeds == 2 and found["1.3"].turbulence == "extreme"
    assert found["9.1"].changes["wind.gust"] == "EOG"
    assert found["9.1"].changes["time.end"] == 660.0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"turbine_class": "IVB"}, "turbine_class = 'IVB': must be 'IA+', "),
        ({"situations": ["1.22"]}, "situations: '1.22' is none; did you mean '1.2'?"),
        ({"situations": ["1.2", "1.2"]}, "situations: each may stand there once"),
        ({"situations": ["1.1"]}, "situation.'1.1' uses '1.2', which is not run"),
        ({"seeds": [1, 2, 1]}, "seeds = [1, 2, 1]: expected numbers that do not repeat"),
        ({"seeds": 1, "extremes": {"block": 150}}, "5 blocks of extremes.block = 150 s at each"),
        ({"seeds": [-1]}, "seeds = [-1]: expected numbers from 0 on"),
        (
            {"situation": {"4.1": {"per_year": [5]}}},
            "situation.'4.1'.per_year: expected one number for each of its 3 winds, got 1",
        ),
        (
            {"situation": {"../x": {}}},
            "situation.'../x': expected a name of letters, digits, '.', ",
        ),
        ({"situation": {"all": {}}}, "situation.'all': expected a name of letters, "),
        (
            {"situation": {"own": {"winds": [9], "variants": {"a/b": {}}}}},
            "situation.'own'.variants: 'a/b' is none, expected names of letters, digits, ",
        ),
        ({"lifetime": {"shape": 0}}, "lifetime.shape = 0: must be "),
        ({"cut_out": "2 m/s"}, "cut_out = 2: expected more than cut_in = 3"),
        ({"wind_step": 1e-9}, "wind_step = 1e-09: expected at most 1000 wind speeds"),
        ({"speed": 1}, "unknown key 'speed'"),
        (
            {"situation": {"1.2": {"winds": [12, 27]}}},
            "situation.'1.2'.winds: 27 m/s is above cut_out = 25 m/s, where the turbine does not",
        ),
        ({"situation": {"1.2": {"winds": ["rated + 2"]}}}, None),
        ({"situation": {"1.2": {"winds": ["rated + 2 kg"]}}}, "situation.'1.2'.winds: "),
        ({"situation": {"1.2": {"winds": ["fast"]}}}, "situation.'1.2'.winds: "),
        (
            {"situation": {"1.2": {"turbulence": "much"}}},
            "situation.'1.2'.turbulence = 'much': must be 'none', 'normal', ",
        ),
    ],
)
def test_sets_that_cannot_be_are_refused(change, sentence):
    if sentence is None:
        LoadSet.parse({"case": "a.toml", **change})
        return
    with pytest.raises(InputError) as caught:
        LoadSet.parse({"case": "a.toml", **change})
    assert sentence in str(caught.value)

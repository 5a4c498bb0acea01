"""Strain gauges in a case: sentences about what cannot be, names, restarts."""

import pytest
from case_mistakes import mistakes
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.records.output_folder import read_tables
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.case.description import describe_case
from turbine_fenicsx.turbine.run.resume import change_case, write_case


def gauge(**keys):
    return {"output": {"gauges": {"flap": keys}}}


PLACES = "trailing edge, suction side, leading edge, pressure side"


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({}, "output.gauges.flap: expected either a station or a distance"),
        (
            {"station": 0.5, "distance": 3.0},
            "output.gauges.flap: expected either a station or a distance",
        ),
        (
            {"distance": "54 m"},
            "output.gauges.flap.distance = 54: expected less than 54 m, the length of the blades",
        ),
        (
            {"station": 0.5, "around": "nose"},
            "output.gauges.flap.around = 'nose': expected a number from 0 to 1 or one of " + PLACES,
        ),
        (
            {"station": 0.5, "around": 1.5},
            "output.gauges.flap.around = 1.5: expected a number from 0 to 1, or a place such as "
            '"suction side"',
        ),
        ({"station": 1.0}, "output.gauges.flap.station = 1.0: must be less than 1"),
        ({"station": 0.5, "blade": 4}, "output.gauges.flap.blade = 4: must be 1, 2 or 3"),
        (
            {"station": 0.5, "blde": 1},
            "unknown key 'output.gauges.flap.blde'; did you mean 'output.gauges.flap.blade'?",
        ),
        (
            {"station": 0.5, "xyz": 1},
            "unknown key 'output.gauges.flap.xyz'; [output.gauges.flap] takes angle, around, "
            "blade, distance, station",
        ),
    ],
)
def test_gauges_that_cannot_be_are_refused(keys, sentence):
    assert mistakes(gauge(**keys)) == [sentence]


@pytest.mark.parametrize("name", ["a b", "1", "", "ä", "x,y"])
def test_names_must_fit_into_columns(name):
    (found,) = mistakes({"output": {"gauges": {name: {"station": 0.5}}}})
    assert found.startswith("output.gauges: expected names of letters, digits and _ that begin")


@pytest.mark.parametrize("value", [1, "text", [1], {"flap": 3}, {"flap": [1]}])
def test_nonsense_is_refused_in_a_sentence(value):
    (found,) = mistakes({"output": {"gauges": value}})
    assert found.startswith("output.gauges")


def test_panels_of_a_file_are_places(tmp_path):
    write_turbine(small_turbine(), tmp_path)
    tables = {"turbine": {"file": "small.yaml"}, **gauge(station=0.5, around="spar cap")}
    with pytest.raises(InputError, match=r"pressure side, .*, spar cap, suction side, "):
        Case.parse(tables, tmp_path)
    tables |= gauge(distance="3 m", around="spar cap, suction side")
    case = Case.parse(tables, tmp_path)
    assert case.output.gauges["flap"].find_station(10.0) == 0.3


def test_rigid_blades_have_no_gauges():
    case = Case.parse({"turbine": {"model": "rigid"}, **gauge(station=0.5, around="nowhere")})
    assert 'output.gauges has no effect with turbine.model = "rigid"' in case.warnings


def test_a_run_that_goes_on_keeps_its_gauges(comm, shared_tmp_path):
    case = Case.parse(gauge(station=0.5, angle="45 deg"))
    write_case(case, shared_tmp_path, comm)
    assert change_case(shared_tmp_path, ["time.end=3"]).output == case.output
    with pytest.raises(InputError, match=r"output\.gauges cannot change in a resumed run"):
        change_case(shared_tmp_path, ["output.gauges.edge.station=0.2"])


def test_the_report_has_them_with_units(comm, shared_tmp_path):
    write_case(Case.parse(gauge(distance=2.0, angle=0.5)), shared_tmp_path, comm)
    table = describe_case(read_tables(shared_tmp_path / "case.json"))["output"]
    assert table["gauges"]["flap"]["distance_[m]"] == 2.0
    assert table["gauges"]["flap"]["angle_[rad]"] == 0.5
    assert "station_[-]" not in table["gauges"]["flap"]
    assert "gauges" not in describe_case(Case().model_dump())["output"]

"""Files against windIO's own schema."""

import sys

import pytest
from windio_files import IEA_15, IEA_22, find_turbine, small_turbine, write_turbine

from turbine_fenicsx.windio import validation
from turbine_fenicsx.windio.validation import list_schema_mistakes


@pytest.fixture
def schema():
    """Skips a test where there is no schema or nothing that reads it."""
    find_turbine(IEA_22)
    pytest.importorskip("jsonschema")


@pytest.mark.parametrize("name", [IEA_22, IEA_15])
def test_the_turbines_of_windio_are_valid(schema, name):
    assert list_schema_mistakes(find_turbine(name)) == []


def test_the_turbine_of_the_tests_is_valid(schema, tmp_path):
    assert list_schema_mistakes(write_turbine(small_turbine(), tmp_path)) == []


def test_mistakes_are_told_in_a_sentence_each(schema, tmp_path):
    tables = small_turbine()
    tables["components"]["hub"]["diameter"] = -1.0
    del tables["materials"][0]["rho"]
    tables["materials"][1]["E"] = "x\n" * 1000
    diameter, missing, long = list_schema_mistakes(write_turbine(tables, tmp_path))
    begin = "small.yaml: windIO's schema says of "
    assert diameter == f"{begin}components.hub.diameter that -1.0 is less than the minimum of 0.0"
    assert missing == f"{begin}materials[0] that 'rho' is a required property"
    assert (
        long.startswith(f"{begin}materials[1].E that 'x") and len(long) < 250 and "\n" not in long
    )


def test_of_many_mistakes_only_the_first_are_told(schema, tmp_path):
    tables = small_turbine()
    for material in tables["materials"]:
        del material["rho"], material["nu"]
    *first, last = list_schema_mistakes(write_turbine(tables, tmp_path))
    assert len(first) == 5
    assert last == "windIO's schema says so of 5 more entries"


def test_nothing_is_said_where_the_schema_or_its_reader_is_missing(tmp_path, monkeypatch):
    path = write_turbine({"windIO_version": "2.0"}, tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(validation, "find_windio", lambda: None)
        assert list_schema_mistakes(path) == []
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "jsonschema", None)
        assert list_schema_mistakes(path) == []

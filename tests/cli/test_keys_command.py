"""The command ``keys``: the reference of case files in a terminal."""

import json
import tomllib
from pathlib import Path

import pytest

from turbine_fenicsx.case.reference import Key, list_tables
from turbine_fenicsx.case.schema import make_schema
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.turbine.tables.tables import Tables

jsonschema = pytest.importorskip("jsonschema")
DEMOS = Path(__file__).parents[2] / "demos"
CASES = [
    path
    for folder in ("paper", "turbine", "iea15", "iea15_gust", "emergency_stop", "gallery")
    for path in sorted((DEMOS / folder).glob("*.toml"))
]


def test_every_table_and_every_key_is_printed(capfd):
    assert main(["keys", "all"]) == 0
    text = capfd.readouterr().out
    for table in list_tables(Tables):
        assert not table.name or f"\n[{table.name}]\n" in text or text.startswith(f"[{table.name}]")
        for key in table.keys:
            assert f"\n  {key.name}: default " in text
    assert "`" not in text


def test_keys_of_a_table_have_units_ranges_and_meanings(capfd):
    assert main(["keys", "turbine.hub"]) == 0
    text = capfd.readouterr().out
    assert "  mass: default 61000 kg; > 0 kg\n" in text
    assert "Centre of mass from the rotor centre" in text  # not that of the nacelle's table


def test_without_a_table_their_names_are_listed(capfd):
    assert main(["keys"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert {f"[{table.name}]" for table in list_tables(Tables) if table.name} <= {
        line.split()[0] for line in lines if line
    }


def test_an_unknown_table_is_told_with_the_nearest(capfd):
    assert main(["keys", "towr"]) == 2
    assert (
        "there is no table 'towr' in a case file; did you mean 'tower'?" in capfd.readouterr().err
    )


@pytest.mark.parametrize(
    "table, key",
    [
        ("time", Key("step", "s", "0.02", "> 0", "Time step Δt.")),
        ("blade", Key("twist", "rad", "", "list, each ≥ -3.14159, ≤ 3.14159", "")),
        ("control", Key("library", "", "", "text", "")),
        ("wind.box", Key("periodic", "", "true", "true, false", "")),
    ],
)
def test_unit_default_and_range_follow_from_the_types(table, key):
    found = {(t.name, k.name): k for t in list_tables(Tables) for k in t.keys}[table, key.name]
    assert (found.unit, found.default, found.allowed) == (key.unit, key.default, key.allowed)
    assert found.meaning and found.meaning.startswith(key.meaning)


def test_a_key_without_a_docstring_is_refused():
    class Bare(Tables):
        more: float = 1.0

    with pytest.raises(ValueError, match=r"Bare\.more has no docstring"):
        list_tables(Bare)


# --- the schema for editors


@pytest.fixture(scope="module")
def schema():
    return make_schema(Tables, "cases")


def find_mistakes(schema, text):
    """Dotted keys at which a validator of JSON schemas finds something wrong."""
    errors = jsonschema.Draft202012Validator(schema).iter_errors(tomllib.loads(text))
    return [".".join(map(str, error.absolute_path)) for error in errors]


def test_the_schema_is_printed(capfd, schema):
    assert main(["keys", "--schema"]) == 0
    printed = json.loads(capfd.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(printed)
    assert printed["$defs"] == schema["$defs"]
    assert printed["$defs"]["TimeCase"]["properties"]["step"]["description"] == "Time step Δt."


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_cases_of_the_demos_are_valid_by_the_schema(schema, path):
    assert find_mistakes(schema, path.read_text()) == []


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ('[[event]]\nkind = "grid_loss"\ntime = "2 s"\n', []),
        ('[event.stop]\nkind = "shut_down"\n', []),
        ('[blade]\ndamping = "0.5 %"\n', []),
        ("[blade]\ndamping = { flap_1 = 0.005 }\n", []),
        ('[turbine]\nblade_arm = "29.25 m"\n', []),
        ("[time]\nend = -1\n", ["time.end"]),
        ('[time]\nend = "soon"\n', ["time.end"]),
        ("[time]\nstp = 0.1\n", ["time"]),
        ('[turbine]\nmodel = "soft"\n', ["turbine.model"]),
        ("[mesh]\nelements = [1, 2]\n", ["mesh.elements"]),
        ("[blade]\nchord = [1, -2, 3]\n", ["blade.chord.1"]),
        ('[wind]\nspeed = "10 m/s"\nfile = 3\n', ["wind.file"]),
    ],
)
def test_the_schema_tells_right_from_wrong(schema, text, keys):
    assert find_mistakes(schema, text) == keys


def test_names_of_files_are_no_numbers(capsys):
    assert main(["keys", "wind.box"]) == 0
    text = capsys.readouterr().out
    assert "files: default none; 3 file names" in text
    assert "points: default none; 3 numbers, each" in text

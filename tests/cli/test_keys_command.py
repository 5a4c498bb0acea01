"""The command ``keys``: the reference of case files in a terminal."""

import pytest

from turbine_fenicsx.case.reference import Key, list_tables
from turbine_fenicsx.cli.main import main
from turbine_fenicsx.turbine.tables.tables import Tables


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

"""No two modes have one name: of titles that are put in, and of turbines."""

from math import pi

import pytest
from windio_files import small_turbine, write_turbine

from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.components.mode_names import Title
from turbine_fenicsx.turbine.modes.find_modes import ModesWanted, find_modes
from turbine_fenicsx.turbine.modes.mode_table import choose_names

FLAP = "second flap, backward whirl"
FORE = "second fore-aft of the tower"


def titles(**shares):
    names = {"flap": FLAP, "fore": FORE, "edge": "second edge, backward whirl"}
    ways = {"flap": "flap", "fore": "fore-aft", "edge": "edge"}
    return [Title(names[way], ways[way], share) for way, share in shares.items()]


def test_names_that_nobody_else_wants_are_kept():
    assert choose_names([titles(flap=0.5, fore=0.4), titles(edge=0.6, flap=0.4)]) == [
        FLAP,
        "second edge, backward whirl",
    ]
    assert choose_names([]) == []


def test_of_two_modes_the_one_with_more_tower_is_called_after_it():
    purer, mixed = titles(flap=0.69, fore=0.25), titles(flap=0.43, fore=0.37)
    assert choose_names([purer, mixed]) == [FLAP, FORE]
    assert choose_names([mixed, purer]) == [FORE, FLAP]


def test_a_name_that_has_its_mode_is_not_given_to_another():
    tower = titles(fore=0.6, flap=0.3)
    assert choose_names([titles(flap=0.7, fore=0.29), titles(flap=0.7, fore=0.3), tower]) == [
        FLAP,
        f"{FLAP}, with fore-aft",
        FORE,
    ]


def test_small_shares_name_no_mode():
    assert choose_names([titles(flap=0.95, edge=0.05), titles(flap=0.9, fore=0.1)]) == [
        FLAP,
        f"{FLAP}, with fore-aft",
    ]


def test_of_equal_claims_the_slower_mode_has_the_name():
    mode = titles(flap=0.6, edge=0.1)
    first, *others = choose_names([mode, mode, mode])
    assert first == FLAP and sorted(others) == [f"{FLAP} (2)", f"{FLAP}, with edge"]


def test_what_nothing_else_tells_apart_is_numbered():
    free = [Title("free rotor", "", 1.0)]
    assert choose_names([free] * 3) == ["free rotor", "free rotor (2)", "free rotor (3)"]
    numbered = [Title("free rotor (2)", "", 1.0)]
    assert sorted(choose_names([free, numbered, free])) == [
        "free rotor",
        "free rotor (2)",
        "free rotor (3)",
    ]


TOWER = {"flexible": True, "elements": [4, 1, 4], "degree": 1}
SOLID = {"mesh": {"elements": [1, 1, 6]}, "tower": TOWER}


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """Coarse turbines on flexible towers, with solid and with hollow blades."""
    tables = small_turbine()
    body = tables["components"]["hub"]["elastic_properties"]
    tables["components"]["hub"]["elastic_properties"] = body | {
        "location": [0.0, 0.0, 0.0],
        "inertia": [3e4, 2e4, 2e4, 0.0, 0.0, 0.0],
    }
    file = write_turbine(tables, tmp_path_factory.mktemp("hollow"))
    hollow = {
        "turbine": {"file": str(file)},
        "mesh": {"span": 6, "around": 16, "tip": "open"},
        "tower": {"elements": [4, 1, 4]},
    }
    return {"solid": Case.parse(SOLID), "hollow": Case.parse(hollow)}


@pytest.mark.parametrize(("kind", "rpm"), [("solid", 0.0), ("solid", 14.0), ("hollow", 14.0)])
def test_modes_of_turbines_have_names_of_their_own(comm, cases, kind, rpm):
    pytest.importorskip("slepc4py")
    wanted = ModesWanted(count=16, speeds=(rpm * pi / 30.0,), locked=("yaw",))
    (table,), _ = find_modes(cases[kind], None, comm, wanted)
    found = {row.name: row.frequency for row in table.rows}
    assert len(found) == len(table.rows) == 16
    patterns = ("collective", "forward whirl", "backward whirl") if rpm else ("collective",)
    for pattern in patterns:  # a higher order is faster
        flaps = [found.get(f"{n} flap, {pattern}") for n in ("first", "second")]
        assert flaps[0] is not None, found
        assert flaps[1] is None or flaps[0] < flaps[1], found

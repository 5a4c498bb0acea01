"""Claims about the engine of case files, which knows no key: marks, checks, files."""

import os
from pathlib import Path
from typing import Annotated, Any

import pytest

from turbine_fenicsx.case.contradictions import check, find_contradictions, list_checks
from turbine_fenicsx.case.files import (
    DataFile,
    change_files,
    hash_files,
    list_files,
    make_absolute,
    place_files,
    read_if_changed,
)
from turbine_fenicsx.case.rules import (
    AnyOf,
    Beside,
    If,
    NotBeside,
    Only,
    Unless,
    With,
    find_unused_keys,
    remove_refused_keys,
)
from turbine_fenicsx.case.section import Section
from turbine_fenicsx.foundation.errors import InputError


class Spring(Section):
    """A table in a table."""

    rules = (Only("there", True),)

    there: bool = False
    """Whether there is one."""
    stiffness: float = 1.0
    """Its stiffness."""

    @check("stiffness")
    def _check_stiffness(self, case: Any) -> str:
        """A spring is stiff."""
        return "" if self.stiffness > 0.0 else "door.spring.stiffness: expected more than 0"


class Door(Section):
    """A table with all marks."""

    drive: str = "free"
    """Drive."""
    file: Annotated[str | None, DataFile("door file")] = None
    """A file."""
    plans: Annotated[tuple[str, ...], DataFile("plans")] = ()
    """Some files."""
    speed: Annotated[float, Only("drive", "motor", "hand"), Unless("power", 0.0)] = 0.0
    """Speed."""
    power: Annotated[float, Beside("file"), AnyOf(Only("drive", "motor"), With("file"))] = 0.0
    """Power."""
    noise: Annotated[float, AnyOf(Only("drive", "motor"), With("file", "house.file"))] = 0.0
    """Noise."""
    width: Annotated[float, NotBeside("house.file", "which has the doors")] = 1.0
    """Width."""
    colour: Annotated[str, If(lambda case: case.house.painted, say="in an unpainted house")] = ""
    """Colour."""
    spring: Spring = Spring()

    @check("width", "house.height", "spring")
    def _check_width(self, case: Any) -> str:
        """Doors are not wider than houses are high."""
        return "" if self.width <= case.house.height else "door.width: too wide"


class House(Section):
    """A table that is looked at."""

    height: float = 3.0
    """Height."""
    file: str | None = None
    """A file that is no data file."""
    painted: bool = False
    """Whether it is painted."""


class Village(Section):
    """All tables."""

    door: Door = Door()
    house: House = House()
    gate: dict[str, Door] = {}  # noqa: RUF012 - a default of pydantic
    """Doors by names of the user."""


def unused(**door):
    case = Village(**({"door": door} if "house" not in door else door))
    return {key.name: key.reason for key in find_unused_keys(case) if key.is_set}


@pytest.mark.parametrize(
    ("door", "reasons"),
    [
        ({"speed": 1.0, "drive": "hand", "power": 1.0}, {"door.power": 'with door.drive = "hand"'}),
        ({"speed": 1.0, "drive": "motor", "power": 1.0}, {}),
        ({"speed": 1.0, "drive": "motor"}, {"door.speed": "with door.power = 0"}),
        (
            {"speed": 1.0, "power": 1.0, "file": "f"},
            {"door.speed": 'with door.drive = "free"', "door.power": "beside door.file"},
        ),
        ({"power": 1.0}, {"door.power": 'with door.drive = "free"'}),
        ({"noise": 1.0}, {"door.noise": 'with door.drive = "free"'}),
        ({"noise": 1.0, "drive": "motor"}, {}),
        ({"noise": 1.0, "file": "f"}, {}),
        ({"colour": "red"}, {"door.colour": "in an unpainted house"}),
        ({"house": {"painted": True}, "door": {"colour": "red"}}, {}),
        ({"house": {"file": "h"}, "door": {"width": 1.0}}, {"door.width": "beside house.file"}),
        (
            {"spring": {"stiffness": 2.0}},
            {"door.spring.stiffness": "without door.spring.there = true"},
        ),
        ({"spring": {"there": False}}, {}),
        (
            {"house": {}, "gate": {"north": {"speed": 1.0, "power": 1.0, "drive": "hand"}}},
            {"gate.north.power": 'with gate.north.drive = "hand"'},
        ),
    ],
)
def test_keys_that_do_not_count_are_found_with_the_reason(door, reasons):
    assert unused(**door) == reasons


def contradictions(wrong=(), **tables):
    case = Village(**tables)
    return [m.sentence for m in find_contradictions(case, list_checks(case), set(wrong))]


def test_keys_that_exclude_each_other_are_a_mistake():
    house = {"file": "/a/plan.txt"}
    assert contradictions(house=house, door={"drive": "hand"}) == []
    assert contradictions(house=house, door={"width": 2.0}) == [
        "door.width = 2.0: expected none beside house.file = 'plan.txt', which has the doors"
    ]
    case = Village(house=house)
    assert "width" not in remove_refused_keys(case, case.model_dump())["door"]
    assert "width" in remove_refused_keys(Village(), Village().model_dump())["door"]


def test_checks_of_all_tables_are_found_also_of_those_with_names_of_the_user():
    assert contradictions(door={"width": 9.0}) == ["door.width: too wide"]
    assert contradictions(door={"spring": {"stiffness": 0.0}}) == [
        "door.spring.stiffness: expected more than 0"
    ]
    assert contradictions(gate={"a": {"width": 9.0}, "b": {"width": 9.0}}) == 2 * [
        "door.width: too wide"
    ]


@pytest.mark.parametrize(
    "wrong", [("door", "width"), ("door",), ("house", "height"), ("door", "spring", "there")]
)
def test_nothing_is_said_that_depends_on_what_is_wrong_by_itself(wrong):
    assert contradictions(door={"width": 9.0}) != []
    assert contradictions([wrong], door={"width": 9.0}) == []


def test_a_mistake_hides_those_that_depend_on_its_key():
    door = {"width": 9.0, "spring": {"stiffness": 0.0}}
    assert contradictions(door=door) == [
        "door.width: too wide",
        "door.spring.stiffness: expected more than 0",
    ]
    assert contradictions(house={"file": "h"}, door={"width": 9.0}) == [
        "door.width = 9.0: expected none beside house.file = 'h', which has the doors"
    ]


# --- files


def test_one_mark_places_lists_and_hashes_files(tmp_path, monkeypatch):
    data = {
        "door": {"file": "a", "plans": ["b", "c", 3], "drive": "d"},
        "house": {"file": "e"},
        "gate": {"north": {"file": "f"}, "south": 4},
        "unknown": {"file": "g"},
    }
    names = [name for _, name in list_files(data, Village)]
    assert names == ["a", "b", "c", "f"]
    placed = place_files(data, Village, "sub")
    assert placed["door"] == {"file": "sub/a", "plans": ["sub/b", "sub/c", 3], "drive": "d"}
    assert placed["gate"] == {"north": {"file": "sub/f"}, "south": 4}
    assert (placed["house"], placed["unknown"]) == (data["house"], data["unknown"])
    assert data["door"]["file"] == "a"  # not changed in place
    monkeypatch.chdir(tmp_path)
    assert make_absolute(data, Village)["door"]["file"] == str(tmp_path / "a")
    for name in "abc":
        Path(name).write_text(name)
    hashes = hash_files(data, Village)
    assert set(hashes) == {"door file", "plans"}
    assert hashes["door file"].endswith(" missing (f)")
    Path("c").write_text("other")
    changed = hash_files(data, Village)
    assert changed["plans"] != hashes["plans"] and changed["door file"] == hashes["door file"]


@pytest.mark.parametrize("data", [{"door": 3}, {"door": {"file": 3}}, {"gate": [1]}, {"door": []}])
def test_values_of_other_kinds_are_left_to_later_checks(data):
    assert change_files(data, Village, lambda mark, name: "x") == data


def test_a_file_is_read_again_only_if_it_has_changed(tmp_path):
    count = []

    @read_if_changed("list", size=2)
    def read(paths, times=1):
        """Reads."""
        count.append(paths)
        names = (paths,) if isinstance(paths, str) else paths
        return times * [Path(name).read_text() for name in names]

    a, b = str(tmp_path / "a"), str(tmp_path / "b")
    Path(a).write_text("one")
    Path(b).write_text("two")
    assert read(a) is read(a)
    assert read((a, b)) == ["one", "two"]
    assert read(a, 2) == ["one", "one"]
    assert len(count) == 3
    Path(a).write_text("changed")
    assert read(a) == ["changed"]
    assert read((a, b)) == ["changed", "two"]
    Path(b).unlink()
    with pytest.raises(InputError, match=r"cannot read the list '.*b': No such file"):
        read((a, b))
    with pytest.raises(InputError, match="cannot read the list"):
        read("\0")
    status = os.stat(a)
    Path(a).write_text("CHANGED")
    os.utime(a, ns=(status.st_atime_ns, status.st_mtime_ns + 1))
    assert read(a) == ["CHANGED"]

"""Names in the output: written in one file, found as they are written."""

import ast
from pathlib import Path

import pytest

import turbine_fenicsx
from turbine_fenicsx.records import names
from turbine_fenicsx.records.names import Family, split_unit

PACKAGE = Path(turbine_fenicsx.__file__).parent
LISTED = [value for value in vars(names).values() if isinstance(value, str | Family)]
PATTERNS = [x if isinstance(x, str) else x.pattern for x in LISTED]
FULL = [text for text in PATTERNS if "_[" in text]
STARTS = {text.partition("{")[0] for text in FULL if "{" in text} - {""}


def test_a_family_finds_what_it_names():
    columns = [names.ROOT_MOMENT(blade=k, axis=a) for k in (1, 2) for a in "xyz"]
    assert columns[:2] == ["root_moment_1_x_[Nm]", "root_moment_1_y_[Nm]"]
    others = [names.ROOT_FORCE(blade=1, axis="y"), "root_moment_1_y_[kNm]", names.TIME]
    found = names.ROOT_MOMENT.find([*others, *columns], axis="y")
    assert found == {"1": "root_moment_1_y_[Nm]", "2": "root_moment_2_y_[Nm]"}


def test_a_joint_may_be_called_anything():
    columns = [names.ANGLE(joint=name) for name in ("yaw", "a_b", "slide.angle", "x(1)+")]
    assert list(names.ANGLE.find(columns)) == ["yaw", "a_b", "slide.angle", "x(1)+"]
    assert list(names.JOINT_FORCE.find(["joint_force_x(1)+_2_[N]"], joint="x(1)+")) == ["2"]


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        (names.TOTAL_ENERGY, ("total_energy", "J")),
        ("angles_[rad].yaw", ("angles.yaw", "rad")),
        ("largest energy [MJ]", ("largest energy", "MJ")),
        (names.NEWTON_ITERATIONS, ("newton_iterations", "")),
    ],
)
def test_units_are_told_from_names(name, parts):
    assert split_unit(name) == parts


def texts_in(path):
    """All texts of a file, except its docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    plain = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in plain:
            yield node.value


def test_no_other_file_writes_the_name_of_a_column():
    assert len(FULL) > 30
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.name == "names.py":
            continue
        for text in texts_in(path):
            assert text not in (*FULL, *STARTS), f"{path.relative_to(PACKAGE)}: {text!r}"

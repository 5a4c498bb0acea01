"""The public names: imported on first use, yet with their types known to mypy and editors."""

import ast
from pathlib import Path

import turbine_fenicsx


def names_with_types():
    """Public names that type checkers see, with the modules that they come from."""
    tree = ast.parse(Path(turbine_fenicsx.__file__).read_text(encoding="utf-8"))
    [block] = [
        node
        for node in tree.body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    ]
    names = {}
    for node in block.body:
        assert isinstance(node, ast.ImportFrom)
        for alias in node.names:
            assert alias.asname == alias.name, "without 'as', mypy strict does not see it as public"
            names[alias.name] = node.module
    return names


def test_type_checkers_see_the_names_that_users_import():
    lazy = {name: f"turbine_fenicsx.{module}" for name, module in turbine_fenicsx._PUBLIC.items()}
    assert names_with_types() == lazy


def test_every_public_name_can_be_imported():
    for name in turbine_fenicsx.__all__:
        assert getattr(turbine_fenicsx, name) is not None

"""The notebook for teaching: all of its code runs, in order."""

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "demos").rglob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_cells_of_a_notebook_run(path, capsys):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names = {"__name__": "notebook"}
    for k, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "clear the outputs of the notebook"
            exec(compile("".join(cell["source"]), f"{path.name}, cell {k}", "exec"), names)
    assert "difference of the coordinates: " in capsys.readouterr().out
    assert len(cells) > 5

"""The notebook for teaching: all of its code runs, in order."""

import json
from pathlib import Path

NOTEBOOK = Path(__file__).parents[1] / "demos" / "teaching" / "pendulum.ipynb"


def test_the_cells_of_the_notebook_run(capsys):
    """They assert what they claim; the last one compares the hand-made steps with the library."""
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    names = {"__name__": "notebook"}
    for k, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "clear the outputs of the notebook"
            exec(compile("".join(cell["source"]), f"{NOTEBOOK.name}, cell {k}", "exec"), names)
    assert "difference of the coordinates: " in capsys.readouterr().out

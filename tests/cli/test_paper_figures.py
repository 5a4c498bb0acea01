"""The figures of the paper: one command draws them, and one page shows and explains them all."""

import importlib.util
import re
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
NUMBERS = range(7, 22)
NAMES = [f"fig{number:02d}.png" for number in NUMBERS]
SHORT = ("--set", "time.end=0.1", "output.fields_every=0.02", "loads.duration=0.06")
TIMES = ("--times", "0", "0.04", "0.06", "0.1")

needs_pictures = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("matplotlib", "pyvista")),
    reason="Matplotlib or PyVista, which draw, is missing",
)


@pytest.fixture
def figures(command_line):
    """Runs the command as a user would."""
    program = [sys.executable, str(ROOT / "demos" / "paper" / "figures.py")]
    return lambda *arguments: command_line(*arguments, program=program, timeout=300.0)


@pytest.mark.slow
@needs_pictures
def test_one_command_runs_the_cases_and_draws_all_figures(figures, tmp_path):
    from PIL import Image

    runs, out = tmp_path / "runs", tmp_path / "figures"
    result = figures("-o", out, "--runs", runs, *SHORT, *TIMES)
    assert result.returncode == 0, result.stderr
    assert sorted(path.name for path in out.iterdir()) == NAMES
    assert {str(out / name) for name in NAMES} <= set(result.stdout.splitlines())
    for name in NAMES:  # more than an empty sheet
        assert np.asarray(Image.open(out / name).convert("L")).std() > 5.0, name
    # what was run is there for the next time, and taken then
    before = {path: path.stat().st_mtime_ns for path in runs.rglob("history.csv")}
    assert [path.parent.name for path in sorted(before)] == ["hybrid_soft", "hybrid_stiff", "rigid"]
    late = figures("-o", out, "--runs", runs, "--times", "0", "0.04", "0.06", "12")
    assert (late.returncode, late.stdout, late.stderr.count("\n")) == (2, "", 1)
    assert "error: t = 12 s is outside of the run" in late.stderr
    assert before == {path: path.stat().st_mtime_ns for path in runs.rglob("history.csv")}
    twice = figures("-o", out, "--runs", runs, "--times", "0", "0.04", "0.041", "0.1")
    assert twice.returncode == 2
    assert "are nearest to the same output of " in twice.stderr


def test_a_case_that_cannot_be_run_ends_the_command_with_its_sentence(figures, tmp_path):
    result = figures("-o", tmp_path, "--set", "time.ends=1")
    assert result.returncode == 2
    assert result.stderr == "error: unknown key 'time.ends'; did you mean 'time.end'?\n"


def test_a_folder_that_cannot_be_written_is_refused_before_anything_runs(figures, tmp_path):
    (tmp_path / "file").write_text("")
    result = figures("-o", tmp_path / "file" / "figures")
    assert result.returncode == 2
    assert result.stderr.startswith("error: cannot write to ")
    assert result.stdout == ""


def test_the_page_shows_and_explains_every_figure():
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    shown = re.findall(
        r"^!\[[^\]]+\]\((images/paper/fig\d\d\.png)\)\n\n(\w.*)$", page, re.MULTILINE
    )
    assert [path for path, _ in shown] == [f"images/paper/{name}" for name in NAMES]
    for path, text in shown:
        assert (ROOT / "docs" / path).stat().st_size > 5000
        number = int(path[-6:-4])
        assert f"### Figure {number}: " in page
        assert len(text) > 40, path

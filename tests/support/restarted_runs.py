"""Runs of the command line that go on, and what is in their folders, for tests."""

import json

import numpy as np
from histories import read_lines
from outputs import read_fields

from turbine_fenicsx.cli.main import main

SOFT = ("mesh.elements=[1,1,4]", "output.fields_every=0.04")
"""The hybrid turbine with soft blades, small; it takes some six iterations per step."""
RESULTS = (
    "steps",
    "halved_steps",
    "end_time_[s]",
    "worst_energy_error_[J]",
    "largest_energy_[J]",
    "worst_constraint_error_[-]",
    "angular_momentum_[Nms]",
    "angles_[rad]",
    "mean_newton_iterations",
    "mean_krylov_iterations",
)


def summary(folder):
    """What ``summary.json`` says about the result."""
    tables = json.loads((folder / "summary.json").read_text())
    return {name: tables[name] for name in RESULTS}


def assert_same(folder, whole):
    """All results are the same bit for bit, except wall times."""
    assert (folder / "history.csv").read_text().endswith("\n")
    assert read_lines(folder) == read_lines(whole)
    assert (folder / "history.out").read_text() == (whole / "history.out").read_text()
    assert summary(folder) == summary(whole)
    assert (folder / "fields.xdmf").exists() == (whole / "fields.xdmf").exists()
    if (whole / "fields.xdmf").exists():
        mine, theirs = read_fields(folder / "fields.xdmf"), read_fields(whole / "fields.xdmf")
        assert list(mine) == list(theirs)
        for time, arrays in theirs.items():
            assert mine[time].keys() == arrays.keys()
            assert "Geometry" in arrays and "velocity" in arrays
            for name, values in arrays.items():
                assert np.array_equal(mine[time][name], values), (time, name)


def run(demo, name, out, *changes, flags=()):
    """Run a demo; it must succeed and print nothing."""
    command = ["run", str(demo(f"{name}.toml")), "-o", str(out), "--quiet", *flags]
    assert main([*command, "--set", *changes]) == 0


def restart(out, *changes, code=0):
    """Go on with a run."""
    settings = ["--set", *changes] if changes else []
    assert main(["restart", str(out), "--quiet", *settings]) == code


def content(folder):
    """All files of a folder but the log, by name."""
    paths = (p for p in sorted(folder.rglob("*")) if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in paths if p.name != "run.log"}

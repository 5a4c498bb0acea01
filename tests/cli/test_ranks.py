"""The number of MPI ranks does not change the results."""

import csv
import json
import os

import numpy as np
import pytest

# Columns are compared on one scale for all of a kind, since a component may vanish: a balanced
# turbine has no momentum along e3, for instance.
KINDS = ("energy_[", "work_[", "linear_momentum", "angular_momentum", "angle_", "tip_", "stress")
# They depend on the machine, or are round-off themselves.
NOT_COMPARED = (
    "energy_error_[J]",
    "constraint_error_[-]",
    "newton_iterations",
    "krylov_iterations",
    "wall_time_[s]",
)


def history(folder):
    """Columns of ``history.csv`` by name."""
    with (folder / "history.csv").open(newline="") as file:
        header, *values = csv.reader(file)
    return dict(zip(header, np.array(values, dtype=float).T, strict=True))


@pytest.mark.parametrize("name", ["rigid", "hybrid_stiff", "hybrid_soft"])
def test_ranks_agree(command_line, demo, tmp_path, name):
    found = {}
    for ranks in (1, 2, 3):
        out = tmp_path / str(ranks)
        result = command_line(
            "run",
            demo(f"{name}.toml"),
            *("-o", out, "--progress", "none"),
            *("--set", "time.end=0.2", "output.fields_every=0.1"),
            ranks=ranks,
        )
        assert result.returncode == 0, result.stderr
        found[ranks] = history(out)
        summary = json.loads((out / "summary.json").read_text())
        assert summary["ranks"] == ranks  # not three times one rank
    reference = found[1]
    assert len(reference["time_[s]"]) == 11
    for ranks in (2, 3):
        assert found[ranks].keys() == reference.keys()
        assert np.array_equal(found[ranks]["time_[s]"], reference["time_[s]"])
        for kind in KINDS:
            columns = [c for c in reference if kind in c and c not in NOT_COMPARED]
            if not columns:
                continue
            scale = max(np.max(np.abs(reference[c])) for c in columns)
            for c in columns:
                # the bound; measured 1e-14 to 1e-11
                difference = np.max(np.abs(found[ranks][c] - reference[c]))
                assert difference <= 1e-9 * scale, (ranks, c)
    sizes = {os.path.getsize(tmp_path / str(ranks) / "fields.bin") for ranks in (1, 2, 3)}
    assert len(sizes) == 1  # every cell and point is written once

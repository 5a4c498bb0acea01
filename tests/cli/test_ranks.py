"""The number of MPI ranks does not change the results."""

import json
import os
import sys

import numpy as np
import pytest
from histories import read_columns

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


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("hybrid_stiff", (1, 2)),
        pytest.param("hybrid_soft", (1, 2, 3), marks=pytest.mark.slow),
        pytest.param("rigid", (1, 2, 3), marks=pytest.mark.slow),
    ],
)
def test_ranks_agree(command_line, demo, tmp_path, name, numbers):
    found = {}
    for ranks in numbers:
        out = tmp_path / str(ranks)
        result = command_line(
            "run",
            demo(f"{name}.toml"),
            *("-o", out, "--progress", "none"),
            *("--set", "time.end=0.2", "output.fields_every=0.1"),
            ranks=ranks,
        )
        assert result.returncode == 0, result.stderr
        found[ranks] = read_columns(out)
        summary = json.loads((out / "summary.json").read_text())
        assert summary["ranks"] == ranks  # not one rank each time
    reference = found[1]
    assert len(reference["time_[s]"]) == 11
    for ranks in numbers[1:]:
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
    sizes = {os.path.getsize(tmp_path / str(ranks) / "fields.bin") for ranks in numbers}
    assert len(sizes) == 1  # every cell and point is written once


STOP = """
import sys
from mpi4py import MPI
from turbine_fenicsx.simulation.checkpoint import Checkpoints
from turbine_fenicsx import MultibodySystem, Revolute, RigidBody, Simulation

comm, (folder, asked) = MPI.COMM_WORLD, sys.argv[1:]
top = RigidBody("top", 1.0, (1.0, 1.0, 1.0), angular_velocity=(0.0, 0.0, 1.0))
axis = Revolute("axis", None, top, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
system = MultibodySystem(comm, [top, axis])
checkpoints = Checkpoints(system, folder, every=0.04)
due = checkpoints.due
# the clocks of ranks differ: that of rank 0 decides on checkpoints
checkpoints.due = lambda time, wall: due(time, wall) if comm.rank == 0 else time == 0.02
calls = []
stop = lambda: calls.append(1) or (comm.rank == int(asked) and len(calls) == 3)
simulation = Simulation(system, 0.02, 0.2, checkpoints=checkpoints, stop=stop)
last = simulation.run()
found = comm.gather((last.index, simulation.stopped))
if comm.rank == 0:
    print(found)
"""


@pytest.mark.parametrize("asked", [0, 1])
def test_one_rank_is_enough_to_stop_all_after_the_same_step(command_line, tmp_path, asked):
    script = tmp_path / "stop.py"
    script.write_text(STOP)
    result = command_line(
        script, tmp_path / "checkpoints", asked, ranks=2, timeout=60.0, program=[sys.executable]
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[(3, True), (3, True)]"
    kept = sorted(path.name for path in (tmp_path / "checkpoints").iterdir())
    assert [int("".join(c for c in name if c.isdigit())) for name in kept] == [2, 3]

"""The public names: imported on first use, yet with their types known to mypy and editors."""

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

from mpi4py import MPI

import pytest

import turbine_fenicsx

SCRIPT = Path(__file__).parent / "typed_user_script.py"
alone = pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="starts processes, from one rank")


def test_type_checkers_see_the_names_that_users_import():
    """Without 'as', mypy strict does not see a name as public."""
    stub = Path(turbine_fenicsx.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    aliases = [n for node in ast.parse(stub).body for n in getattr(node, "names", ())]
    assert all(alias.asname == alias.name for alias in aliases)
    assert sorted(alias.name for alias in aliases) == sorted(turbine_fenicsx._PUBLIC)


def test_every_public_name_can_be_imported():
    for name in turbine_fenicsx.__all__:
        assert getattr(turbine_fenicsx, name) is not None


def test_no_two_vectors_are_given_by_position():
    """Swapped ones would run without a word."""
    for name in turbine_fenicsx.__all__:
        public = getattr(turbine_fenicsx, name)
        for make in (public, getattr(public, "from_inertia", None)):
            if callable(make) and not name.endswith(("Error", "Failure", "Warning")):
                given = inspect.signature(make).parameters.values()
                vectors = [p.name for p in given if p.annotation == "npt.ArrayLike"]
                by_position = [p.name for p in given if p.kind is not p.KEYWORD_ONLY]
                assert len({*vectors} & {*by_position}) < 2, name


def test_the_typed_script_knows_every_public_name():
    used = set(re.findall(r"\btfx\.(\w+)", SCRIPT.read_text(encoding="utf-8")))
    assert set(turbine_fenicsx.__all__) - used == set()


WRONG = """import turbine_fenicsx as tfx

body = tfx.RigidBody("body", 1.0, (1.0, 1.0, 1.0))
tfx.Revolut("hinge", None, body, point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
tfx.Revolute("hinge", None, body, point=(0.0, 0.0, 0.0))
tfx.Revolute("hinge", None, "body", point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
tfx.Case.parse({}).time.end.upper()
tfx.JointSpring("spring", "hinge", stiffness="stiff")
tfx.PointForce("push", body, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
"""


@alone
def test_mypy_knows_the_type_of_every_public_name_and_finds_mistakes(tmp_path):
    pytest.importorskip("mypy")
    wrong = tmp_path / "wrong.py"
    wrong.write_text(WRONG, encoding="utf-8")
    options = ["--config-file=", "--strict", "--ignore-missing-imports", "--follow-imports=silent"]
    # newer releases of DOLFINx have generic types and untyped functions, which are not ours
    options += ["--allow-untyped-calls", "--allow-any-generics"]
    command = [sys.executable, "-m", "mypy", *options, f"--cache-dir={tmp_path}", SCRIPT, wrong]
    done = subprocess.run(command, capture_output=True, text=True, cwd=SCRIPT.parents[1])
    found = [re.match(r"(.*):(\d+): error", line) for line in done.stdout.splitlines()]
    places = [(Path(m[1]).name, int(m[2])) for m in found if m]
    assert places == [("wrong.py", line) for line in range(4, 10)], done.stdout + done.stderr


@alone
def test_the_typed_script_runs(tmp_path):
    done = subprocess.run(
        [sys.executable, SCRIPT, tmp_path], capture_output=True, text=True, cwd=SCRIPT.parents[1]
    )
    assert done.returncode == 0, done.stderr
    error = float(done.stdout.splitlines()[-1])
    assert abs(error) < 1e-9  # of some 0.1 J

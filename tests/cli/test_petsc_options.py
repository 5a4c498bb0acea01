"""PETSc gets the options it is given, and none from files that happen to lie about."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
TABLE = "#PETSc Option Table entries"


def test_files_with_options_are_read_only_when_asked_for(demo, tmp_path):
    """They could load a library."""
    for folder in ("here", "home"):
        (tmp_path / folder).mkdir()
    for file in ("here/.petscrc", "here/petscrc", "home/.petscrc"):
        (tmp_path / file).write_text("-options_view\n")
    environment = {**os.environ, "HOME": str(tmp_path / "home"), "PYTHONPATH": str(ROOT)}

    def check(*petsc_options):
        command = [sys.executable, "-m", "turbine_fenicsx", "check", str(demo("rigid.toml"))]
        return subprocess.run(
            [*command, *petsc_options],
            env=environment,
            cwd=tmp_path / "here",
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
        ).stdout

    assert TABLE not in check()
    assert TABLE in check("--", "-options_file", ".petscrc")


def test_a_file_with_options_that_is_not_there_is_one_sentence(command_line, demo):
    result = command_line("check", demo("rigid.toml"), "--", "-options_file", "none.petscrc")
    assert result.returncode == 2
    (sentence,) = (line for line in result.stderr.splitlines() if "error: " in line)
    assert "PETSc does not start with the options '-options_file none.petscrc" in sentence
    assert "Traceback" not in result.stderr

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

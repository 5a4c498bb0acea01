"""What pip installs, and what the package needs before anything else."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

from mpi4py import MPI

import pytest

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="needs no more than one rank")


def python(*arguments, **variables):
    """Run this python in a fresh process and return what it prints."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "PMI"))}
    result = subprocess.run(
        [sys.executable, *map(str, arguments)],
        env=environment | variables,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_dolfinx_from_pypi_is_asked_before_petsc4py_is_imported(tmp_path):
    """Else its petsc4py finds no MPI: "libmpi.so.12: cannot open shared object file"."""
    (tmp_path / "dolfinx_solver.py").write_text(
        "import sys\nprint('petsc4py.PETSc' in sys.modules, 'numpy' in sys.modules)\n"
    )
    path = os.pathsep.join([str(tmp_path), str(ROOT), os.environ.get("PYTHONPATH", "")])
    # these import petsc4py and nothing of mpi4py before; numpy must wait for its number of threads
    for module in ("_compat", "state", "cli"):
        said = python("-c", f"import turbine_fenicsx.{module}", PYTHONPATH=path)
        assert said == "False False\n"


def test_making_a_wheel_leaves_nothing_in_the_source(tmp_path):
    source = tmp_path / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "turbine_fenicsx", "demos"):
        subprocess.run(["cp", "-r", ROOT / name, source], check=True)
    before = sorted(source.rglob("*"))
    python(
        *("-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index", "-q"),
        *("-w", tmp_path, source),
    )
    assert sorted(source.rglob("*")) == before
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"turbine_fenicsx/py.typed", "turbine_fenicsx/report.html"} <= set(names)

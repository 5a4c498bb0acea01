"""What pip installs, and what the package needs before anything else."""

import email
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

from mpi4py import MPI

import pytest
import yaml

from turbine_fenicsx import __version__

ROOT = Path(__file__).parents[3]
LICENCES = ("COPYING", "COPYING.LESSER", "LICENSE")
LICENCE = "LGPL-3.0-or-later"

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


FIRST = """
import importlib, os, sys
print('petsc4py.PETSc' in sys.modules, 'numpy' in sys.modules)
sys.path.remove(os.path.dirname(__file__))
mine = sys.modules.pop(__name__)
try:
    importlib.import_module(__name__)  # the real one, where it is installed
except ModuleNotFoundError:
    sys.modules[__name__] = mine
"""


def test_dolfinx_from_pypi_is_asked_before_petsc4py_is_imported(tmp_path):
    """Else its petsc4py finds no MPI: "libmpi.so.12: cannot open shared object file"."""
    (tmp_path / "dolfinx_solver.py").write_text(FIRST)
    path = os.pathsep.join([str(tmp_path), str(ROOT), os.environ.get("PYTHONPATH", "")])
    # these import petsc4py and nothing of mpi4py before; numpy must wait for its number of threads
    for module in ("_compat", "system.state", "cli.main"):
        said = python("-c", f"import turbine_fenicsx.{module}", PYTHONPATH=path)
        assert said == "False False\n"


def test_making_a_wheel_leaves_nothing_in_the_source(tmp_path):
    source = tmp_path / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", *LICENCES, "turbine_fenicsx", "demos"):
        subprocess.run(["cp", "-r", ROOT / name, source], check=True)
    before = sorted(source.rglob("*"))
    python(
        *("-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index", "-q"),
        *("-w", tmp_path, source),
    )
    assert sorted(source.rglob("*")) == before
    (wheel,) = tmp_path.glob("*.whl")
    held = zipfile.ZipFile(wheel)
    assert {"turbine_fenicsx/py.typed", "turbine_fenicsx/postprocessing/report.html"} <= set(
        held.namelist()
    )
    for folder in ("paper", "turbine"):  # the cases themselves, not the links to them
        for case in (ROOT / "demos" / folder).glob("*.toml"):
            assert held.read(f"turbine_fenicsx/demos/{case.name}") == case.read_bytes()
    (metadata,) = (name for name in held.namelist() if name.endswith(".dist-info/METADATA"))
    said = email.message_from_bytes(held.read(metadata))
    assert (said["Version"], said["License-Expression"]) == (__version__, LICENCE)
    assert sorted(said.get_all("License-File")) == sorted(LICENCES)
    for name in LICENCES:
        assert (
            held.read(metadata.replace("METADATA", f"licenses/{name}"))
            == (ROOT / name).read_bytes()
        )


def test_a_source_archive_has_the_cases_that_the_package_links_to(tmp_path):
    build = f"import os; os.chdir({str(ROOT)!r}); from flit_core.buildapi import build_sdist as b"
    archive = python("-c", f"{build}; print(b({str(tmp_path)!r}), end='')")
    subprocess.run(["tar", "xzf", archive], cwd=tmp_path, check=True)
    (source,) = (p for p in tmp_path.iterdir() if p.is_dir())
    links = list((source / "turbine_fenicsx" / "demos").glob("*.toml"))
    assert links and all(link.is_file() for link in links)


def test_version_and_licence_are_the_same_wherever_they_stand():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    (newest, state), *_ = re.findall(r"^## (\S+) \((\S+)\)", changes, re.M)
    assert __version__ == (f"{newest}.dev0" if state == "unreleased" else newest)
    released = re.search(r"^## (\S+) \((\d{4}-\d\d-\d\d)\)", changes, re.M)
    assert (cited["version"], str(cited["date-released"])) == released.groups()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert cited["license"] == project["license"] == LICENCE
    assert LICENCE in (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_citation_holds_what_the_format_asks_for_and_the_paper():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(cited)
    (paper,) = cited["references"]
    assert [author["family-names"] for author in paper["authors"]] == [
        *("Anders", "Uhlar", "Krüger", "Groß", "Weinberg")
    ]
    assert (paper["journal"], paper["volume"], paper["issue"], paper["year"]) == (
        *("Engineering Computations", 29, 7),
        2012,
    )
    assert f"*{paper['title']}*" in (ROOT / "docs" / "index.md").read_text().replace("\n", " ")


@pytest.fixture
def without_dolfinx(tmp_path):
    """Runs the command line of a python that has neither petsc4py nor mpi4py nor DOLFINx."""
    for name in ("petsc4py", "mpi4py", "dolfinx"):
        reason = f"No module named {name!r}"
        (tmp_path / f"{name}.py").write_text(f"raise ModuleNotFoundError({reason!r})\n")

    def run(*arguments):
        path = os.pathsep.join([str(tmp_path), str(ROOT)])
        command = [sys.executable, "-m", "turbine_fenicsx", *arguments]
        environment = os.environ | {"PYTHONPATH": path}
        return subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True
        )

    return run


def test_a_python_without_dolfinx_is_told_how_to_get_it(without_dolfinx):
    for arguments in (["run", "a.toml", "-o", "a"], ["check", "a.toml"], ["plot", "a"]):
        result = without_dolfinx(*arguments)
        assert result.returncode == 2
        assert result.stderr.startswith(f"error: DOLFINx cannot be used by {sys.executable} (")
        assert "No module named 'petsc4py'" in result.stderr
        assert "pip install dolfinx-solver-real`" in result.stderr
        assert "`make setup`" in result.stderr
        assert result.stderr.count("\n") == 1


def test_info_demo_and_help_need_no_dolfinx(without_dolfinx):
    info = without_dolfinx("info")
    assert info.returncode == 0, info.stderr
    assert "numpy" in info.stdout and "pip install dolfinx-solver-real`" in info.stdout
    assert without_dolfinx("demo", "rigid").returncode == 0
    for arguments in (["--help"], ["run", "--help"]):
        result = without_dolfinx(*arguments)
        assert result.returncode == 0, result.stderr
        assert result.stdout.startswith("usage: turbine-fenicsx")


def test_info_says_whose_dolfinx_runs(command_line_info):
    folder = command_line_info["dolfinx"]
    expected = "PyPI" if "dolfinx-solver-real" in command_line_info else "Debian"
    if expected == "Debian" and "/usr/lib" not in folder:
        pytest.skip("another installation, which may be anything")
    assert command_line_info["stack"] == expected


@pytest.fixture
def command_line_info():
    """What the command ``info`` prints."""
    lines = python("-m", "turbine_fenicsx", "info").splitlines()
    return dict(line.split(maxsplit=1) for line in lines)

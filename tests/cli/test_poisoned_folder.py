"""No command runs Python files of the folder it is started in, nor do the processes it starts."""

import importlib.util
import pkgutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from beam_turbines import write_beam_case
from patience import patience
from reduced_turbines import STRENGTHS, write_case
from reduced_turbines import run as run_reduced

from turbine_fenicsx.cli import commands

ROOT = Path(__file__).parents[2]
RIGID = ROOT / "demos" / "paper" / "rigid.toml"
HYBRID = ROOT / "demos" / "paper" / "hybrid_soft.toml"
POISON = "from pathlib import Path\n(Path({folder!r}) / 'RUN_{name}').touch()\nraise ImportError\n"
IMPORTED = (
    "PIL",
    "ctypes",
    "cffi",
    "dolfinx",
    "gmsh",
    "json",
    "logging",
    "matplotlib",
    "mpi4py",
    "numpy",
    "petsc4py",
    "pydantic",
    "pyvista",
    "scipy",
    "struct",
    "tomllib",
    "turbine_fenicsx",
    "yaml",
)
"""Names that the package or its child processes import."""

STEADY = RIGID.parents[1] / "iea15" / "iea15_rigid.toml"
SHORT = ["--quiet", "--set", "time.end=0.02", "time.step=0.01", "output.fields_every=0.01"]
FEW = ["mesh.elements=[1,1,4]", "blade.reduction.modes=1", "blade.reduction.functions=6"]
ROWS = ["time.end=1.5", "output.motion_every=0.05"]
MADE = ["--set", "wind.turbulence={model = 'kaimal', folder = '.', duration = 8, points = 3}"]
KICK = [
    *("--wind", "9", "--mode", "1", "--count", "3", "--cycles", "0.5", "-o", "damping", "--set"),
    *("turbine.hub.centre=[0, 0, 0]", "turbine.hub.inertia=[900, 900, 1500, 0, 0, 0]"),
    *("tower.flexible=false", "yaw.drive=lock"),
]
ARGUMENTS = {
    "check": [str(HYBRID)],
    "damping": ["beams/case.toml", *KICK],
    "demo": [],
    "dlc": ["set.toml", "--list"],
    "fatigue": ["out", "--columns", "angle_rotor_[rad]"],
    "info": [],
    "keys": ["tower"],
    "life": ["reduced/run", "--no-pictures", "--quiet", "--set", *STRENGTHS],
    "mesh": [str(HYBRID), "-o", "new.msh", "--set", "mesh.elements=[1,1,4]"],
    "modes": [str(RIGID), "-o", "modes"],
    "plot": ["out"],
    "recover": ["reduced/run", "--quiet"],
    "reduce": [str(HYBRID), "-o", "basis.npz", "--quiet", "--set", *FEW],
    "render": ["out", "--size", "200x200"],
    "report": ["out", "--no-pictures"],
    "restart": ["out", "--quiet", "--set", "time.end=0.03"],
    "run": [str(RIGID), "-o", "other", *SHORT],
    "sections": [str(STEADY), "-o", "sections", "--stations", "6", "--around", "24", "--quiet"],
    "steady": [str(STEADY), "--wind", "8", "-o", "steady", "--quiet"],
    "study": ["study.toml", "-o", "study"],
    "wind": [str(STEADY), "-o", "new.bts", *MADE],
}


def start(folder, *arguments):
    """The command line in a folder, as the installed program starts it."""
    return subprocess.run(
        [sys.executable, "-P", "-m", "turbine_fenicsx", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=patience(120.0),
    )


@pytest.fixture(scope="module")
def poisoned(tmp_path_factory):
    """A folder with the output of a run, a study, and files that leave a mark when they are run."""
    folder = tmp_path_factory.mktemp("poisoned")
    for name in IMPORTED:
        text = POISON.format(folder=str(folder), name=name)
        (folder / f"{name}.py").write_text(text)
    (folder / "study.toml").write_text(
        f"case = '{RIGID}'\n[grid]\ntime.step = [0.01, 0.02]\n"
        "[set]\ntime.end = 0.02\noutput.fields_every = 0\n"
    )
    (folder / "set.toml").write_text(
        f"case = '{STEADY}'\nsituations = ['own']\n"
        "situation = {own = {winds = [8], start = 'given', duration = 1, transient = 0}}"
    )
    result = start(folder, "run", str(RIGID), "-o", "out", *SHORT)
    assert result.returncode == 0, result.stderr
    return folder


def test_the_files_would_be_run_where_the_folder_comes_first(poisoned):
    result = subprocess.run([sys.executable, "-c", "import tomllib"], cwd=poisoned)
    assert result.returncode != 0
    (poisoned / "RUN_tomllib").unlink()


def test_every_command_is_tried():
    found = {module.name for module in pkgutil.iter_modules(commands.__path__)}
    assert set(ARGUMENTS) == {name for name in found if not name.startswith("_")}


@pytest.mark.parametrize("command", sorted(ARGUMENTS))
def test_no_command_runs_python_files_of_the_present_folder(poisoned, command):
    needed = {"plot": "matplotlib", "render": "pyvista", "report": "matplotlib"}.get(command)
    if needed and importlib.util.find_spec(needed) is None:
        pytest.skip(f"{needed}, which draws, is missing")
    if command in ("life", "recover"):  # need a run whose blades are reduced and have plies
        with suppress(FileExistsError):
            (poisoned / "reduced").mkdir()
            run_reduced(write_case(poisoned / "reduced"), "run", *FEW[1:], *ROWS)
    if command == "damping":  # needs blades that move by few functions
        (poisoned / "beams").mkdir()
        write_beam_case(poisoned / "beams")
    result = start(poisoned, command, *ARGUMENTS[command])
    assert result.returncode == 0, result.stderr
    assert [path.name for path in poisoned.glob("RUN_*")] == []

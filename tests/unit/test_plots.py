"""Figures from ``history.csv`` and the picture from ``fields.xdmf``."""

import csv
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest

from turbine_fenicsx import pictures, plots
from turbine_fenicsx.observers.xdmf import XdmfSeries

pytestmark = pytest.mark.filterwarnings("ignore:Unable to import Axes3D")
needs_matplotlib = pytest.mark.skipif(
    importlib.util.find_spec("matplotlib") is None, reason="Matplotlib, which draws, is missing"
)
needs_pyvista = pytest.mark.skipif(
    importlib.util.find_spec("pyvista") is None, reason="PyVista, which draws, is missing"
)
ANGLES = ("yaw", "rotor")


def history(n_tips: int = 3, angles: tuple[str, ...] = ANGLES, n: int = 61) -> dict:
    """Columns of a run: torque up to 3 s, then free rotation with vibrating blades."""
    t = np.linspace(0.0, 12.0, n)
    speed = -1.12 * np.minimum(t / 3.0, 1.0) ** 2
    work = 15e6 * speed**2
    strain = 4e5 * np.sin(6.0 * t) ** 2
    error = 1e-4 * np.sin(40.0 * t)
    momentum = np.outer([0.0, 1e-6, 5e7], speed)
    return {
        "time_[s]": t,
        "kinetic_energy_[J]": work - strain,
        "strain_energy_[J]": strain,
        "potential_energy_[J]": np.full(n, -56e3),
        "total_energy_[J]": work - 56e3 + error,
        "external_work_[J]": work,
        "energy_error_[J]": error,
        **{f"linear_momentum_{i + 1}_[kgm/s]": momentum[i] for i in range(3)},
        **{f"angular_momentum_{i + 1}_[Nms]": momentum[i] for i in range(3)},
        **{f"angle_{name}_[rad]": (i + 1) * speed * t for i, name in enumerate(angles)},
        **{f"tip_deflection_{i + 1}_[m]": np.sin(6.0 * t + i) for i in range(n_tips)},
        "constraint_error_[-]": np.full(n, 1e-15),
        "newton_iterations": np.full(n, 3),
        "krylov_iterations": np.zeros(n),
        "wall_time_[s]": t,
    }


def write(path: Path, columns: dict, end: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        file.write(end)
    return path


def is_png(path: Path) -> bool:
    return path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000


@pytest.fixture
def drawn(monkeypatch) -> list:
    """Figures that were saved, for a look at their lines."""
    from matplotlib.figure import Figure

    figures = []
    save = Figure.savefig

    def keep(self, *args, **kwargs):
        figures.append(self)
        save(self, *args, **kwargs)

    monkeypatch.setattr(Figure, "savefig", keep)
    return figures


def lines(figure, title: str) -> dict:
    (axes,) = [axes for axes in figure.axes if axes.get_title("left") == title]
    return {line.get_label(): line.get_xydata().T for line in axes.get_lines()}


def test_history_is_read_as_written(tmp_path):
    columns = history()
    run = plots.read_history(write(tmp_path / "stiff" / "history.csv", columns))
    assert run.name == "stiff"
    assert list(run.columns) == list(columns)
    for name, values in columns.items():
        assert np.array_equal(run[name], values)
    assert list(run.named("angle_")) == ["yaw", "rotor"]
    assert list(run.named("tip_deflection_")) == ["1", "2", "3"]


def test_row_that_a_crash_cut_off_is_left_out(tmp_path):
    run = plots.read_history(write(tmp_path / "history.csv", history(n=5), end="12.2,3.0"))
    assert len(run["time_[s]"]) == 5


def test_empty_field_is_not_a_number(tmp_path):
    columns = history(n=3) | {"max_stress_[Pa]": ["1.0", "", "3.0"]}
    values = plots.read_history(write(tmp_path / "history.csv", columns))["max_stress_[Pa]"]
    assert np.array_equal(values, [1.0, np.nan, 3.0], equal_nan=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [("", "holds no rows"), ("time_[s]\n", "holds no rows"), ("time_[s]\nnow\n", "'now'")],
)
def test_unreadable_history_is_one_sentence(tmp_path, text, message):
    (tmp_path / "history.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        plots.read_history(tmp_path / "history.csv")


@needs_matplotlib
def test_figure_shows_what_the_history_holds(tmp_path, drawn):
    columns = history()
    path = write(tmp_path / "history.csv", columns)
    assert plots.plot_history(path, tmp_path / "history.png") == tmp_path / "history.png"
    assert is_png(tmp_path / "history.png")
    (figure,) = drawn
    energies = lines(figure, "Energies")
    for name in ("total", "kinetic", "strain", "potential"):
        assert np.allclose(
            energies[name], [columns["time_[s]"], columns[f"{name}_energy_[J]"] / 1e3]
        )
    beyond = columns["total_energy_[J]"] - columns["external_work_[J]"]
    (steps,) = lines(figure, "Energy error per step").values()
    assert np.allclose(steps[1][1:], np.abs(np.diff(beyond)))
    assert figure.axes[1].get_yscale() == "log"
    (error,) = lines(figure, "Energy error").values()
    assert np.array_equal(error[1], columns["energy_error_[J]"])
    angles = lines(figure, "Joint angles")
    assert list(angles) == ["yaw", "rotor"]
    assert np.array_equal(angles["rotor"][1], columns["angle_rotor_[rad]"])
    momentum = lines(figure, "Angular momentum")
    assert np.allclose(momentum["$L_3$"][1], columns["angular_momentum_3_[Nms]"] / 1e3)
    tips = lines(figure, "Tip deflections")
    assert np.array_equal(tips["blade 2"][1], columns["tip_deflection_2_[m]"])


@needs_matplotlib
def test_rigid_history_shows_five_angles_and_the_constraint_error(tmp_path, drawn):
    angles = (*ANGLES, "pitch_1", "pitch_2", "pitch_3")
    path = write(tmp_path / "history.csv", history(n_tips=0, angles=angles))
    plots.plot_history(str(path), tmp_path / "rigid.svg")
    assert list(lines(drawn[0], "Joint angles")) == [name.replace("_", " ") for name in angles]
    assert len(lines(drawn[0], "Constraint error")) == 1


@needs_matplotlib
def test_several_runs_share_the_panels(tmp_path, drawn):
    paths = [write(tmp_path / name / "history.csv", history()) for name in ("stiff", "soft")]
    plots.plot_history(paths, tmp_path / "both.png")
    assert is_png(tmp_path / "both.png")
    assert list(lines(drawn[0], "Energy error")) == ["stiff", "soft"]
    assert [text.get_text() for text in drawn[0].legends[0].get_texts()] == ["stiff", "soft"]


@needs_matplotlib
@pytest.mark.parametrize("n", [1, 61])
def test_summary_shows_energies_and_angles(tmp_path, drawn, n):
    path = write(tmp_path / "history.csv", history(n=n))
    assert is_png(plots.plot_summary(path, tmp_path / "summary.png"))
    assert [axes.get_title("left") for axes in drawn[0].axes] == ["Energies", "Joint angles"]


@needs_matplotlib
def test_missing_column_is_named(tmp_path):
    columns = history()
    del columns["strain_energy_[J]"]
    path = write(tmp_path / "run" / "history.csv", columns)
    with pytest.raises(ValueError, match=r"'run' has no column 'strain_energy_\[J\]'"):
        plots.plot_summary(path, tmp_path / "summary.png")


def test_missing_matplotlib_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    path = write(tmp_path / "history.csv", history())
    with pytest.raises(ImportError, match="figures need Matplotlib: pip install matplotlib"):
        plots.plot_summary(path, tmp_path / "summary.png")


def turbine(path: Path) -> Path:
    """Boxes for nacelle and hub and three needles for blades, at t = 0 and 1 s."""
    cube = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
    faces = np.array([(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6)])
    hexahedron = np.array([[0, 1, 3, 2, 4, 5, 7, 6]])
    points = [2.0 * cube, 2.0 * cube + (0.0, 0.0, 5.0)]
    for angle in 2.0 * np.pi / 3.0 * np.arange(3):
        c, s = np.cos(angle), np.sin(angle)
        blade = cube * (1.0, 27.0, 0.5) + (0.0, 29.25, 0.0)
        points.append(blade @ [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]] + (0.0, 0.0, 5.0))
    cells = [
        ("quadrilateral", np.concatenate([faces, faces + 8])),
        ("hexahedron", np.concatenate([hexahedron + 8 * i for i in (2, 3, 4)])),
    ]
    x = np.concatenate(points)
    part = np.array([0] * 4 + [1] * 4 + [2, 3, 4])
    series = XdmfSeries(MPI.COMM_SELF, path, cells, len(x), cell_data={"part": part})
    for t in (0.0, 1.0):
        stress = 1e7 * t * part
        series.write(t, x, {"displacement": 0.0 * x}, {"cauchy_stress_norm": stress})
    return path


@needs_pyvista
@pytest.mark.parametrize(
    "options", [{}, {"time": 0.0}, {"scalar": "displacement"}, {"scalar": None}]
)
def test_picture_shows_something_on_white(tmp_path, options):
    path = turbine(tmp_path / "fields.xdmf")
    try:
        png = pictures.render_turbine(path, tmp_path / "turbine.png", **options)
    except RuntimeError as problem:
        if "no graphics library" in str(problem):
            pytest.skip(str(problem))
        raise
    assert is_png(png)
    image = pytest.importorskip("matplotlib.image").imread(png)
    assert image.shape[:2] == (1200, 1600)
    white = (image[..., :3] > 0.99).all(axis=-1)
    assert white[:, :100].mean() > 0.9
    assert 0.02 < 1.0 - white[:, 200:1100].mean() < 0.5


@needs_pyvista
@pytest.mark.parametrize(
    ("fields", "scalar", "message"),
    [
        ("none.xdmf", "displacement", r"none\.xdmf"),
        ("fields.xdmf", "heat", "no field 'heat', but cauchy_stress_norm, displacement, part$"),
    ],
)
def test_what_cannot_be_drawn_is_one_sentence(tmp_path, fields, scalar, message):
    turbine(tmp_path / "fields.xdmf")
    with pytest.raises(RuntimeError, match=message) as caught:
        pictures.render_turbine(tmp_path / fields, tmp_path / "turbine.png", scalar=scalar)
    assert "\n" not in str(caught.value)


def test_missing_graphics_library_does_not_end_the_caller(tmp_path, monkeypatch):
    died = subprocess.CompletedProcess([], returncode=-11, stdout="", stderr="")
    monkeypatch.setattr(subprocess, "run", lambda *args, **options: died)
    with pytest.raises(RuntimeError, match=r"no graphics library .*apt install libegl1"):
        pictures.render_turbine(tmp_path / "fields.xdmf", tmp_path / "turbine.png")


def test_missing_pyvista_is_one_sentence(tmp_path):
    (tmp_path / "pyvista.py").write_text("raise ModuleNotFoundError('none here')\n")
    child = subprocess.run(
        [sys.executable, "-P", pictures.__file__, "fields.xdmf", "turbine.png"],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert child.returncode == 2
    assert child.stderr == "pictures need PyVista: pip install pyvista (none here)\n"

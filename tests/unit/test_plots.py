"""Diagrams show what ``history.csv`` holds."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from outputs import ANGLES, history, write

from turbine_fenicsx import plots
from turbine_fenicsx.errors import InputError
from turbine_fenicsx.output_folder import read_histories, read_history

pytestmark = [
    pytest.mark.filterwarnings("ignore:Unable to import Axes3D"),
    pytest.mark.skipif(
        importlib.util.find_spec("matplotlib") is None, reason="Matplotlib, which draws, is missing"
    ),
]


def is_png(path: Path) -> bool:
    return path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000


@pytest.fixture
def drawn(monkeypatch) -> list:
    """Figures that were saved, for a look at their lines; without the time of saving them."""
    from matplotlib.figure import Figure

    figures = []

    def keep(self, path, **options):
        figures.append(self)
        Path(path).touch()

    monkeypatch.setattr(Figure, "savefig", keep)
    return figures


def lines(figure, title: str) -> dict:
    (axes,) = [axes for axes in figure.axes if axes.get_title("left") == title]
    return {line.get_label(): line.get_xydata().T for line in axes.get_lines()}


def draw_all(runs, tmp_path, **options) -> None:
    panels = [panel for panels in plots.figures(runs).values() for panel in panels]
    plots.draw(runs, panels, [tmp_path / "all.png"], **options)


def test_figures_show_what_the_history_holds(tmp_path, drawn):
    columns = history()
    run = read_history(write(tmp_path / "run" / "history.csv", columns))
    draw_all([run], tmp_path)
    (figure,) = drawn
    energies = lines(figure, "Energies")
    for name in ("total", "kinetic", "strain", "potential"):
        start = columns["potential_energy_[J]"][0] if name in ("total", "potential") else 0.0
        energy = columns[f"{name}_energy_[J]"] - start
        assert np.allclose(energies[name], [columns["time_[s]"], energy / 1e3])
    assert columns["potential_energy_[J]"][0] != 0.0
    small = lines(figure, "Strain and potential")
    assert list(small) == ["strain", "potential"]
    beyond = columns["total_energy_[J]"] - columns["external_work_[J]"]
    steps = lines(figure, "Energy error per step")["run"]
    assert np.allclose(steps[1][1:], np.abs(np.diff(beyond)) / 1e3)
    error = lines(figure, "Energy error since the start")["run"]
    assert np.allclose(error[1], columns["energy_error_[J]"] / 1e3)
    angles = lines(figure, "Joint angles")
    assert list(angles) == ["yaw", "rotor"]
    assert np.array_equal(angles["rotor"][1], columns["angle_rotor_[rad]"])
    momentum = lines(figure, "Angular momentum")
    assert np.allclose(momentum["$L_3$"][1], columns["angular_momentum_3_[Nms]"] / 1e3)
    changes = lines(figure, "Change per step")
    change = np.abs(np.diff(columns["angular_momentum_3_[Nms]"])) / 1e3
    change[change == 0.0] = np.nan  # zeros have no place on a logarithmic axis
    assert np.allclose(changes[r"$\Delta L_3$"][1][1:], change, equal_nan=True)
    tips = lines(figure, "Tip deflections")
    assert np.array_equal(tips["blade 2"][1], columns["tip_deflection_2_[m]"])


def test_changes_per_step_are_shown_with_the_tolerance(tmp_path, drawn):
    run = read_history(write(tmp_path / "history.csv", history()))
    draw_all([run], tmp_path, tolerance=2.5e-6)
    found = [axes for axes in drawn[0].axes if axes.get_yscale() == "log"]
    assert [axes.get_title("left") for axes in found] == [
        "Energy error per step",
        "Change per step",
    ]
    for axes in found:
        (level,) = {
            tuple(line.get_ydata()) for line in axes.get_lines() if len(line.get_ydata()) == 2
        }
        assert level == (2.5e-6, 2.5e-6)
        (words,) = axes.texts
        assert words.get_text() == r"tolerance $2.5 \times 10^{-6}$"
        assert axes.get_ylim()[0] < 2.5e-6 < axes.get_ylim()[1] / 1.5  # the words have room


def test_small_numbers_carry_their_power_of_ten_in_the_unit(tmp_path, drawn):
    run = read_history(write(tmp_path / "history.csv", history()))
    draw_all([run], tmp_path)
    (axes,) = [a for a in drawn[0].axes if a.get_title("left") == "Energy error since the start"]
    assert axes.get_ylabel() == "$H - H_0 - W$ [$10^{-9}$ kJ]"
    assert axes.yaxis.get_major_formatter()(-5e-8) == "\u221250"


def test_angles_are_in_the_unit_asked_for(tmp_path, drawn):
    columns = history()
    run = read_history(write(tmp_path / "history.csv", columns))
    draw_all([run], tmp_path, degrees=True)
    angles = lines(drawn[0], "Joint angles")
    assert np.allclose(angles["yaw"][1], np.degrees(columns["angle_yaw_[rad]"]))
    (axes,) = [axes for axes in drawn[0].axes if axes.get_title("left") == "Joint angles"]
    assert axes.get_ylabel() == "angle [°]"


def test_rigid_run_has_five_angles_and_no_tips(tmp_path, drawn):
    angles = (*ANGLES, "pitch_1", "pitch_2", "pitch_3")
    run = read_history(write(tmp_path / "history.csv", history(n_tips=0, angles=angles)))
    assert list(plots.figures([run])) == ["energy", "angular_momentum", "angles"]
    draw_all([run], tmp_path)
    assert list(lines(drawn[0], "Joint angles")) == [name.replace("_", " ") for name in angles]


def test_several_runs_differ_by_style_and_are_named(tmp_path, drawn):
    names = ["stiff", "soft", "aborted"]
    for name, n in zip(names, (61, 61, 7), strict=True):
        write(tmp_path / name / "history.csv", history(n=n))
    runs = read_histories([tmp_path / name for name in names])
    draw_all(runs, tmp_path)
    (figure,) = drawn
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == names
    assert len({line.get_linestyle() for line in legend.get_lines()}) == 3
    assert len({line.get_marker() for line in legend.get_lines()}) == 3
    (axes,) = [axes for axes in figure.axes if axes.get_title("left") == "Energies"]
    totals = [line for line in axes.get_lines() if line.get_label() == "total"]
    assert len({str(line.get_linestyle()) for line in totals}) == 3
    assert [len(line.get_xdata()) for line in totals] == [61, 61, 7]
    # the legends of the panels name quantities, not runs
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "total",
        "kinetic",
        "strain",
        "potential",
    ]
    (axes,) = [axes for axes in figure.axes if axes.get_title("left") == "Energy error per step"]
    assert axes.get_legend() is None
    assert set(names) < set(lines(figure, "Energy error per step"))
    assert set(names) < set(lines(figure, "Change per step"))


def test_more_runs_than_styles_are_refused(tmp_path):
    for k in range(7):
        write(tmp_path / str(k) / "history.csv", history(n=2))
    runs = read_histories([tmp_path / str(k) for k in range(7)])
    with pytest.raises(InputError, match="7 runs are too many for one figure, 6 fit"):
        draw_all(runs, tmp_path)


def test_single_row_is_drawn_as_points(tmp_path, drawn):
    run = read_history(write(tmp_path / "history.csv", history(n=1)))
    draw_all([run], tmp_path)
    (axes,) = [axes for axes in drawn[0].axes if axes.get_title("left") == "Energies"]
    assert {line.get_marker() for line in axes.get_lines()} == {"o"}


def test_files_are_what_their_suffix_says(tmp_path):
    run = read_history(write(tmp_path / "history.csv", history()))
    (panels,) = [p for name, p in plots.figures([run]).items() if name == "angles"]
    png, pdf = plots.draw([run], panels, [tmp_path / "angles.png", tmp_path / "angles.pdf"])
    assert is_png(png)
    assert pdf.read_bytes().startswith(b"%PDF")


def test_figure_that_cannot_be_written_is_one_sentence(tmp_path):
    run = read_history(write(tmp_path / "history.csv", history()))
    (tmp_path / "angles.png").mkdir()
    with pytest.raises(InputError, match=r"cannot write .*angles.png': Is a directory"):
        plots.draw([run], plots.figures([run])["angles"], [tmp_path / "angles.png"])


@pytest.mark.parametrize("n", [1, 61])
def test_summary_shows_energies_and_angles(tmp_path, drawn, n):
    path = write(tmp_path / "history.csv", history(n=n))
    assert plots.plot_summary(path, tmp_path / "summary.png").exists()
    assert [axes.get_title("left") for axes in drawn[0].axes] == ["Energies", "Joint angles"]


def test_missing_column_is_named(tmp_path):
    columns = history()
    del columns["strain_energy_[J]"]
    path = write(tmp_path / "run" / "history.csv", columns)
    with pytest.raises(InputError, match=r"'run' has no column 'strain_energy_\[J\]'"):
        plots.plot_summary(path, tmp_path / "summary.png")


def test_missing_matplotlib_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    path = write(tmp_path / "history.csv", history())
    with pytest.raises(ImportError, match="figures need Matplotlib: pip install matplotlib"):
        plots.plot_summary(path, tmp_path / "summary.png")

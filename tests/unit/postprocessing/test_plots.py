"""Diagrams show what ``history.csv`` holds."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from outputs import ANGLES, history, write

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import plots
from turbine_fenicsx.postprocessing.panels import energy_error, energy_steps
from turbine_fenicsx.postprocessing.split_panels import split_panels
from turbine_fenicsx.records.output_folder import read_histories, read_history
from turbine_fenicsx.turbine.blades.rotor_plan import PITCH_SIGNS

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
    panels = [panel for panels in plots.choose_figures(runs).values() for panel in panels]
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
        assert np.allclose(energies[name], [columns["time_[s]"], energy])
    assert columns["potential_energy_[J]"][0] != 0.0
    small = lines(figure, "Strain and potential")
    assert list(small) == ["strain", "potential"]
    beyond = columns["total_energy_[J]"] - columns["external_work_[J]"]
    steps = lines(figure, "Energy error per step")["run"]
    assert np.allclose(steps[1][1:], np.abs(np.diff(beyond)))
    error = lines(figure, "Energy error since the start")["run"]
    assert np.allclose(error[1], columns["energy_error_[J]"])
    angle = lines(figure, "Rotor angle")["rotor"][1]
    assert np.allclose(angle, np.degrees(columns["angle_rotor_[rad]"]))
    assert np.allclose(lines(figure, "Yaw")["yaw"][1], -np.degrees(columns["angle_yaw_[rad]"]))
    rpm = np.diff(columns["angle_rotor_[rad]"]) / np.diff(columns["time_[s]"]) * 30.0 / np.pi
    assert np.allclose(lines(figure, "Rotor speed")["run"][1][1:], rpm)
    momentum = lines(figure, "Angular momentum")
    assert np.allclose(momentum["$L_3$"][1], columns["angular_momentum_3_[Nms]"])
    changes = lines(figure, "Change per step")
    change = np.abs(np.diff(columns["angular_momentum_3_[Nms]"]))
    change[change == 0.0] = np.nan  # zeros have no place on a logarithmic axis
    assert np.allclose(changes[r"$\Delta L_3$"][1][1:], change, equal_nan=True)
    for title, column in {
        "Tip, flapwise": "tip_flap_2_[m]",
        "Tip, edgewise": "tip_edge_2_[m]",
        "Flap moment": "root_moment_2_y_[Nm]",
        "Edge moment": "root_moment_2_x_[Nm]",
    }.items():
        shown = lines(figure, title)
        assert list(shown) == ["blade 1", "blade 2", "blade 3"]
        assert np.array_equal(shown["blade 2"][1][1:], columns[column][1:])
        moment = title.endswith("moment")  # a mean of the step before, which the first has not
        assert np.isnan(shown["blade 2"][1][0]) == moment


def dashed(figure, title: str):
    """Level of the tolerance line of a panel and its words; None for none."""
    (axes,) = [axes for axes in figure.axes if axes.get_title("left") == title]
    assert axes.get_yscale() == "log"
    levels = {tuple(line.get_ydata()) for line in axes.get_lines() if len(line.get_ydata()) == 2}
    if not axes.texts:
        assert not levels
        return None
    ((level, other),) = levels
    assert level == other
    assert axes.get_ylim()[0] < level < axes.get_ylim()[1] / 1.5  # the words have room
    return level, axes.texts[0].get_text()


def test_changes_per_step_are_shown_with_a_tolerance(tmp_path, drawn):
    columns = history()
    run = read_history(write(tmp_path / "history.csv", columns))
    for options in ({}, {"tolerance": 2.5e-6}, {"relative_tolerance": 1e-12}):
        draw_all([run], tmp_path, **options)
    titles = ("Energy error per step", "Change per step")
    assert [dashed(drawn[0], title) for title in titles] == [None, None]
    words = r"tolerance $2.5 \times 10^{-6}$ "
    assert [dashed(drawn[1], title) for title in titles] == [
        (pytest.approx(2.5e-3), words + "kJ"),
        (pytest.approx(2.5e-3), words + "kN m s"),
    ]
    momentum = max(np.abs(columns[f"angular_momentum_{i}_[Nms]"]).max() for i in (1, 2, 3))
    energy = columns["kinetic_energy_[J]"].max()
    words = "tolerance $10^{-12}$ of the largest"
    (level, said), momenta = (dashed(drawn[2], title) for title in titles)
    assert level == pytest.approx(1e-12 * energy, rel=0.05) and said == words
    assert momenta == (pytest.approx(1e-12 * momentum), words)


def test_momentum_that_loads_change_to_the_end_has_no_tolerance(tmp_path, drawn):
    columns = history()
    columns["external_work_[J]"] = 1e3 * columns["time_[s]"]
    draw_all([read_history(write(tmp_path / "history.csv", columns))], tmp_path, tolerance=1.0)
    assert dashed(drawn[0], "Energy error per step") is not None
    assert dashed(drawn[0], "Change per step") is None


def test_legends_of_runs_have_markers_only_where_lines_have(tmp_path, drawn):
    write(tmp_path / "history.csv", history())
    runs = 2 * [read_history(tmp_path / "history.csv")]
    for panel in (energy_error, energy_steps):
        plots.draw(runs, [panel], [tmp_path / "a.png"])
    plain, dots = (figure.legends[0].get_lines() for figure in drawn)
    assert {line.get_marker() for line in plain} == {""}
    assert len({line.get_marker() for line in dots}) == 2


@pytest.mark.parametrize(
    ("values", "unit", "label", "tick"),
    [
        ((0.0, 7.4e6), "J", "energy [MJ]", (2e6, "2")),
        ((-5e-6, 5e-6), "J", "energy [µJ]", (-5e-6, "\u22125")),
        ((0.0, 0.02), "m", "energy [mm]", (0.015, "15")),
        ((0.0, 5e3), "m", "energy [m]", None),
        ((0.0, 80.0), "°", "energy [°]", None),
        ((0.0, 3e-9), "rpm", "energy [$10^{-9}$ rpm]", (2e-9, "2")),
    ],
)
def test_large_and_small_numbers_get_a_prefix(tmp_path, drawn, values, unit, label, tick):
    run = read_history(write(tmp_path / "history.csv", history(n=2)))

    def panel(axes, run, look):
        axes.plot([0.0, 12.0], values)
        axes.set_ylim(*values)
        axes.set_ylabel(f"energy [{unit}]")

    plots.draw([run], [panel], [tmp_path / "a.png"])
    (axes,) = drawn[0].axes
    assert axes.get_ylabel() == label
    if tick:
        assert axes.yaxis.get_major_formatter()(tick[0]) == tick[1]


def test_angles_are_in_the_unit_asked_for(tmp_path, drawn):
    columns = history()
    run = read_history(write(tmp_path / "history.csv", columns))
    draw_all([run], tmp_path, degrees=False)
    assert np.allclose(lines(drawn[0], "Yaw")["yaw"][1], -columns["angle_yaw_[rad]"])
    (axes,) = [axes for axes in drawn[0].axes if axes.get_title("left") == "Rotor angle"]
    assert axes.get_ylabel() == "angle [rad]"


def test_rigid_run_has_five_angles_and_no_tips_and_all_blades_pitch_alike(tmp_path, drawn):
    angles = (*ANGLES, "pitch_1", "pitch_2", "pitch_3")
    columns = history(n_tips=0, angles=angles)
    for k, sign in enumerate(PITCH_SIGNS, start=1):
        columns[f"angle_pitch_{k}_[rad]"] = -sign * np.linspace(0.0, 1.4, 61)
    run = read_history(write(tmp_path / "history.csv", columns))
    assert list(plots.choose_figures([run])) == ["angles", "energy", "angular_momentum"]
    draw_all([run], tmp_path)
    shown = lines(drawn[0], "Yaw and pitch")
    assert list(shown) == ["yaw", "pitch 1, 2, 3"]
    assert shown["pitch 1, 2, 3"][1][-1] == pytest.approx(np.degrees(1.4))


def test_model_that_is_no_turbine_shows_its_angles_as_they_are(tmp_path, drawn):
    columns = history(n_tips=0, angles=("shoulder", "elbow"))
    columns["displacement_slide_[m]"] = columns["time_[s]"]
    run = read_history(write(tmp_path / "history.csv", columns))
    assert list(plots.choose_figures([run])) == [
        "angles",
        "displacements",
        "energy",
        "angular_momentum",
    ]
    draw_all([run], tmp_path)
    shown = lines(drawn[0], "Joint angles")
    assert np.allclose(shown["elbow"][1], np.degrees(columns["angle_elbow_[rad]"]))
    assert plots.plot_summary(tmp_path / "history.csv", tmp_path / "summary.png").exists()


def test_joints_of_new_components_stand_apart_from_yaw_and_pitch(drawn, tmp_path):
    angles = (*ANGLES, "pitch_1", "pitch_2", "pitch_3", "shaft", "generator")
    run = read_history(write(tmp_path / "history.csv", history(angles=angles)))
    plots.draw([run], plots.choose_figures([run])["angles"], [tmp_path / "angles.png"])
    found = {axes.get_title("left"): axes.get_legend_handles_labels()[1] for axes in drawn[0].axes}
    assert found["Yaw and pitch"] == ["yaw", "pitch 1", "pitch 2", "pitch 3"]
    assert found["Joint angles"] == ["shaft", "generator"]


def test_legends_do_not_cover_titles(tmp_path):
    angles = (*ANGLES, "pitch_1", "pitch_2", "pitch_3")
    run = read_history(write(tmp_path / "history.csv", history(angles=angles, n=5)))
    checked = []

    def watch(panel):
        def draw(axes, run, look):
            panel(axes, run, look)
            checked.append(axes)

        return draw

    for panels in plots.choose_figures([run]).values():
        plots.draw([run], [watch(panel) for panel in panels], [tmp_path / "a.svg"])
    checked = [axes for axes in checked if axes.get_legend()]
    assert len(checked) > 6
    for axes in checked:
        axes.figure.draw_without_rendering()
        title, legend = axes._left_title, axes.get_legend()
        apart = legend.get_window_extent().x0 - title.get_window_extent().x1
        assert apart > 5.0, title.get_text()


def test_tower_is_shown(tmp_path, drawn):
    columns = history()
    for name in ("top_displacement_{}_[m]", "base_moment_{}_[Nm]"):
        for axis in "xyz":
            columns["tower_" + name.format(axis)] = "xyz".index(axis) + columns["time_[s]"]
    run = read_history(write(tmp_path / "history.csv", columns))
    assert "tower" in plots.choose_figures([run])
    draw_all([run], tmp_path)
    assert list(lines(drawn[0], "Tower top")) == ["fore-aft", "side to side"]
    assert list(lines(drawn[0], "Tower base")) == ["fore-aft", "side to side"]


@pytest.mark.parametrize("name", [r"$\frac{$", "_hidden", "a$b$c", r"50 % \alpha"])
def test_names_of_folders_are_no_formulas(tmp_path, name):
    for folder in (name, "other"):
        write(tmp_path / folder / "history.csv", history(n=5))
    runs = read_histories([tmp_path / name, tmp_path / "other"])
    figures = []

    def keep(axes, run, look):
        figures.append(axes.figure)
        axes.plot(run["time_[s]"], run["time_[s]"], label=run.name)
        axes.set_ylabel("time [s]")

    plots.draw(runs, [keep], [tmp_path / "a.png", tmp_path / "a.pdf", tmp_path / "a.svg"])
    (legend,) = figures[0].legends
    assert [text.get_text() for text in legend.get_texts()] == [name, "other"]
    assert (
        f">{name}<" in (tmp_path / "a.svg").read_text() or name in (tmp_path / "a.svg").read_text()
    )


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
    assert set(names) == set(lines(figure, "Energy error per step"))
    assert set(names) == set(lines(figure, "Change per step"))


def test_quantities_of_several_runs_have_panels_of_their_own(tmp_path, drawn):
    """So that colour and line say which run it is."""
    for name in ("stiff", "soft"):
        write(tmp_path / name / "history.csv", history())
    runs = read_histories([tmp_path / "stiff", tmp_path / "soft"])
    panels = plots.choose_figures(runs)
    shown = split_panels([*panels["energy"], *panels["root_moments"]], runs)
    plots.draw(runs, shown, [tmp_path / "a.png"])
    found = {axes.get_title("left"): axes for axes in drawn[0].axes}
    assert list(found) == [
        *(f"Energies: {name}" for name in ("total", "kinetic", "strain", "potential")),
        *("Energy error per step", "Energy error since the start"),
        *(f"{name} moment: blade {k}" for name in ("Flap", "Edge") for k in (1, 2, 3)),
    ]
    for axes in found.values():
        own = [line for line in axes.get_lines() if not line.get_label().startswith("_")]
        assert [line.get_label() for line in own] == ["stiff", "soft"]
        assert len({line.get_color() for line in own}) == 2
        assert len({line.get_linestyle() for line in own}) == 2 or "step" in axes.get_title("left")
    colors = [line.get_color() for line in drawn[0].legends[0].get_lines()]
    assert colors == [line.get_color() for line in found["Energies: strain"].get_lines()]
    places = {axes.get_subplotspec().get_geometry()[:2] for axes in drawn[0].axes}
    assert places == {(4, 3)}
    assert split_panels(panels["energy"], runs[:1]) == list(panels["energy"])


def test_a_title_stands_above(tmp_path, drawn):
    path = write(tmp_path / "history.csv", history(n=5))
    plots.plot_summary(path, tmp_path / "summary.png", r"5 % $\frac{ more")
    assert drawn[0].get_suptitle() == r"5 % $\frac{ more"
    assert not drawn[0]._suptitle.get_parse_math()


def test_round_off_of_an_angle_is_drawn_as_zero(tmp_path, drawn):
    columns = history(n=5)
    columns["angle_yaw_[rad]"] = 1e-29 * np.arange(5)
    run = read_history(write(tmp_path / "history.csv", columns))
    draw_all([run], tmp_path)
    assert not lines(drawn[0], "Yaw")["yaw"][1].any()


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
    (panels,) = [p for name, p in plots.choose_figures([run]).items() if name == "angles"]
    png, pdf = plots.draw([run], panels, [tmp_path / "angles.png", tmp_path / "angles.pdf"])
    assert is_png(png)
    assert pdf.read_bytes().startswith(b"%PDF")


def test_figure_that_cannot_be_written_is_one_sentence(tmp_path):
    run = read_history(write(tmp_path / "history.csv", history()))
    (tmp_path / "angles.png").mkdir()
    with pytest.raises(InputError, match=r"cannot write .*angles.png': Is a directory"):
        plots.draw([run], plots.choose_figures([run])["angles"], [tmp_path / "angles.png"])


@pytest.mark.parametrize("n", [1, 61])
def test_summary_shows_what_one_looks_at_first(tmp_path, drawn, n):
    path = write(tmp_path / "history.csv", history(n=n))
    assert plots.plot_summary(path, tmp_path / "summary.png").exists()
    assert [axes.get_title("left") for axes in drawn[0].axes] == [
        "Flap moment",
        "Tip, flapwise",
        "Rotor speed",
        "Energies",
    ]


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

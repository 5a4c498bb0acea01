"""Chart of the balance of power: what comes in equals what goes out."""

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from turbine_fenicsx.foundation.diagram_style import STYLE
from turbine_fenicsx.postprocessing import plots
from turbine_fenicsx.postprocessing.panels import energy_steps, find_energy_steps
from turbine_fenicsx.postprocessing.plot_style import Look
from turbine_fenicsx.postprocessing.power_balance import choose_terms, powers, works
from turbine_fenicsx.records import names
from turbine_fenicsx.records.output_folder import TimeSeries

T = np.linspace(0.0, 10.0, 401)
WIND, GENERATOR, FRICTION, TINY = 5e6 * T + 1e6 * np.sin(T), -3e6 * T, 1e6 * T, 1e-4 * T


def run(**columns):
    columns = {names.WORK(name=name): values for name, values in columns.items()}
    columns[names.DISSIPATION(name="brake")] = FRICTION
    total = 7e8 + sum(columns[names.WORK(name=n)] for n in ("wind", "generator")) - FRICTION
    kinetic = {name: 0.5 * total for name in (names.KINETIC_ENERGY, names.POTENTIAL_ENERGY)}
    rest = {names.TIME: T, names.TOTAL_ENERGY: total}
    return TimeSeries("run", columns | kinetic | rest)


@pytest.fixture
def turbine():
    return run(wind=WIND, generator=GENERATOR, motion_of_pitch_1=TINY)


def test_areas_above_and_below_zero_are_equal_and_each_as_large_as_its_energy(turbine):
    axes = Figure().subplots()
    powers(axes, turbine, Look(), choose_terms([turbine]))
    areas = []
    for shown in axes.collections:
        x, y = shown.get_paths()[0].vertices.T
        areas.append(0.5 * abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))))
    labels = [line.get_label() for line in axes.get_lines()][:-1]
    assert labels == ["wind", "generator", "brake", "stored energy"]
    above, below = areas[::2], areas[1::2]
    assert sum(above) == pytest.approx(WIND[-1], rel=1e-10)
    assert sum(below) == pytest.approx(WIND[-1], rel=1e-10)
    assert below[1:3] == pytest.approx([-GENERATOR[-1], FRICTION[-1]], rel=1e-10)


def test_works_have_the_sign_of_what_comes_in(turbine):
    axes = Figure().subplots()
    works(axes, turbine, Look(), choose_terms([turbine]))
    found = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    assert np.allclose(found["wind"], WIND) and np.allclose(found["brake"], -FRICTION)
    assert np.allclose(sum(found.values()), 0.0, atol=1e-6)


def test_what_a_brake_takes_out_is_no_error_of_a_step(turbine):
    work = names.EXTERNAL_WORK
    columns = dict(turbine.columns) | {work: WIND + GENERATOR, names.CONSTRAINT_ERROR: 0.0 * T}
    steps = find_energy_steps(TimeSeries("run", columns))
    assert np.isnan(steps[0]) and np.abs(steps[1:]).max() < 1e-6
    axes = Figure().subplots()
    energy_steps(axes, TimeSeries("run", columns), Look())
    assert r"\Delta D" in axes.get_ylabel()


def test_a_legend_of_several_rows_leaves_the_title_its_place(turbine):
    shown = run(wind=WIND, generator=0.3 * GENERATOR, motion_of_all_pitches=0.24 * WIND)
    with matplotlib.rc_context(STYLE):
        charts = plots.choose_figures([shown])["power_balance"]
        figure = plots._compose(Figure, [shown], charts, [Look()])
        figure.draw_without_rendering()
    for axes in figure.axes:
        legend = axes.get_legend()
        assert [text.get_text() for text in legend.get_texts()][-1] == "other"
        assert not legend.get_window_extent().overlaps(axes._left_title.get_window_extent())


def test_small_terms_are_one(turbine):
    many = {f"w{i}": 1e6 * T * (1 + i) for i in range(4)}
    axes = Figure().subplots()
    shown = run(wind=WIND, generator=GENERATOR, **many)
    works(axes, shown, Look(), choose_terms([shown]))
    assert [line.get_label() for line in axes.get_lines()][-1] == "other"
    assert len(axes.get_lines()) == 5


def test_all_runs_show_the_terms_that_are_large_in_one_of_them(turbine):
    other = run(wind=WIND, generator=GENERATOR, motion_of_pitch_1=0.5 * WIND)
    terms = choose_terms([turbine, other])
    assert "motion of pitch 1" in terms and "motion of pitch 1" not in choose_terms([turbine])
    calm = run(wind=WIND, generator=GENERATOR)
    for each, expected in ((turbine, TINY), (other, 0.5 * WIND), (calm, 0.0 * T)):
        axes = Figure().subplots()
        works(axes, each, Look(), terms)
        found = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
        assert list(found) == list(terms)
        assert np.allclose(found["motion of pitch 1"], expected)


def test_a_run_with_one_way_in_has_no_chart(turbine):
    torque = {names.WORK(name="torque"): 1e6 * T}
    energies = dict.fromkeys((names.KINETIC_ENERGY, names.TOTAL_ENERGY), 1e6 * T)
    rest = {names.POTENTIAL_ENERGY: 0.0 * T, names.TIME: T}
    alone = TimeSeries("alone", torque | energies | rest)
    assert "power_balance" not in plots.choose_figures([alone])
    assert "power_balance" in plots.choose_figures([turbine])

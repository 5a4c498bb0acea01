"""Claims about means of runs, and pictures of quantities over a key."""

import json
from pathlib import Path

import numpy as np
import pytest

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.study.curve import plot_curve, read_reference
from turbine_fenicsx.study.file import Study
from turbine_fenicsx.study.plan import plan
from turbine_fenicsx.study.results import find_drifts, read_results

DEMOS = Path(__file__).parents[3] / "demos"
STUDY = {"case": str(DEMOS / "paper" / "rigid.toml"), "grid": {"time.end": [1.0, 2.0]}}
CURVE = {"x": "time.end", "y": ["angle_rotor"]}


@pytest.fixture
def folder(tmp_path):
    t = np.array([0.0, 1.0, 1.5, 3.0])
    rows = "\n".join(f"{x!r},{x * x!r}" for x in t.tolist())
    (tmp_path / "history.csv").write_text(f"time_[s],power_[W]\n{rows}\n")
    (tmp_path / "summary.json").write_text(json.dumps({"steps": 3}))
    return tmp_path


def test_columns_are_averaged_over_the_end_of_a_run(folder):
    assert read_results(folder) == {"steps": 3, "time_[s]": 3.0, "power_[W]": 9.0}
    found = read_results(folder, 2.0)  # trapezoids of 0.5 and 1.5 s
    assert found["power_[W]"] == pytest.approx((0.5 * 1.625 + 1.5 * 5.625) / 2.0)
    assert found["time_[s]"] == 3.0 and found["steps"] == 3
    assert read_results(folder, 0.1)["power_[W]"] == 9.0  # no other row is so late


def test_means_of_two_halves_tell_what_is_not_stationary(folder):
    t = np.arange(0.0, 10.1, 0.5)
    steady, rising = 5.0 + 0.4 * np.cos(np.pi * t), 5.0 + 0.01 * t
    rows = "\n".join(f"{a},{b},{c}" for a, b, c in zip(t, steady, rising, strict=True))
    (folder / "history.csv").write_text(f"time_[s],thrust_[N],power_[W]\n{rows}\n")
    found = find_drifts(folder, 8.0, ["thrust", "power_[W]", "steps", "power_[W]"])
    # means from 2 to 6 s and from 6 to 10 s
    assert found == {"thrust": pytest.approx(0.0), "power_[W]": pytest.approx(0.04 / 5.08)}
    assert find_drifts(folder, 21.0, ["thrust"]) == {}


def test_means_that_are_none_do_not_drift(folder):
    """Round-off about zero, alone and beside a large swing."""
    t = np.arange(0.0, 10.1, 0.5)
    rows = "\n".join(f"{a},{a**3 * 1e-29},{1e6 * np.cos(np.pi * a) + 1e-6 * a}" for a in t)
    (folder / "history.csv").write_text(f"time_[s],angle_rotor_[rad],power_[W]\n{rows}\n")
    assert find_drifts(folder, 8.0, ["angle_rotor", "power"]) == {"angle_rotor": 0.0, "power": 0.0}


def test_references_are_columns_with_or_without_unit(folder):
    path = folder / "reference.csv"
    path.write_text("# published\ntime.end,angle_rotor_[rad],other\n1.0,0.5,7\n3,2.5,8\n")
    found = read_reference(str(path), "time.end", ["angle_rotor", "thrust"])
    assert list(found) == ["angle_rotor"]
    x, y = found["angle_rotor"]
    assert (x.tolist(), y.tolist()) == ([1.0, 3.0], pytest.approx(np.degrees([0.5, 2.5])))


def test_references_in_degrees_have_the_signs_of_openfast(folder):
    path = folder / "reference.csv"
    path.write_text("wind.speed,angle_pitch_1_[deg],angle_pitch_3_[rad],power_[W]\n9,4,-0.1,-7\n")
    found = read_reference(str(path), "wind.speed", ["angle_pitch_1", "angle_pitch_3", "power"])
    values = [float(y[0]) for _, y in found.values()]
    assert values == pytest.approx([4.0, np.degrees(0.1), -7.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("speed,power\n1,2\n", "needs a column 'time.end' and rows with numbers"),
        ("time.end,power\n", "needs a column 'time.end' and rows with numbers"),
        ("time.end,power\n1,x\n", "needs a number in each column of each row"),
        ("time.end,power\n1,nan\n", "needs finite numbers in at most 100000 rows"),
        ("time.end,power\n1,2,3\n", "needs a number in each column of each row"),
        ("", "needs a column 'time.end' and rows with numbers"),
    ],
)
def test_references_that_are_none_are_refused(folder, text, words):
    (folder / "reference.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        read_reference(str(folder / "reference.csv"), "time.end", ["power"])


def test_a_curve_needs_a_key_that_varies():
    words = "curve.x = 'time.step' is not varied; choose from time.end"
    with pytest.raises(InputError, match=words):
        Study.parse({**STUDY, "curve": {**CURVE, "x": "time.step"}})


def keep_figure(figures):
    """Saves a figure, and keeps it."""
    from matplotlib.figure import Figure

    save = Figure.savefig

    def keep(self, path, **options):
        figures.append(self)
        save(self, path, **options)

    return keep


def test_runs_are_drawn_beside_the_references(folder, monkeypatch):
    reference = folder / "reference.csv"
    reference.write_text("time.end,angle_rotor_[rad]\n1.0,0.5\n3,2.5\n")
    study = Study.parse({**STUDY, "curve": {**CURVE, "reference": str(reference)}})
    runs = plan(study)
    results = {run.name: {"angle_rotor_[rad]": 0.3 * k} for k, run in enumerate(runs, start=1)}
    figures = []
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", keep_figure(figures))
    plot_curve(study, runs, results, folder / "curve.png")
    (axes,) = figures[0].axes
    assert axes.get_xlabel() == "time end [s]"
    assert axes.get_ylabel() == "angle rotor [°]"
    assert axes.get_ylim()[0] == 0.0
    assert (folder / "curve.png").read_bytes()[:4] == b"\x89PNG"


def test_all_points_of_a_curve_are_in_the_picture(folder, monkeypatch):
    study = Study.parse({**STUDY, "curve": {**CURVE, "y": ["angle_pitch_1", "power"]}})
    runs = plan(study)
    results = {
        run.name: {"angle_pitch_1_[rad]": -0.1 * k, "power_[W]": 5.0 - 4.0 * k}
        for k, run in enumerate(runs)
    }
    figures = []
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", keep_figure(figures))
    plot_curve(study, runs, results, folder / "curve.png")
    pitch, power = figures[0].axes
    for axes, values in (
        (pitch, np.degrees(0.1 * np.arange(len(runs)))),  # positive to feather
        (power, 5.0 - 4.0 * np.arange(len(runs))),
    ):
        (dots,) = axes.lines
        assert dots.get_ydata() == pytest.approx(values)
        low, high = axes.get_ylim()
        assert low <= values.min() and values.max() <= high

"""Diagrams of a turbine in wind show its power, thrust, speed and pitch."""

import importlib.util

import numpy as np
import pytest
from outputs import history, write

from turbine_fenicsx.postprocessing import plots, wind_panels
from turbine_fenicsx.postprocessing.report import report
from turbine_fenicsx.records.output_folder import read_histories, read_history

pytestmark = [
    pytest.mark.filterwarnings("ignore:Unable to import Axes3D"),
    pytest.mark.skipif(
        importlib.util.find_spec("matplotlib") is None, reason="Matplotlib, which draws, is missing"
    ),
]
JOINTS = ("yaw", "rotor", "pitch_1", "pitch_2", "pitch_3")


def in_wind(angles=JOINTS, generator="generator"):
    """Columns of a run in wind, the generator taking 4 MW."""
    columns = history(angles=angles)
    t = columns["time_[s]"]
    return {
        **columns,
        "aero_power_[W]": 4e6 + 1e5 * np.sin(t),
        "aero_thrust_[N]": 5e5 + 0.0 * t,
        "aero_torque_[Nm]": 3e6 + 0.0 * t,
        "hub_wind_x_[m/s]": 11.0 + 0.0 * t,
        f"work_of_{generator}_[J]": -4e6 * t,
    }


def draw(runs, path):
    """Titles of the panels, and their lines by label."""
    found = {}

    def watched(panel):
        def shown(axes, run, look):
            panel(axes, run, look)
            lines = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
            found[axes.get_title("left")] = (axes.get_ylabel(), lines)

        return shown

    panels = plots.choose_figures(runs)["wind"]
    plots.draw(runs, [watched(panel) for panel in panels], [path])
    return found


@pytest.mark.parametrize("generator", ["generator", "motion_of_rotor"])
def test_power_of_the_air_stands_beside_that_of_the_generator(tmp_path, generator):
    columns = in_wind(generator=generator)
    run = read_history(write(tmp_path / "run" / "history.csv", columns))
    found = draw([run], tmp_path / "a.png")
    assert list(found) == ["Wind at the hub", "Power", "Thrust", "Rotor speed", "Pitch", "Torque"]
    label, lines = found["Power"]
    assert label == "power [W]"
    assert np.allclose(lines["of the air"], columns["aero_power_[W]"])
    assert np.allclose(lines["of the generator"][1:], 4e6)
    assert np.allclose(found["Pitch"][1]["pitch 1"], -np.degrees(columns["angle_pitch_1_[rad]"]))


def test_round_off_of_a_locked_bearing_is_no_pitch(tmp_path):
    columns = in_wind()
    columns["angle_pitch_2_[rad]"] = 1e-23 * np.arange(61.0)
    run = read_history(write(tmp_path / "run" / "history.csv", columns))
    assert not np.any(draw([run], tmp_path / "a.png")["Pitch"][1]["pitch 2"])


def test_several_runs_are_told_apart_and_one_without_wind_has_no_such_figure(tmp_path):
    for name in ("a", "b"):
        write(tmp_path / name / "history.csv", in_wind(angles=("yaw", "rotor")))
    write(tmp_path / "calm" / "history.csv", history())
    runs = read_histories([tmp_path / name for name in ("a", "b", "calm")])
    found = draw(runs[:2], tmp_path / "a.png")
    assert set(found) == {"Wind at the hub", "Power", "Thrust", "Rotor speed"}
    assert list(found["Power"][1]) == ["a", "b"]
    assert "wind" not in plots.choose_figures(runs)


def test_the_summary_of_a_run_in_wind_shows_it(tmp_path):
    path = write(tmp_path / "run" / "history.csv", in_wind())
    shown = []
    original = wind_panels.power

    def power(*given):
        shown.append(given)
        original(*given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wind_panels, "power", power)
        plots.plot_summary(path, tmp_path / "s.png")
    assert shown and (tmp_path / "s.png").exists()


def test_the_report_of_a_run_in_wind_tells_what_its_diagrams_show(tmp_path):
    columns = in_wind()
    path = write(
        tmp_path / "history.csv", {**columns, "work_of_wind_[J]": 5e6 * columns["time_[s]"]}
    )
    assert {"wind", "power_balance"} <= set(plots.choose_figures([read_history(path)]))
    page = report(tmp_path)
    assert "mechanical power of the generator" in page and "comes back" in page
